"""Depth and masks of a solved room: per pixel the nearest of floor, walls and boxes."""

from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.geometry.boxes import UprightBox, corners, distances_along
from roomkin.stages.geometry.frames import yaw_matrix
from roomkin.stages.geometry.masks import Mask, polygons
from roomkin.stages.perception.camera.metrology import DRAWING_ERROR, PinholeView
from roomkin.stages.perception.drawing.project import DrawnObject, Project
from roomkin.stages.perception.drawing.solve import Solved

SPARSE = 4  # every so many pixels tell what is seen of a drawing: it is asked for with every movement
Depth = NDArray[np.float64]


@dataclass(frozen=True)
class Painted:
    """depth (H, W) float32 metres, 0: nothing; masks (H, W) uint16; values: mask value of every id and of `floor`."""

    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]
    values: dict[str, int]


def _bounds(view: PinholeView, box: UprightBox, stride: int) -> tuple[slice, slice]:
    """Rows and columns, of every `stride`-th, that a box can reach; all if it reaches behind the camera."""
    pixels = view.project(corners(box))
    if not np.isfinite(pixels).all():
        return slice(None), slice(None)
    low, high = np.floor(pixels.min(axis=0)).astype(int), np.ceil(pixels.max(axis=0)).astype(int) + 1
    low, high = np.maximum(low, 0), np.maximum(high, 0)
    low, high = low // stride, -(-high // stride)
    return slice(low[1], high[1]), slice(low[0], high[0])


def round_depth(eye: NDArray[np.float64], rays: Depth, box: UprightBox) -> Depth:
    """Depth (...) at which rays (..., 3) from `eye` enter the upright cylinder in a box, inf where they miss it."""
    turn, half = yaw_matrix(box.yaw), box.size / 2
    start, direction = (eye - box.center) @ turn / half, rays @ turn / half
    a, b = (direction[..., :2] ** 2).sum(axis=-1), direction[..., :2] @ start[:2]
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b**2 - a * (start[:2] @ start[:2] - 1))  # nan: beside the cylinder
        ends = np.stack([(-1 - start[2]) / direction[..., 2], (1 - start[2]) / direction[..., 2]])
        enter = np.maximum((-b - root) / a, ends.min(axis=0))
        leave = np.minimum((-b + root) / a, ends.max(axis=0))
    return np.where((enter < leave) & (enter > 0), enter, np.inf)


def solid_depth(item: DrawnObject, solved: Solved, rays: Depth) -> Depth:
    """Depth at which rays enter what was drawn."""
    is_round = item.round and item.on not in solved.walls
    eye = np.array([0, 0, solved.view.above])
    return (round_depth if is_round else distances_along)(eye, rays, solved.boxes[item.id])


def extend(reach: Depth, outline: Mask) -> Depth:
    """Depth (H, W) of a thing within its outline: beside its box as at the nearest pixel that shows that, if any."""
    met = outline & np.isfinite(reach)
    if not met.any():
        return reach
    rows, columns = distance_transform_edt(~met, return_distances=False, return_indices=True)
    return np.where(outline, reach[rows, columns], reach)


def paint(project: Project, solved: Solved, stride: int = 1) -> Painted:
    """Depth and masks of every `stride`-th pixel. An outline says which pixels show an object; without one all of its
    box does, or of the cylinder in it."""
    view = solved.view
    names = [*(item.id for item in project.objects), "floor", *(wall.id for wall in project.walls)]
    values = {name: value for value, name in enumerate(names, start=1)}
    columns, rows = np.arange(0, view.width, stride), np.arange(0, view.height, stride)
    rays = view.rays(np.stack(np.meshgrid(columns, rows), axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, -view.above / rays[..., 2], np.inf)
        masks = np.full(depth.shape, values["floor"], dtype=np.uint16)
        for name, wall in solved.walls.items():
            reach = wall.reach(rays)
            masks[reach < depth] = values[name]
            depth = np.minimum(depth, reach)
    placed = [item for item in project.objects if item.id in solved.boxes]
    room = depth.copy()
    for _, layer in groupby(sorted(placed, key=lambda item: item.layer), key=lambda item: item.layer):
        items, nearest = list(layer), room.copy()
        for item in (entry for entry in items if not entry.outlines):
            part = _bounds(view, solved.boxes[item.id], stride)
            reach = solid_depth(item, solved, rays[part])
            nearer = reach < nearest[part]
            nearest[part][nearer] = depth[part][nearer] = reach[nearer]
            masks[part][nearer] = values[item.id]
        taken = np.full(depth.shape, np.inf)  # outlines lie over everything else; where two overlap, the nearer is seen
        for item in (entry for entry in items if entry.outlines):
            outline = polygons(item.outlines, (view.height, view.width))[::stride, ::stride]
            reach = extend(solid_depth(item, solved, rays), outline)
            shown = outline & (reach < taken)
            taken[shown] = depth[shown] = reach[shown]
            masks[shown] = values[item.id]
    unseen = depth > LARGEST
    return Painted(np.where(unseen, 0, depth).astype(np.float32), np.where(unseen, 0, masks).astype(np.uint16), values)


def find_hidden(project: Project, solved: Solved) -> list[str]:
    """Objects of which the picture shows nothing: all pixels are looked at only if every `SPARSE`-th shows nothing."""
    # What is thinner is not all drawn yet.
    left = {name for name, box in solved.boxes.items() if box.size.min() > DRAWING_ERROR}
    for stride in (SPARSE, 1):
        if left:
            painted = paint(project, solved, stride)
            shown = set(np.unique(painted.masks).tolist())
            left = {name for name in left if painted.values[name] not in shown}
    return sorted(left)
