"""What belongs to an object's cloud: nothing that is seen past it or through it, all that is cut off from it."""

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.extraction.clouds import make_object_cloud
from roomkin.stages.extraction.contact import DepthView
from roomkin.stages.geometry.masks import erode

HEIGHT, WIDTH, FOCAL = 240, 320, 140.0
LENS = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])
LOOKING_ALONG_X = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1.0]])
V, U = np.mgrid[:HEIGHT, :WIDTH]
SIDE, RISE = -(U - WIDTH / 2) / FOCAL, -(V - HEIGHT / 2) / FOCAL  # of the rays, per metre along x


def cloud_of(
    depth: NDArray[np.float64], mask: NDArray[np.bool_], options: ExtractionConfig | None = None
) -> NDArray[np.float64]:
    view = DepthView(depth, LENS, LOOKING_ALONG_X)
    return make_object_cloud(mask, view, options or ExtractionConfig(), np.random.default_rng(0))


@pytest.mark.parametrize("restored", [True, False])
def test_depth_along_an_outline_is_never_trusted_and_its_pixels_are_restored_if_wanted(restored: bool) -> None:
    face = (np.abs(2 * SIDE) < 0.5) & (np.abs(2 * RISE) < 0.3)
    depth = np.where(face & ~erode(face), 2.05, 2.0)
    cloud = cloud_of(depth, face, ExtractionConfig(restore_border=restored))
    assert cloud[:, 0] == pytest.approx(2.0)
    assert np.ptp(cloud[:, 1]) == pytest.approx(0.94 if restored else 0.89, abs=0.02)


@pytest.mark.parametrize(("wall", "gone"), [(4.0, True), (2.45, True), (2.1, False)])  # the last may be the pot's rear
def test_a_wall_that_is_seen_through_a_handle_is_no_part_of_a_pot(wall: float, gone: bool) -> None:
    far = np.hypot(U - 160, V - 120)
    pot = ((far < 30) & (far > 17)) | ((np.abs(U - 115) < 20) & (np.abs(V - 120) < 40))
    cloud = cloud_of(np.where(pot, 2.0, wall), pot | (far < 30))
    assert (cloud[:, 0] < 2.01).sum() > 1000
    assert bool((cloud[:, 0] > 2.01).any()) is not gone


def test_the_shade_and_the_foot_of_a_lamp_are_one_thing_though_its_pole_has_no_depth() -> None:
    shade = (np.abs(2 * SIDE) < 0.2) & (np.abs(1.45 - (1.5 + 2 * RISE)) < 0.15)
    on_floor = np.where(RISE < 0, -1.48 / np.minimum(RISE, -1e-9), 99.0)  # the top of its foot, 2 cm high
    foot = np.hypot(on_floor - 2.0, on_floor * SIDE) < 0.15
    pole = (np.abs(2 * SIDE) < 0.02) & (V > 120) & ~shade & ~foot
    cloud = cloud_of(np.select([shade, foot], [2.0, on_floor], 0.0), shade | foot | pole)
    assert cloud[:, 2].min() < 0.05 and cloud[:, 2].max() > 1.5


def test_the_back_of_a_chair_stays_where_the_depth_of_its_seat_is_not_known() -> None:
    """Its front edge at 2 m, 45 cm high, and its back 40 cm farther, a dark seat between."""
    edge = (np.abs(2.0 * SIDE) < 0.25) & (np.abs(1.5 + 2.0 * RISE - 0.4) < 0.05)
    back = (np.abs(2.4 * SIDE) < 0.25) & (np.abs(1.5 + 2.4 * RISE - 0.75) < 0.15)
    seat = (np.abs(2.2 * SIDE) < 0.25) & (RISE < -0.3) & (RISE > -0.55) & ~edge & ~back
    cloud = cloud_of(np.select([edge, back], [2.0, 2.4], 0.0), edge | back | seat)
    assert cloud[:, 0].min() < 2.05 and cloud[:, 0].max() > 2.35


def test_a_long_cupboard_that_a_pillar_cuts_in_two_is_whole() -> None:
    """Its front runs from 2 m to 4 m; of it 50 cm are hidden."""
    front = 2.0 / (1 - 1.5 * np.minimum(SIDE, 0.6))  # the plane x = 2 + 1.5 y
    shown = (SIDE > 0) & (front < 4.0) & (np.abs(1.5 + front * RISE - 1.0) < 0.4)
    hidden = (front > 2.9) & (front < 3.4)
    cloud = cloud_of(np.where(hidden, 1.0, np.where(shown, front, 5.0)), shown & ~hidden)
    assert cloud[:, 0].min() < 2.2 and cloud[:, 0].max() > 3.7
