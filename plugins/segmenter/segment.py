"""Cut a picture with depth into things, floor and walls: the network, joining, and a second look at level tops."""

from dataclasses import dataclass, field, replace
from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes
from scipy.spatial import Delaunay, QhullError

from plugins.segmenter.joining import join_pixels
from plugins.segmenter.network import BACKGROUND, FLOOR, STRIDE, THING, Segmenter, load, network_input
from plugins.segmenter.upsampling import upsample_labels
from stages.geometry.cameras import back_project, scale_intrinsics
from stages.geometry.frames import apply, rigid
from stages.geometry.levels import find_ground
from stages.geometry.room_planes import find_walls, make_floor_frame, sample_points

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WIDTH = 320  # pixels of the picture that the network sees
LEAST_PIXELS = 25  # of a piece, in the network's output
LEAST_SCORE = 0.5  # mean certainty that a piece is a thing, and one thing; chosen
TOP = 0.3  # share of a piece that is level, at one height, if its top is looked at again; chosen
MOST_TOPS = 3  # that are looked at again; chosen for time
OFF_TOP = 0.012  # share of the distance by which a thing rises above the top that it stands on; chosen
LEVEL = 0.95  # cosine between up and the normal of a level top
ON_PLANE = 0.02  # share of the distance by which a pixel may be off the plane of the ground or a wall; chosen


@dataclass(frozen=True)
class Pieces:
    """Masks as `values` (H, W) uint16, 0: nothing; the score of each thing by value; the values of floor and walls."""

    values: NDArray[np.uint16]
    things: dict[int, float]
    floor: int | None = None
    walls: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Prediction:
    """What the network predicts for a picture, at half its size (h, w).

    classes: probabilities of floor, background and thing, (3, h, w).
    same: log-odds that a pixel is of the same thing as each neighbour, (k * neighbours, h, w), see `join_pixels`.
    votes: the centre that each pixel votes for, (h, w, 3), metres, level frame; NaN without depth.
    radius: of the thing, (h, w), metres.
    """

    classes: Array
    same: Array
    votes: Array
    radius: Array


@cache
def network() -> Segmenter:
    """The network, loaded once per process."""
    return load()


def predict(depth: Array, rgb: NDArray[np.uint8], intrinsics: Array, frame: Array) -> Prediction:
    """Run the network on a picture of about `WIDTH` pixels, and on the same at half its size; see `network_input`.

    At half its size large things stay whole: classes are averaged, neighbours of both count.
    """
    fine = _predict_once(depth, rgb, intrinsics, frame)
    half = depth[::2, ::2]
    size = half.shape[::-1]
    colour = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    matrix = scale_intrinsics(intrinsics, size[0] / depth.shape[1], size[1] / depth.shape[0])
    coarse = _predict_once(half, colour, matrix, frame)
    classes, same = (
        np.stack([cv2.resize(layer, fine.radius.shape[::-1], interpolation=cv2.INTER_LINEAR) for layer in layers])
        for layers in (coarse.classes, coarse.same)
    )
    return replace(fine, classes=(fine.classes + classes) / 2, same=np.concatenate([fine.same, same]))


def _predict_once(depth: Array, rgb: NDArray[np.uint8], intrinsics: Array, frame: Array) -> Prediction:
    inputs = network_input(depth, rgb, intrinsics, frame)
    with torch.inference_mode():
        x = torch.from_numpy(inputs[None]).contiguous(memory_format=torch.channels_last)
        output = network()(x)[0].double().numpy()
    shown = np.exp(output[:3] - output[:3].max(axis=0))
    points = apply(frame, back_project(depth, intrinsics))[::STRIDE, ::STRIDE]
    known = (depth > 0)[::STRIDE, ::STRIDE, None]
    votes = np.where(known, points + output[3:6].transpose(1, 2, 0), np.nan)
    return Prediction(shown / shown.sum(axis=0), output[7:], votes, np.exp(output[6].clip(-4.0, 2.0)))


def cut(depth: NDArray[np.float32], rgb: NDArray[np.uint8], intrinsics: Array, max_tilt: float) -> Pieces | None:
    """Cut a picture into things, floor and walls; None: it shows no ground.

    Args:
        depth: (H, W) metres, 0: unknown.
        rgb: (H, W, 3).
        intrinsics: (3, 3) pixels.
        max_tilt: largest angle between image-up and the ground's normal, degrees.
    """
    height, width = depth.shape
    whole = back_project(depth, intrinsics)
    ground = find_ground(whole, depth > 0, max_tilt)
    if ground is None:
        return None
    frame = make_floor_frame(ground)
    size = WIDTH, max(STRIDE, round(height * WIDTH / width / STRIDE) * STRIDE)
    small = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST).astype(float)
    colour = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    matrix = scale_intrinsics(intrinsics, size[0] / width, size[1] / height)
    prediction = predict(small, colour, matrix, frame)
    kind = prediction.classes.argmax(axis=0)
    coarse = apply(frame, back_project(small, matrix))[::STRIDE, ::STRIDE]
    off = np.abs(coarse[..., 2]) > ON_PLANE * small[::STRIDE, ::STRIDE]
    kind[(kind == FLOOR) & off & (small[::STRIDE, ::STRIDE] > 0)] = BACKGROUND
    labels = join_pixels(kind == THING, prediction.same, prediction.votes, prediction.radius)
    labels = drop_small(look_again(labels, small, colour, matrix, frame))
    scores = [score_piece(labels == label, prediction) for label in range(labels.max() + 1)]
    kept = [label for label, score in enumerate(scores) if score >= LEAST_SCORE]
    floor, behind = len(kept) + 1, len(kept) + 2
    values = np.select([kind == FLOOR, kind == BACKGROUND], [floor, behind], 0).astype(np.uint16)
    for value, label in enumerate(kept, 1):
        values[labels == label] = value
    values = upsample_labels(values, depth, rgb)
    walls = mask_walls(apply(frame, whole), depth > 0, values == behind, float(frame[2, 3]))
    values[values == behind] = 0
    for value, wall in enumerate(walls, behind):
        values[wall] = value
    things = {value: scores[label] for value, label in enumerate(kept, 1)}
    return Pieces(values, things, floor if (kind == FLOOR).any() else None, list(range(behind, behind + len(walls))))


def score_piece(piece: Mask, prediction: Prediction) -> float:
    """Confidence in [0, 1] that a piece (h, w) is a thing, and that its pixels belong together."""
    inside = (1 / (1 + np.exp(-prediction.same[:4])))[:, piece].mean()
    return float(prediction.classes[THING][piece].mean() * inside)


def drop_small(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """The pieces (h, w) of at least `LEAST_PIXELS`, holes filled, largest first from 0; -1: none."""
    counts = np.bincount(labels[labels >= 0], minlength=1)
    kept = np.full_like(labels, -1)
    for number, label in enumerate(np.argsort(-counts, kind="stable")[: int((counts >= LEAST_PIXELS).sum())]):
        kept[binary_fill_holes(labels == label) & ((labels < 0) | (labels == label))] = number
    return kept


def look_again(
    labels: NDArray[np.int64], depth: Array, rgb: NDArray[np.uint8], intrinsics: Array, frame: Array
) -> NDArray[np.int64]:
    """Segment pieces (h, w) with a level top again, with that top as the floor, to separate what stands on it.

    Args:
        labels: of `join_pixels`, at half the picture's size.
        depth: (H, W), likewise `rgb`, as of `predict`.
        intrinsics: (3, 3) pixels.
        frame: floor_from_camera (4, 4).
    """
    points = apply(frame, back_project(depth, intrinsics))[::STRIDE, ::STRIDE]
    known = (depth > 0)[::STRIDE, ::STRIDE]
    upward = network_input(depth, rgb, intrinsics, frame)[5, ::STRIDE, ::STRIDE] > LEVEL
    counts = np.bincount(labels[labels >= 0], minlength=1)
    labels, looked = labels.copy(), 0
    for label in np.argsort(-counts, kind="stable"):
        piece = (labels == label) & known
        top = find_top(points[..., 2], piece, piece & upward)
        if counts[label] < 10 * LEAST_PIXELS or top is None or looked == MOST_TOPS:
            continue
        looked += 1
        prediction = predict(depth, rgb, intrinsics, rigid(np.eye(3), [0, 0, -top]) @ frame)
        on_top = np.abs(points[..., 2] - top) < OFF_TOP * depth[::STRIDE, ::STRIDE]
        over = known & _find_above(points, piece & upward & on_top)
        over &= (labels == label) | (labels < 0)
        over &= points[..., 2] > top + OFF_TOP * depth[::STRIDE, ::STRIDE]
        over &= prediction.classes.argmax(axis=0) == THING
        again = join_pixels(over, prediction.same, prediction.votes, prediction.radius)
        labels[again >= 0] = again[again >= 0] + labels.max() + 1
    return labels


def find_top(heights: Array, piece: Mask, upward: Mask) -> float | None:
    """The height in metres of a piece's level top, if a share of `TOP` lies at it; `upward`: its level pixels."""
    if upward.sum() < max(2 * LEAST_PIXELS, TOP * piece.sum()):
        return None
    top = float(np.median(heights[upward]))
    near = upward & (np.abs(heights - top) < 0.03)
    return float(np.median(heights[near])) if near.sum() >= TOP * piece.sum() else None


def _find_above(points: Array, top: Mask) -> Mask:
    """Pixels (h, w) whose points (h, w, 3) are over the convex hull of the top's, from above."""
    corners = sample_points(points[top], np.random.default_rng(0))[:, :2]
    try:
        return np.asarray(Delaunay(corners).find_simplex(points[..., :2]) >= 0)
    except (QhullError, ValueError):
        return np.zeros(top.shape, dtype=bool)


def mask_walls(points: Array, known: Mask, behind: Mask, camera_height: float) -> list[Mask]:
    """The pixels (H, W) of each wall plane in points (H, W, 3), level frame; `behind`: the candidates."""
    planes = find_walls(points[known], behind[known], camera_height, np.random.default_rng(0))
    masks, free = [], behind & known
    size = 2 * (known.shape[1] // 160) + 1
    for normal, offset, _ in planes:
        distance = np.linalg.norm(points - [0, 0, camera_height], axis=-1)
        near = free & (np.abs(points @ normal - offset) < ON_PLANE * distance)
        wall = free & (cv2.medianBlur(near.astype(np.uint8), size) > 0)
        masks.append(wall)
        free &= ~wall
    return [mask for mask in masks if mask.any()]
