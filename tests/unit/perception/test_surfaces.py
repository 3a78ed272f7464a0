"""Ground, walls and ceiling by geometry."""

import numpy as np
import pytest

from roomkin.stages.geometry.room_planes import WallPlane
from roomkin.stages.perception.camera.surfaces import is_wall
from tests.unit.perception.room_with_depth import CAMERA, ON_TABLE, TABLE, see_room


@pytest.mark.parametrize("noise", [0.0, 0.0015])
def test_the_floor_is_found_below_a_table_and_the_wall_behind_it(noise: float) -> None:
    view, (table,) = see_room(TABLE, noise=noise)
    surfaces = view.surfaces
    assert abs(surfaces.frame[2, 3] - CAMERA) < 0.02
    (wall,) = surfaces.walls
    assert abs(wall.offset + 4.0) < 0.03 and wall.normal @ [-1, 0, 0] > 0.999
    assert surfaces.floor[~table][: 200 * 320].any() and not (surfaces.floor & table).any()
    assert surfaces.below < 0.001


def test_hardly_any_floor_will_do() -> None:
    """Low furniture hides most of it, and its tops are larger."""
    view, boxes = see_room(((2.1, -3.0, 0.0), (4.0, 3.0, 0.45)), ((1.5, -3.0, 0.0), (2.1, 0.3, 0.45)))
    assert np.any([view.surfaces.beyond, *boxes], axis=0).mean() > 0.9
    assert abs(view.surfaces.frame[2, 3] - CAMERA) < 0.03


def test_the_front_of_a_wardrobe_is_no_wall() -> None:
    view, (wardrobe,) = see_room(((3.3, -1.2, 0.0), (4.0, 0.2, 2.4)))
    (wall,) = view.surfaces.walls
    assert abs(wall.offset + 4.0) < 0.05
    assert (view.surfaces.beyond & wardrobe).mean() < 0.01


def test_without_a_wall_there_is_none() -> None:
    view, _ = see_room(TABLE, wall=None)
    assert view.surfaces.walls == []


def test_what_is_behind_a_wall_is_told() -> None:
    """Through a narrow door in a wall of two parts, a table is seen."""
    parts = ((3.0, -4.0, 0.0), (3.1, -0.2, 3.0)), ((3.0, 0.2, 0.0), (3.1, 4.0, 3.0))
    view, (_, _, table) = see_room(*parts, ((3.9, -1.0, 0.0), (4.5, 1.0, 0.7)), wall=6.0)
    assert abs(view.surfaces.walls[0].offset + 3.0) < 0.05
    assert view.surfaces.beyond[table].mean() > 0.8  # the rest is near the ground


def test_a_near_table_top_is_the_ground() -> None:
    view, (_, mug) = see_room(((0.3, -0.8, 0.7), (1.6, 0.8, 0.75)), ((0.9, -0.1, 0.75), (1.0, 0.0, 0.85)), wall=1.95)
    assert abs(view.surfaces.frame[2, 3] - (CAMERA - 0.75)) < 0.02
    assert (view.surfaces.floor & ~view.surfaces.ground).any()  # the real floor, below it
    assert np.abs(view.surfaces.points[view.surfaces.ground][:, 2]).max() < 0.05
    assert not (view.surfaces.floor & mug).any() or (view.surfaces.floor & mug).sum() < 0.3 * mug.sum()


def test_equal_pictures_give_equal_surfaces() -> None:
    one, other = (see_room(TABLE, ON_TABLE, noise=0.002)[0].surfaces for _ in range(2))
    assert np.array_equal(one.floor, other.floor) and np.array_equal(one.beyond, other.beyond)


@pytest.mark.parametrize(
    ("distance", "off", "area", "is_one"),
    [(6.0, 0.15, 0.6, True), (6.0, 0.15, 0.3, False), (6.0, 0.6, 0.6, False), (2.0, 0.15, 0.6, False)],
)
def test_of_a_far_wall_less_is_flat_and_less_exactly_there(
    distance: float, off: float, area: float, is_one: bool
) -> None:
    rng = np.random.default_rng(0)
    across, up = rng.uniform(-1, 1, 2000), rng.uniform(0, 2.3, 2000)
    points = np.stack([np.full(2000, distance), across, up], axis=1)
    cells = points[:20] + np.array([off, 0, 0])
    wall = WallPlane(np.array([-1.0, 0.0, 0.0]), -distance, 2000)
    assert is_wall(wall, points, cells, np.full(20, area / 20)) == is_one
