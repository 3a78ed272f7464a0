"""Depth and masks of a solved room: per pixel the nearest of floor, walls and boxes."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.extraction.by_hand.metrology import View
from stages.extraction.by_hand.project import DrawnObject, Pixel, Project
from stages.extraction.by_hand.solve import Solved
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix

FARTHEST = 30.0  # metres: what is farther away is no room
Depth = NDArray[np.float64]


@dataclass(frozen=True)
class Painted:
    """depth (H, W) float32 metres, 0: nothing; masks (H, W) uint16; values: mask value of every id and of `floor`."""

    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]
    values: dict[str, int]


def mask_values(project: Project) -> dict[str, int]:
    """Objects count from 1, then comes the floor, then the walls."""
    names = [*(item.id for item in project.objects), "floor", *(wall.id for wall in project.walls)]
    return {name: value for value, name in enumerate(names, start=1)}


def _bounds(view: View, box: UprightBox) -> tuple[slice, slice]:
    """Rows and columns that a box can reach; all of them if it reaches behind the camera."""
    pixels = view.project(corners(box))
    if not np.isfinite(pixels).all():
        return slice(0, view.height), slice(0, view.width)
    low, high = np.floor(pixels.min(axis=0)).astype(int), np.ceil(pixels.max(axis=0)).astype(int) + 1
    low, high = np.maximum(low, 0), np.maximum(high, 0)
    return slice(low[1], min(high[1], view.height)), slice(low[0], min(high[0], view.width))


def box_depth(view: View, box: UprightBox, rays: Depth) -> Depth:
    """Depth (...) at which rays (..., 3) enter a box, inf where they miss it."""
    turn = yaw_matrix(box.yaw)
    start, direction = (np.array([0, 0, view.above]) - np.asarray(box.center)) @ turn, rays @ turn
    half = np.asarray(box.size, dtype=float) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - start) / direction, (half - start) / direction
    enter, leave = np.fmin(one, other).max(axis=-1), np.fmax(one, other).min(axis=-1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf)


def polygon(points: list[Pixel], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels (H, W) inside an outline."""
    filled = np.zeros(shape, dtype=np.uint8)
    corners_ = np.clip(np.rint(np.array(points)), -30_000, 30_000).astype(np.int32)
    cv2.fillPoly(filled, [corners_], 1)
    return filled > 0


def paint(project: Project, solved: Solved) -> Painted:
    """Depth and masks. An outline says which pixels show an object; without one all of its box does."""
    view, values = solved.view, mask_values(project)
    rays = view.rays(np.stack(np.meshgrid(np.arange(view.width), np.arange(view.height)), axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, -view.above / rays[..., 2], np.inf)
        masks = np.full(depth.shape, values["floor"], dtype=np.uint16)
        for name, wall in solved.walls.items():
            towards = rays @ wall.normal
            reach = np.where(towards < 0, wall.offset / towards, np.inf)
            masks[reach < depth] = values[name]
            depth = np.minimum(depth, reach)
    outlined = [item for item in project.objects if item.id in solved.boxes and len(item.outline) > 2]
    for item in (entry for entry in project.objects if entry.id in solved.boxes and entry not in outlined):
        rows, columns = _bounds(view, solved.boxes[item.id])
        reach = box_depth(view, solved.boxes[item.id], rays[rows, columns])
        nearer = reach < depth[rows, columns]
        depth[rows, columns][nearer] = reach[nearer]
        masks[rows, columns][nearer] = values[item.id]
    _paint_outlined(outlined, solved, rays, depth, masks, values)
    unseen = depth > FARTHEST
    return Painted(np.where(unseen, 0, depth).astype(np.float32), np.where(unseen, 0, masks).astype(np.uint16), values)


def _paint_outlined(
    items: list[DrawnObject],
    solved: Solved,
    rays: Depth,
    depth: Depth,
    masks: NDArray[np.uint16],
    values: dict[str, int],
) -> None:
    """Outlines lie over everything else; where two overlap, the nearer one is seen."""
    taken = np.full(depth.shape, np.inf)
    for item in items:
        reach = box_depth(solved.view, solved.boxes[item.id], rays)
        shown = polygon(item.outline, depth.shape) & (reach < taken)
        taken[shown] = depth[shown] = reach[shown]
        masks[shown] = values[item.id]
