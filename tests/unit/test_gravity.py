"""Up and what is level in a picture: floors, tables, seats; walls and ceilings are neither."""

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import back_project
from roomkin.stages.geometry.levels import find_floor, find_levels
from roomkin.stages.geometry.room_planes import estimate_up, find_up, is_upside_down
from tests.unit.synthetic_room import HEIGHT, INTRINSICS, OBJECT, WIDTH, WORLD_FROM_CAMERA, trace

UP = WORLD_FROM_CAMERA[2, :3]
TABLE, BED = UprightBox([2.4, 0.3, 0.65], [0.9, 1.6, 0.1], 0.2), UprightBox([2.6, -0.9, 0.25], [1.0, 1.0, 0.5], 0.0)
CAMERA_HEIGHT = 1.6


def seen(boxes: list[UprightBox], noise: float = 0.0) -> tuple[NDArray, NDArray]:
    """Points (H, W, 3) of a room, camera frame, and its masks."""
    depth, masks = trace(boxes)
    rough = np.random.default_rng(0).normal(0, noise, depth.shape) * depth**2
    return back_project(np.where(depth > 0, depth + rough, 0), INTRINSICS), masks


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_up_is_where_surfaces_are_level_or_upright(noise: float) -> None:
    points, masks = seen([TABLE, BED], noise)
    up = find_up(points, masks > 0, 60.0)
    assert up is not None and up @ UP > np.cos(np.deg2rad(1.5))


def test_slopes_are_not_level() -> None:
    """More than half of what is seen leans, as cushions do."""
    rng = np.random.default_rng(0)
    leaning = rng.normal([0, -1, -1.2], 0.3, (600, 3))
    normals = np.concatenate([leaning, np.tile(UP, (300, 1)), np.tile(-WORLD_FROM_CAMERA[0, :3], (200, 1))])
    normals += rng.normal(0, 0.02, normals.shape)
    up = estimate_up(normals / np.linalg.norm(normals, axis=1, keepdims=True), 60.0)
    assert up is not None and up @ UP > np.cos(np.deg2rad(2.0))


def test_two_walls_alone_tell_up_and_nothing_tells_none() -> None:
    walls = np.concatenate([np.tile([1.0, 0, 0], (50, 1)), np.tile([0, 0.1, -0.995], (50, 1))])
    up = estimate_up(walls, 60.0)
    assert up is not None and up @ [0, -0.995, -0.1] > 0.999
    assert estimate_up(np.zeros((0, 3)), 60.0) is None


def test_levels_are_floor_table_and_bed_by_height() -> None:
    points, masks = seen([TABLE, BED], 0.002)
    levels = find_levels(points, masks > 0, UP)
    heights = sorted(CAMERA_HEIGHT + level.offset for level in levels)
    assert heights == pytest.approx([0.0, 0.5, 0.7], abs=0.01)
    assert len(levels[0].inliers) == (masks > 0).sum()


def test_the_floor_is_the_lowest_level_or_what_most_things_stand_on() -> None:
    cups = [UprightBox([2.3, y, 0.78], [0.1, 0.1, 0.16], 0.0) for y in (0.0, 0.5)]
    points, masks = seen([TABLE, BED, *cups])
    known = masks > 0
    for objects, height in (([], 0.0), ([points[masks == OBJECT + k] for k in (2, 3)], 0.7)):
        found = find_floor(points, known, known & (masks < OBJECT + 2), objects, find_up(points, known, 60.0))
        assert found is not None and CAMERA_HEIGHT + found.offset == pytest.approx(height, abs=0.01)
        assert found.normal @ UP > np.cos(np.deg2rad(1.0))


def test_a_ceiling_is_no_floor() -> None:
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(INTRINSICS).T
    rise = rays @ UP
    known = rise > 0.05
    ceiling = rays * np.where(known, 1.0 / np.maximum(rise, 0.05), 0.0)[..., None]
    assert known.any() and find_floor(ceiling, known, known, [], find_up(ceiling, known, 60.0)) is None


def test_a_picture_upside_down_shows_no_level_that_faces_up() -> None:
    points, masks = seen([TABLE, BED], 0.002)
    assert not is_upside_down(points, masks > 0, 75.0)
    assert is_upside_down(points * [1, -1, 1], masks > 0, 75.0)
    assert is_upside_down(np.flip(points, 0) * [1, -1, 1], np.flip(masks, 0) > 0, 75.0)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(INTRINSICS).T
    rise = rays @ [0, -np.cos(0.17), np.sin(0.17)]  # the camera looks up: more is seen of the ceiling than of the floor
    along = np.where(np.abs(rise) > 0.05, np.where(rise > 0, 1.0, -1.6) / np.where(rise == 0, 1, rise), 0)
    shown = rays * np.where(along < 6, along, 0)[..., None]
    assert not is_upside_down(shown, shown[..., 2] > 0, 75.0)
    wall = np.where((rays[..., 2] > 0)[..., None], 2.0 * rays / rays[..., 2:], 0)
    assert not is_upside_down(wall, wall[..., 2] > 0, 75.0), "a wall alone tells nothing"
