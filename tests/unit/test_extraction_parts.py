"""Single steps of extraction: noise model, erosion, border, room planes."""

from dataclasses import replace

import numpy as np
import pytest

from roomkin.stages.config.inputs import DepthNoiseConfig
from roomkin.stages.contracts.objects import USUAL_ERROR, DepthError, Wall, object_ids
from roomkin.stages.extraction import clouds, noise
from roomkin.stages.extraction.clouds import clean_cloud, continue_depth
from roomkin.stages.extraction.contact import DepthView, extend_to_wall, find_touched_walls
from roomkin.stages.extraction.mounting import find_carrier
from roomkin.stages.extraction.noise import blur_outlines, noisy_depth, periphery_ramp
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.masks import central_crop, erode, remove_specks
from roomkin.stages.geometry.room_planes import (
    PLANE_THRESHOLD,
    WallPlane,
    find_walls,
    fit_wall,
    merge_walls,
    scale_threshold,
)

DOWN = np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 9], [0, 0, 0, 1]])
FROM_ABOVE = DepthView(np.zeros((9, 9)), np.array([[900.0, 0, 4], [0, 900, 4], [0, 0, 1]]), DOWN)
QUIET = DepthNoiseConfig(range_constant=0, range_quadratic=0, scale=0)


@pytest.fixture
def _no_outlines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise, "blur_outlines", lambda depth: depth)
    monkeypatch.setattr(noise, "PERIPHERY", 0.0)


@pytest.fixture
def _no_outliers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clouds, "MAX_DEVIATIONS", 50)


def _rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.mark.usefixtures("_no_outlines")
def test_all_noise_off_changes_nothing() -> None:
    depth = np.linspace(1, 5, 48 * 64, dtype=np.float32).reshape(48, 64)
    np.testing.assert_allclose(noisy_depth(depth, QUIET, _rng()), depth, rtol=1e-6)


@pytest.mark.parametrize(("z", "sigma"), [(1.0, 0.0045), (3.0, 0.0165), (8.0, 0.099)])
@pytest.mark.usefixtures("_no_outlines")
def test_range_noise_has_the_documented_size(z: float, sigma: float) -> None:
    options = QUIET.model_copy(update={"range_constant": 0.003, "range_quadratic": 0.0015})
    depth = np.full((200, 300), z, np.float32)
    assert (noisy_depth(depth, options, _rng()) - depth).std() == pytest.approx(sigma, rel=0.02)


def test_bleeding_stays_at_the_outline() -> None:
    depth = np.full((40, 60), 2.0, np.float32)
    depth[:, 30:] = 4.0
    changed = np.abs(blur_outlines(depth) - depth) > 1e-6
    assert changed[:, 29:31].all() and not changed[:, :26].any() and not changed[:, 34:].any()


def test_bleeding_is_also_of_what_is_near() -> None:
    """Less than a metre away, beside what nobody knows: that stays unknown, and takes nothing from what is known."""
    depth = np.full((40, 60), 0.5, np.float32)
    depth[:, 30:] = 0.9
    depth[:10] = 0
    blurred = blur_outlines(depth)
    assert 0.5 < blurred[20, 29] < 0.7 < blurred[20, 30] < 0.9
    assert not blurred[:10].any() and blurred[10, :20] == pytest.approx(0.5)


def test_periphery_is_quiet_in_the_middle() -> None:
    ramp = periphery_ramp((100, 100))
    assert ramp[50, 50] == 0 and ramp[15, 50] == 0 and ramp[0, 50] == pytest.approx(1)


def test_unknown_depth_stays_unknown() -> None:
    depth = np.full((50, 50), 2.0, np.float32)
    depth[10:20, 10:20] = 0
    noisy = noisy_depth(depth, DepthNoiseConfig(), _rng())
    np.testing.assert_array_equal(noisy == 0, depth == 0)


def test_central_crop() -> None:
    assert central_crop((100, 200), 0.9).sum() == 90 * 180
    assert central_crop((100, 200), 1.0).all()


def test_erosion_spares_small_masks() -> None:
    large = np.zeros((50, 50), bool)
    large[10:40, 10:40] = True
    assert erode(large, 0.5).sum() < large.sum()
    assert not erode(large, 0.5)[10].any()
    pole = np.zeros((50, 50), bool)
    pole[10:40, 20:23] = True
    np.testing.assert_array_equal(erode(pole, 0.5), pole)


def test_specks_go() -> None:
    mask = np.zeros((50, 50), bool)
    mask[5:30, 5:30] = True
    mask[45, 45] = True
    mask[40:48, 10:18] = True  # a tenth of it, cut off by something in front
    assert remove_specks(mask).sum() == 25 * 25 + 8 * 8


def test_border_depth_of_a_slanted_plane_is_exact() -> None:
    v, u = np.mgrid[:60, :80]
    depth = 1 / (0.3 + 0.002 * u - 0.001 * v)
    core, border = np.zeros((60, 80), bool), np.zeros((60, 80), bool)
    core[20:40, 20:60] = True
    border[18:42, 18:62] = True
    found = continue_depth(depth, core, border)
    np.testing.assert_allclose(found[border], depth[border], rtol=2e-3)
    assert (found[~border] == 0).all()


def test_cleaning_drops_flyers_and_keeps_both_halves() -> None:
    rng = _rng()
    halves = [rng.uniform([x, 0, 0], [x + 0.3, 0.3, 0.02], (1500, 3)) for x in (0.0, 0.6)]
    flyers = rng.uniform(-2, 2, (30, 3))
    cloud = clean_cloud(np.vstack([*halves, flyers]), FROM_ABOVE, rng)
    assert np.abs(cloud).max() < 1.0
    assert (cloud[:, 0] < 0.3).any() and (cloud[:, 0] > 0.6).any()


@pytest.mark.parametrize(("count", "kept"), [(12, False), (200, True)])
@pytest.mark.usefixtures("_no_outliers")
def test_small_clusters_go(count: int, kept: bool) -> None:
    """Points of something else, 20 cm beside the object, stay only if they are many."""
    rng = _rng()
    points = rng.uniform(0, [0.6, 0.6, 0.02], (4000, 3))
    clump = rng.uniform([0.8, 0.3, 0.0], [0.83, 0.33, 0.03], (count, 3))
    cloud = clean_cloud(np.vstack([points, clump]), FROM_ABOVE, rng)
    assert bool((cloud[:, 0] > 0.7).any()) == kept


def test_parts_of_a_wall_are_one_wall() -> None:
    rng = _rng()
    left = np.c_[np.full(2000, 3.0), rng.uniform(-2, -1, 2000), rng.uniform(0, 2, 2000)]
    right = left + np.array([0.03, 3.0, 0.0])
    side = np.c_[rng.uniform(0, 3, 2000), np.full(2000, 2.0), rng.uniform(0, 2, 2000)]
    fits = [fit_wall(part, 1.6, rng) for part in (left, right, side)]
    walls, places = merge_walls([fit for fit in fits if fit is not None])
    assert len(walls) == 2 and places == [0, 0, 1]
    assert walls[0].inliers == 4000
    np.testing.assert_allclose(walls[0].normal, [-1, 0, 0], atol=1e-3)
    assert walls[0].offset == pytest.approx(-3.015, abs=2e-3)


@pytest.mark.parametrize(("seen", "offsets"), [(2000, [-3.0, -2.0]), (0, [-2.4, -2.0])])
def test_what_has_a_wall_behind_it_is_no_wall(seen: int, offsets: list[float]) -> None:
    """Two walls of a corner that nobody named, and a front: a wall itself if nothing is seen behind it."""
    rng = _rng()
    back = np.c_[np.full(seen, 3.0), rng.uniform(-2, 2, seen), rng.uniform(0, 2.5, seen)]
    side = np.c_[rng.uniform(0, 2.4, 2000), np.full(2000, 2.0), rng.uniform(0, 2.5, 2000)]
    front = np.c_[np.full(900, 2.4), rng.uniform(-1, 0, 900), rng.uniform(0, 1, 900)]
    floor = np.c_[rng.uniform(0, 2.4, 2000), rng.uniform(-2, 2, 2000), np.zeros(2000)]
    points = np.vstack([back, side, front, floor])
    free = np.arange(len(points)) < len(points) - len(floor)
    walls = find_walls(points, free, 1.6, rng)
    assert sorted(round(offset, 2) for _, offset, _ in walls) == offsets


def test_points_far_away_may_be_farther_off_their_plane() -> None:
    off = [scale_threshold(np.full((5, 3), away / np.sqrt(3))) for away in (1.0, 3.0, 6.0)]
    assert off == pytest.approx([PLANE_THRESHOLD, PLANE_THRESHOLD, 2 * PLANE_THRESHOLD])


def test_what_is_seen_edge_on_is_no_wall() -> None:
    rng = _rng()
    edge = np.c_[rng.uniform(1, 2, 2000), np.full(2000, 0.06), rng.uniform(0, 1, 2000)]
    assert not find_walls(edge, np.ones(2000, dtype=bool), 1.6, rng)


def test_ids_count_per_label() -> None:
    labels = ["Wall Cabinet", "mug", "wall-cabinet", "???"]
    ids = object_ids(labels)
    assert ids == ["wall_cabinet_1", "mug_1", "wall_cabinet_2", "object_1"]


def test_parts_of_a_wall_count_by_their_points() -> None:
    turn = np.deg2rad(8.0)
    fits = [
        WallPlane(np.array([-1.0, 0.0, 0.0]), -3.0, 3000),
        WallPlane(np.array([-np.cos(turn), np.sin(turn), 0.0]), -3.1, 1000),
    ]
    fits.append(WallPlane(np.array([-1.0, 0.0, 0.0]), -5.0, 500))  # of the next room
    (wall, _), places = merge_walls(fits)
    assert places == [0, 0, 1]
    assert np.arctan2(wall.normal[1], -wall.normal[0]) == pytest.approx(turn / 4, rel=0.01)
    assert wall.offset == pytest.approx(-3.025)


@pytest.mark.parametrize(("x", "touched"), [(3.7, True), (3.2, False), (4.5, False)])
def test_what_is_behind_a_free_standing_wall_does_not_touch_it(x: float, touched: bool) -> None:
    """The wall x = 4 as seen from x = 0; a box 0.6 m deep at it, well before it, and behind it."""
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), np.eye(4), USUAL_ERROR)
    box = UprightBox([x, 0, 0.5], [0.6, 0.6, 1.0], 0.0)
    found = find_touched_walls(box, [], [wall], empty, np.zeros((9, 9), bool), 0.0)  # nothing hidden counts
    assert bool(found) == touched


def test_what_something_else_fills_is_no_hidden_gap_and_what_is_behind_a_wall_is_not_extended_to_it() -> None:
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), np.eye(4), USUAL_ERROR)
    stool, own = UprightBox([3.35, 0.0, 0.5], [0.3, 0.5, 1.0], 0.0), np.zeros((9, 9), bool)  # 50 cm before it
    behind_it = UprightBox([3.8, 0.1, 0.5], [0.4, 0.6, 1.0], 0.0)
    found = [find_touched_walls(stool, others, [wall], empty, own) for others in ([], [behind_it])]
    assert found == [[wall], []]
    assert extend_to_wall(stool, wall).size[0] == pytest.approx(0.8)
    beyond = UprightBox([4.6, 0.0, 0.5], [0.3, 0.5, 1.0], 0.0)
    assert extend_to_wall(beyond, wall) is beyond


@pytest.mark.parametrize(("error", "free"), [(DepthError(0.0, 0.0), 0.0), (DepthError(0.01, 0.0025), 1.0)])
def test_what_is_nearer_by_no_more_than_depth_errs_hides_nothing(error: DepthError, free: float) -> None:
    view = DepthView(np.full((9, 9), 5.0, np.float32), np.array([[9.0, 0, 4], [0, 9.0, 4], [0, 0, 1]]), error=error)
    assert view.share_free(np.array([[0.1, 0.2, 5.1], [0.0, 0.0, 5.1]]), np.zeros((9, 9), bool)) == free


def test_a_can_beside_a_bowl_does_not_stand_on_it() -> None:
    bowl, table = (
        UprightBox([0.0, 0.0, 0.02], [0.14, 0.14, 0.04], 0.0),
        UprightBox([0.0, 0.0, -0.3], [1.0, 1.0, 0.6], 0.0),
    )
    can = UprightBox([0.11, 0.0, 0.05], [0.065, 0.065, 0.1], 0.0)
    both = {"table": table, "bowl": bowl}
    assert find_carrier(can, both, 0.06) == (table.top, "table")
    inside = replace(can, center=[0.02, 0.0, 0.07])
    assert find_carrier(inside, both, 0.06) == (bowl.top, "bowl")


def test_a_can_that_is_seen_far_down_a_bowl_is_in_it_not_on_it() -> None:
    bowl = UprightBox([0.0, 0.0, 0.04], [0.15, 0.15, 0.08], 0.0)
    can = UprightBox([0.0, 0.0, 0.06], [0.06, 0.06, 0.09], 0.0)  # from 1.5 to 10.5 cm
    assert find_carrier(can, {"bowl": bowl}, 0.06, sunk=0.03) == (can.bottom, "bowl")
    assert find_carrier(can, {"bowl": bowl}, 0.06, sunk=0.08)[0] == bowl.top  # far away, depth may err by as much
    plate = UprightBox([0.0, 0.0, 0.07], [0.1, 0.1, 0.03], 0.0)  # 2.5 cm into the top
    assert find_carrier(plate, {"bowl": bowl}, 0.06, sunk=0.03) == (bowl.top, "bowl")


def test_a_rug_does_not_stand_on_the_crate_that_stands_on_it() -> None:
    """Its top is within the tolerances of the rug's foot, but the crate's middle is above the rug's."""
    crate, rug = UprightBox([0.0, 0.0, 0.05], [0.5, 0.5, 0.1], 0.0), UprightBox([0.0, 0.0, 0.01], [0.6, 0.6, 0.02], 0.0)
    assert find_carrier(rug, {"crate": crate}, 0.06) == (0.0, "floor")
    assert find_carrier(crate, {"rug": rug}, 0.06) == (rug.top, "rug")


@pytest.mark.parametrize("names", [("wall_1", "wall_2"), ("wall_2", "wall_1")])
def test_in_a_corner_a_thing_leans_on_the_wall_that_its_wider_side_is_at(names: tuple[str, str]) -> None:
    """A shelf 1.2 m wide and 0.3 m deep, its rear at x = 4 and its side at y = 2."""
    rear = Wall(id=names[0], normal=(-1, 0, 0), offset=-4.0, points=100)
    side = Wall(id=names[1], normal=(0, -1, 0), offset=-2.0, points=100)
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), np.eye(4), USUAL_ERROR)
    box, own = UprightBox([3.84, 1.39, 0.5], [0.3, 1.2, 1.0], 0.0), np.zeros((9, 9), bool)
    for walls in ([rear, side], [side, rear]):
        assert find_touched_walls(box, [], walls, empty, own) == [rear, side]
