"""Yaw and extents of a placed asset: known answers."""

from dataclasses import replace

import numpy as np
import pytest

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.cousins import Orientation
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.generation.placing import reaches_walls
from roomkin.stages.generation.turning import (
    find_wall_axes,
    measure_rectangularity,
    pick_rear_at_wall,
    prefer_front,
    turn_to,
)
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import view_yaw, wrap_angle, yaw_matrix
from tests.unit.generation_scenes import thing

DEGREE = np.pi / 180


@pytest.mark.parametrize(
    ("center", "psi", "expected"),
    [
        ((3, 0, 0), 0.0, 180),  # straight ahead, front to the camera: looks back along -x
        ((3, 0, 0), 90 * DEGREE, -90),
        ((0, 3, 0), 0.0, -90),  # to the left, still facing the camera
        ((3, 3, 0), 0.0, -135),
        ((3, -3, 1), 45 * DEGREE, 180),
    ],
)
def test_view_yaw(center, psi, expected):
    assert wrap_angle(view_yaw((0, 0, 1.6), center, psi) - expected * DEGREE) == pytest.approx(0, abs=1e-9)


def test_turned_to_the_nearest_quarter_of_the_frame():
    assert turn_to(100 * DEGREE, 5 * DEGREE) == pytest.approx(95 * DEGREE)
    assert turn_to(-80 * DEGREE, 5 * DEGREE) == pytest.approx(-85 * DEGREE)
    assert turn_to(175 * DEGREE, -3 * DEGREE) == pytest.approx(177 * DEGREE)


def test_a_turn_beyond_the_limit_is_not_made():
    assert turn_to(30 * DEGREE, 0.0, 20 * DEGREE) == pytest.approx(30 * DEGREE)
    assert turn_to(19 * DEGREE, 0.0, 20 * DEGREE) == pytest.approx(0, abs=1e-12)
    assert turn_to(30 * DEGREE, 0.0, None) == pytest.approx(0, abs=1e-12)


def test_wall_axes_is_the_angle_of_the_normal():
    assert find_wall_axes((-1, 0, 0)) == pytest.approx(np.pi)
    assert turn_to(170 * DEGREE, find_wall_axes((-1, 0, 0))) == pytest.approx(np.pi)


def test_of_several_views_the_one_with_its_rear_to_the_wall():
    back, side = (-1, 0, 0), (0, 1, 0)  # normals of two walls; fronts look along them
    assert pick_rear_at_wall([0.0, 1.5, 3.0], [back]) == 3.0
    assert pick_rear_at_wall([0.0, 1.5, 3.0], [back, side]) == 1.5
    assert pick_rear_at_wall([0.0, 0.5], [back]) == 0.0
    assert pick_rear_at_wall([0.4, 0.5], []) == 0.4


def test_rectangularity_tells_boxes_from_round_things():
    rng = np.random.default_rng(0)
    square = rng.uniform(-0.5, 0.5, (4000, 3)) @ yaw_matrix(0.3).T
    angle, radius = rng.uniform(0, 2 * np.pi, 4000), 0.5 * np.sqrt(rng.uniform(0, 1, 4000))
    disc = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(4000)], axis=1)
    corner = np.array([(x, 0, 0) for x in np.linspace(0, 1, 200)] + [(0, y, 0) for y in np.linspace(0, 1, 200)])
    assert measure_rectangularity(square, 0.3) > 0.85
    assert measure_rectangularity(square, 0.3 + np.pi / 4) < 0.2
    assert measure_rectangularity(disc, 0.0) < 0.4
    assert 0.5 < measure_rectangularity(corner, 0.0) < 0.65
    assert measure_rectangularity(np.zeros((5, 3)), 0.0) == 0.0


def test_what_stands_on_furniture_or_is_round_is_not_extended_to_the_wall():
    low, high = UprightBox((3.5, 0, 0.4), (0.4, 0.4, 0.8), 0.0), UprightBox((3.5, 0, 1.0), (0.4, 0.4, 0.4), 0.0)
    stands, hangs = Mounting(type=3, walls=["wall_1"]), Mounting(type=1, walls=["wall_1"])
    assert reaches_walls(stands, low, False)
    assert not reaches_walls(stands, high, False)
    assert not reaches_walls(stands, low, True)
    assert reaches_walls(hangs, high, False)


@pytest.mark.parametrize(
    ("size", "stays"),
    [((0.9, 2.2, 0.8), True), ((1.1, 2.0, 1.0), True), ((0.4, 0.4, 0.5), False), ((0.3, 0.73, 0.27), False)],
)
def test_a_sofa_is_no_stool(size, stays):
    box = UprightBox((0, 0, 0), size, 0.0)
    assert (replace(thing("sofa", (0, 0, 0), (0.9, 2.2, 0.8)), box=box).stretch <= 2.0) == stays


@pytest.mark.parametrize(
    ("degrees", "scores", "category", "seen"),
    [
        ((180, 5), (1.0, 0.95), "sofa", 5),  # as well: the front
        ((180, 5), (1.0, 0.5), "sofa", 180),  # seen from behind
        ((180, 5), (1.0, 0.5), "wardrobe", 5),  # nobody sees its rear
        ((180, 5), (1.0, 0.5), "television", 5),
        ((180, 5), (1.0, 0.5), None, 180),
        ((180, 5), (None, None), "picture", 5),
        ((180, 5), (None, None), "chair", 180),  # no judge says how well they fit
        ((120, 85, -50), (1.0, 1.0, 1.0), "chair", -50),  # the opposite one alone
        ((60, -120), (1.0, 1.1), "chair", 60),  # a front already
        ((180,), (1.0,), "wardrobe", 180),  # as a person says
    ],
)
def test_a_front_that_fits_as_well_as_the_rear_is_what_is_seen(
    degrees: tuple[float, ...], scores: tuple[float | None, ...], category: str | None, seen: float
) -> None:
    views = [Orientation(yaw=np.deg2rad(each), score=score) for each, score in zip(degrees, scores, strict=True)]
    found = prefer_front(views, known_categories().get(category or ""))
    assert np.rad2deg(found[0].yaw) == pytest.approx(seen)
