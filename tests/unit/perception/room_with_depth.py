"""A room of planes, as a camera sees it, for tests."""

import numpy as np

from roomkin.stages.geometry.frames import make_intrinsics
from roomkin.stages.perception.camera.surfaces import find_surfaces
from roomkin.stages.perception.segmentation.proposal import Array, Mask, Proposal, RoomView

WIDTH, HEIGHT, FOCAL = 320, 240, 260.0
CAMERA = 1.4  # metres above the floor
TILT = np.deg2rad(12)  # down
Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # low and high corner; x ahead, y left, z up
TABLE: Box = ((2.2, -0.6, 0.68), (3.0, 0.6, 0.72))
ON_TABLE: Box = ((2.5, -0.1, 0.72), (2.6, 0.05, 0.86))


def see_room(*boxes: Box, wall: float | None = 4.0, noise: float = 0.0) -> tuple[RoomView, list[Mask]]:
    """A floor, a wall that many metres ahead, and boxes: the view, and the pixels of each box."""
    columns, rows = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    left, up = (WIDTH / 2 - 0.5 - columns) / FOCAL, (HEIGHT / 2 - 0.5 - rows) / FOCAL
    ahead = np.stack([np.ones(columns.shape), left, up], axis=-1)
    c, s = np.cos(TILT), np.sin(TILT)
    rays = ahead @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    eye = np.array([0.0, 0.0, CAMERA])
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.where(rays[..., 2] < 0, -eye[2] / rays[..., 2], np.inf)
        if wall is not None:
            distance = np.minimum(distance, wall / rays[..., 0])
        masks = []
        for low, high in boxes:
            first, second = (np.array(low) - eye) / rays, (np.array(high) - eye) / rays
            near, far = np.minimum(first, second).max(-1), np.maximum(first, second).min(-1)
            hit = (near < far) & (near > 0) & (near < distance)
            distance = np.where(hit, near, distance)
            masks = [*(mask & ~hit for mask in masks), hit]
    depth: Array = np.where(np.isfinite(distance) & (distance < 9), distance, 0)
    depth += noise * depth**2 * np.random.default_rng(0).standard_normal(depth.shape) * (depth > 0)
    intrinsics = make_intrinsics(FOCAL, FOCAL, WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5)
    surfaces = find_surfaces(depth, intrinsics, 75.0)
    assert surfaces is not None
    rgb = np.random.default_rng(1).integers(100, 140, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    return RoomView(rgb, depth, intrinsics, surfaces), masks


def propose_mask(view: RoomView, mask: Mask, score: float = 0.9, **words: float) -> Proposal:
    """A proposal of exactly a mask (H, W)."""
    rows, columns = np.nonzero(mask)
    box = (float(columns.min()), float(rows.min()), float(columns.max() + 1), float(rows.max() + 1)) if words else None
    return Proposal(np.where(view.shrink(mask), 4, -4).astype(np.float16), score, "test", words, box)
