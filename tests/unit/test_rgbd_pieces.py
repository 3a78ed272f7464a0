"""Pieces of one thing that `from-rgbd --clusters` has cut apart: what would float, insides of cups and crates."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stages.geometry.boxes import UprightBox
from stages.geometry.cameras import back_project, look_at
from stages.inputs.rgbd.clusters import clustered
from stages.inputs.rgbd.touching import cut_apart
from tests.unit.synthetic_room import HEIGHT, INTRINSICS, OBJECT, WIDTH, WORLD_FROM_CAMERA, trace
from tests.unit.test_rgbd import TABLE


def is_found(found: NDArray[np.uint16], true: NDArray[np.bool_]) -> bool:
    mine = found == np.bincount(found[true]).argmax()
    return bool((mine & true).sum() > 0.75 * (mine | true).sum())


def cups(
    shapes: list[tuple[float, float, float, float]], camera: NDArray[np.float64], behind: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Depth of open cylinders (x, y, radius, height) on the table, 0.4 of the size and as near, and what is where."""
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(INTRINSICS).T @ camera[:3, :3].T
    eye, depth, true = camera[:3, 3], behind.copy(), np.zeros(behind.shape, np.uint16)
    for value, (x, y, radius, tall) in enumerate(shapes, 1):
        a, b = (rays[..., :2] ** 2).sum(axis=-1), rays[..., :2] @ (eye[:2] - [x, y])
        root = b**2 - a * (((eye[:2] - [x, y]) ** 2).sum() - radius**2)
        near, far = ((-b + sign * np.sqrt(np.maximum(root, 0))) / a for sign in (-1, 1))
        for wall in (near, far):
            height = eye[2] + wall * rays[..., 2]
            hit = (root > 0) & (height > TABLE.top) & (height < TABLE.top + tall) & (wall < depth)
            depth[hit], true[hit] = wall[hit], value
    return (0.4 * depth).astype(np.float32), true


def test_the_inside_of_a_cup_belongs_to_it() -> None:
    """Its far wall is seen past its edge, a step behind; a second cup of the same height behind it is a second one."""
    table, _ = trace([TABLE], wall=False)
    shapes = [(2.1, -0.5, 0.15, 0.15), (2.5, -0.25, 0.15, 0.15), (2.4, 0.5, 0.15, 0.15)]
    depth, true = cups(shapes, WORLD_FROM_CAMERA, table)
    found = clustered(depth, INTRINSICS, np.dstack([true * 60] * 3).astype(np.uint8))[0].values
    assert len(np.unique(found[found > 0])) == 3
    for value in (1, 2, 3):
        assert is_found(found, true == value), value


def test_the_inside_of_a_bowl_belongs_to_it_behind_what_stands_in_it() -> None:
    camera = look_at([0.6, 0.0, TABLE.top + 1.7], [2.3, 0.0, TABLE.top])
    depth, true = cups([(2.3, 0.0, 0.3, 0.2), (2.3, 0.0, 0.12, 0.3)], camera, np.full((HEIGHT, WIDTH), 9, np.float32))
    points = back_project(depth, INTRINSICS)
    height = points @ camera[2, :3] + 0.4 * (camera[2, 3] - TABLE.top)
    found = cut_apart((true > 0).astype(np.uint16), points, height, 0.02)
    assert len(np.unique(found[found > 0])) == 2
    assert is_found(found, true == 1) and is_found(found, true == 2)


def test_the_inside_of_a_crate_belongs_to_it() -> None:
    middle, (length, depth_, tall), board = np.array([2.2, 0.0, TABLE.top]), (0.9, 0.9, 0.2), 0.04
    sides = [
        ([0, 0, board / 2], [length, depth_, board]),
        ([-length / 2, 0, tall / 2], [board, depth_, tall]),
        ([length / 2, 0, tall / 2], [board, depth_, tall]),
        ([0, -depth_ / 2, tall / 2], [length, board, tall]),
        ([0, depth_ / 2, tall / 2], [length, board, tall]),
    ]
    depth, masks = trace([TABLE, *(UprightBox((middle + at).tolist(), size, 0.0) for at, size in sides)], wall=False)
    rgb = np.where((masks > OBJECT)[..., None], [200, 40, 30], [90, 110, 120]).astype(np.uint8)
    found = clustered((0.4 * depth).astype(np.float32), INTRINSICS, rgb)[0].values
    assert len(np.unique(found[found > 0])) == 1
    assert is_found(found, masks > OBJECT)


@pytest.mark.parametrize(("behind", "count"), [(0.03, 1), (-0.03, 2)])
def test_what_floats_is_of_what_is_seen_beneath_it(behind: float, count: int) -> None:
    """Of a see-through thing depth knows the top, and farther back what is seen through it; nearer it hides it."""
    v, u = np.mgrid[:240, :320].astype(float)
    values = ((u > 100) & (u < 200) & (v > 40) & (v < 200)).astype(np.uint16)
    depth = np.where(v < 100, 1.0, 1.0 + behind)
    points = np.dstack([(u - 160) / 400 * depth, (v - 120) / 400 * depth, depth])
    parts = cut_apart(values, points, (200 - v) / 400, 0.02)
    assert len(np.unique(parts[values > 0])) == count
