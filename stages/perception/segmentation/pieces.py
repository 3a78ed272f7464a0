"""Proposer `pieces`: what hangs together above the ground by depth alone, where weights lack.

Neighbouring pixels belong together unless depth jumps between them and no level top goes on; once more, unless their
surfaces meet in a hollow, as a cup and its table do (local convexity: Stein et al., CVPR 2014).
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.perception.camera.surfaces import NOISE
from roomkin.stages.perception.segmentation.proposal import Array, Mask, Proposal, RoomView

REACH = 4  # pixels of an outline to either side, between which normals are measured and compared; chosen
JUMP = 0.01  # metres, more than the noise, by which depth jumps between two things; chosen
UP, LEVEL = 0.9, 0.01  # cosine of what faces up, and metres by which heights of one level top differ; chosen
HOLLOW = 0.5  # least change of the normal across a hollow; chosen
MIN_PIXELS = 25  # pixels of a piece; chosen
WHOLE, CUT = 0.9, 0.8  # scores of pieces, and of those that are cut at hollows; chosen


def propose(view: RoomView, options: OutlineSection) -> list[Proposal]:
    """The pieces, and what they fall into at hollows."""
    surfaces = view.surfaces
    points = np.asarray(cv2.resize(surfaces.points, view.small, interpolation=cv2.INTER_NEAREST), np.float64)
    depth = np.asarray(cv2.resize(view.depth, view.small, interpolation=cv2.INTER_NEAREST), np.float64)
    free = (depth > 0) & ~view.shrink(surfaces.floor | surfaces.beyond | view.border)
    bends, level = measure_bends(points, free, surfaces.frame[:3, 3])
    heights = np.where(level, points[..., 2], np.nan)
    found = []
    for least, score in ((-np.inf, WHOLE), (-HOLLOW, CUT)):
        pieces = join_pixels(depth, heights, free, [bend > least for bend in bends])
        for piece in np.flatnonzero(np.bincount(pieces[free], minlength=1) >= MIN_PIXELS):
            mask = cv2.morphologyEx(((pieces == piece) & free).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3)))
            found.append(Proposal((8.0 * mask - 4).astype(np.float16), score, "pieces"))
    return found


def join_pixels(depth: Array, heights: Array, free: Mask, joins: list[Mask]) -> NDArray[np.int32]:
    """The piece (h, w) of every pixel.

    Args:
        depth: (h, w) metres.
        heights: (h, w) of what faces up, metres, else NaN.
        free: (h, w) pixels of things.
        joins: (h, w) whether a pixel may be joined with its neighbour to the right, and with that below.
    """
    number, links = np.arange(depth.size).reshape(depth.shape), []
    for axis, join in zip((1, 0), joins, strict=True):
        one, other = (slice(None),) * axis + (slice(-1),), (slice(None),) * axis + (slice(1, None),)
        near = np.abs(np.diff(depth, axis=axis)) < JUMP + NOISE * depth[one] ** 2
        near |= np.abs(np.diff(heights, axis=axis)) < LEVEL
        linked = free[one] & free[other] & near & join[one]
        links.append(np.stack([number[one][linked], number[other][linked]]))
    first, second = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(len(first), bool), (first, second)), shape=(depth.size, depth.size))
    return np.asarray(connected_components(graph, directed=False)[1].reshape(depth.shape), np.int32)


def measure_bends(points: Array, free: Mask, camera: Array) -> tuple[list[Array], Mask]:
    """How the surface bends at each pixel, (h, w), along rows and along columns, and which pixels (h, w) face up.

    It is the difference of the normals `REACH` pixels on either side along the line between them: below 0 in a hollow.

    Args:
        points: (h, w, 3).
        free: (h, w) pixels of things.
        camera: (3,).
    """
    weight = cv2.blur(free.astype(float), (3, 3))
    points = cv2.blur(np.where(free[..., None], points, 0.0), (3, 3)) / np.maximum(weight, 1e-6)[..., None]
    sides = [_on_either_side(points, axis) for axis in (1, 0)]
    across, down = (after - before for before, after in sides)
    normals = _unit(np.cross(across, down))
    away = (normals * (points - camera)).sum(axis=-1, keepdims=True) > 0
    normals = np.where(away, -normals, normals)
    bends = []
    for axis, (before, after) in zip((1, 0), sides, strict=True):
        first, second = _on_either_side(normals, axis)
        bends.append(((second - first) * _unit(after - before)).sum(axis=-1))
    return bends, normals[..., 2] > UP


def _on_either_side(values: Array, axis: int) -> tuple[Array, Array]:
    """Values (h, w, 3) `REACH` pixels before and after each pixel along an axis; at the picture's edge its last."""
    at = np.arange(values.shape[axis])
    before, after = (np.take(values, np.clip(at + step, 0, len(at) - 1), axis) for step in (-REACH, REACH))
    return before, after


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
