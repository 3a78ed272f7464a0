"""Extents of a model from an object's cloud and, where the camera could not see, from its own proportions (A.7)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from trimesh import Trimesh

from stages.config.generation import GenerationConfig
from stages.contracts.objects import Wall
from stages.generation.models import read_visuals
from stages.generation.placed import Placed
from stages.geometry.boxes import UprightBox
from stages.geometry.estimate import BIN, Sight, correct_depth
from stages.geometry.frames import wrap_angle, yaw_matrix

FRONT_SHARE = 0.3  # least share of its outline that a front fills; chosen
MEASURED, DEEP = "measured along the model's axes", "as deep as it can be"  # names of steps


def size(
    placed: Placed,
    yaw: float,
    sight: Sight,
    bearings: tuple[float, float] | None,
    reached: Sequence[Wall],
    options: GenerationConfig,
) -> Placed:
    """A model at a yaw with the measured extents; its depth is made plausible where no wall fixes it.

    Args:
        bearings: level directions between which the object is seen, radians, floor frame.
        reached: walls that it is extended to, which tell its depth.
    """
    native, camera, box = options.aspect_prior == "native", sight.camera, placed.box
    if native and placed.asset.symmetry == "full" and not reached:
        placed = placed.change_box(MEASURED, sight.measure_box(box, sight_yaw(box, camera), options.trim, False))
        if bearings:
            placed = placed.change_box("as wide as its outline", widen_to_outline(placed.box, camera, bearings))
        return placed.change_box(DEEP, replace(make_round(placed.box, options.aspect_range), yaw=yaw))
    beyond = measure_beyond_front(read_visuals(placed.folder)) if native else 0.0
    placed = placed.change_box(MEASURED, sight.measure_box(box, yaw, options.trim, native, beyond))
    if native and not reached:
        deep = correct_depth_in_room(placed.box, placed.asset.size, sight, options.aspect_range)
        placed = placed.change_box(DEEP, deep)
    return placed


def correct_depth_in_room(
    box: UprightBox, native: ArrayLike, sight: Sight, believable: tuple[float, float]
) -> UprightBox:
    """The box of an object that touches no wall, with a plausible depth unless its depth was measured."""
    return box if sight.sees_top(box) else correct_depth(box, native, sight.camera - box.center, believable)


def sight_yaw(box: UprightBox, camera: ArrayLike) -> float:
    """Yaw whose x axis points away from the camera."""
    away = box.center[:2] - np.asarray(camera, dtype=float)[:2]
    return wrap_angle(float(np.arctan2(away[1], away[0])))


def widen_to_outline(box: UprightBox, camera: ArrayLike, bearings: tuple[float, float]) -> UprightBox:
    """The box of a round model, not narrower than its outline: few points lie at the outline, and they are trimmed.

    Args:
        box: measured along `sight_yaw`, so that y is width.
        bearings: level directions between which the object is seen, radians, floor frame.
    """
    center, size = box.center.copy(), box.size.copy()
    to_center = center[:2] - np.asarray(camera, dtype=float)[:2]
    distance, (low, high) = float(np.linalg.norm(to_center)), bearings
    width = 2 * distance * float(np.sin((high - low) / 2))
    if width <= size[1]:
        return box
    size[1] = width
    center[:2] += distance * yaw_matrix((low + high) / 2)[:2, 0] - to_center
    return UprightBox(center, size, box.yaw)


def make_round(box: UprightBox, believable: tuple[float, float]) -> UprightBox:
    """The box of a round model: as deep as it is wide.

    Its width is seen whole; half of its surface is hidden, and noise and mixed pixels at its outline
    stretch the other half along the line of sight.

    Args:
        box: measured along `sight_yaw`, so that x is depth and y is width.
        believable: a depth beyond the second number times the width has points of the background in it.
    """
    depth, width, height = box.size
    center = box.center
    if depth < width or depth > believable[1] * width:
        center = center + (width - depth) / 2 * yaw_matrix(box.yaw)[:, 0]
    return UprightBox(center, [width, width, height], box.yaw)


def measure_beyond_front(meshes: Sequence[Trimesh]) -> float:
    """Metres by which a model's box reaches beyond the face that its front shows: its handles, the foot of a screen.

    That face is where most of what faces +x lies, in the front half.
    """
    bounds = np.array([mesh.bounds for mesh in meshes])
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    depths = high[0] - np.concatenate([mesh.triangles_center[:, 0] for mesh in meshes])
    areas = np.concatenate([mesh.area_faces * np.clip(mesh.face_normals[:, 0], 0, None) for mesh in meshes])
    half = (high[0] - low[0]) / 2
    counts, edges = np.histogram(depths, max(1, round(half / BIN)), (0, half), weights=areas)
    peak = int(np.argmax(counts))
    if counts[peak] < FRONT_SHARE * np.prod((high - low)[1:]):
        return 0.0
    return float(np.average(depths, weights=areas * (depths >= edges[peak]) * (depths <= edges[peak + 1])))
