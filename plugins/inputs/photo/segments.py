"""Propose the perspective of a photograph: line segments, RANSAC for three orthogonal vanishing points, refinement."""

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.inputs.photo.metrology import View
from plugins.inputs.photo.perspective import AXES, WEAK, Guide, Perspective, fit_view, measure_misses
from stages.geometry.frames import wrap_angle

Points = NDArray[np.float64]
MOST = 200  # segments, the longest: as many as a drawing may have
HYPOTHESES = 400  # per focal length
TRIALS = np.linspace(-3, 3, 9)  # focal lengths, in standard deviations from the likely one
PRIOR = 0.02  # share of agreeing length that one standard deviation of the focal length is worth
GUIDES_SHOWN = 5  # guides per axis
FITS = 0.9  # agreement of a segment that is shown: two thirds of a degree
USUAL_FOCAL = 0.8  # of the longer side: 64 degrees across
KNOWN_SPREAD = 0.03  # of the logarithm of a focal length from EXIF


def usual_focal(width: int, height: int, exif: float | None) -> Perspective:
    """A perspective of which only the focal length is known: the one (pixels) that EXIF tells, or a usual camera's."""
    if exif is not None:
        return Perspective(likely_focal=exif, spread=KNOWN_SPREAD)
    return Perspective(likely_focal=USUAL_FOCAL * max(width, height))


def find_segments(grey: NDArray[np.uint8]) -> Points:
    """The longest line segments (N, 2, 2) of a picture (H, W), longest first."""
    found = cv2.createLineSegmentDetector().detect(grey)[0]
    if found is None:
        return np.zeros((0, 2, 2))
    ends = np.asarray(found, dtype=float).reshape(-1, 2, 2)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return ends[np.argsort(-lengths, kind="stable")[:MOST]]


def _planes(ends: Points, width: int, height: int, focal: float) -> Points:
    """Unit normals (N, 3), camera frame, of the planes through the camera and each segment."""
    flat = (ends - [(width - 1) / 2, (height - 1) / 2]) / focal
    rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
    normals = np.cross(rays[:, 0], rays[:, 1])
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def _hypotheses(normals: Points, weights: Points, highest: float, rng: np.random.Generator) -> Points:
    """room_from_camera rotations (M, 3, 3): two segments meet in one vanishing point, a third runs square to it.

    highest: pitch from which on the picture shows no floor: then nothing could be drawn.
    """
    first, second, third = rng.choice(len(normals), size=(3, HYPOTHESES), p=weights / weights.sum())
    one = np.cross(normals[first], normals[second])
    two = np.cross(normals[third], one)
    lengths = np.linalg.norm(one, axis=1), np.linalg.norm(two, axis=1)
    good = (lengths[0] > 1e-4) & (lengths[1] > 1e-4)
    one, two = one[good] / lengths[0][good, None], two[good] / lengths[1][good, None]
    frames = np.stack([one, two, np.cross(one, two)], axis=1)
    upright = np.argmax(np.abs(frames[:, :, 1]), axis=1)  # z is the axis nearest to the picture's upright
    rows = np.arange(len(frames))
    up = frames[rows, upright] * -np.sign(frames[rows, upright, 1])[:, None]
    away = np.argmax(np.where(np.arange(3) == upright[:, None], -1, np.abs(frames[:, :, 2])), axis=1)
    back = frames[rows, away] * np.sign(frames[rows, away, 2])[:, None]
    rotations = np.stack([np.cross(back, up), back, up], axis=1)
    return np.asarray(rotations[up[:, 2] < np.sin(highest)])


def _agreement(view_misses: Points, half: Points) -> Points:
    """1 where a segment points to its vanishing point, 0 where it is off by `WEAK` or more."""
    return np.clip(1 - (np.abs(view_misses) / np.maximum(half, 1e-9) / WEAK) ** 2, 0, None)


def _scores(ends: Points, lengths: Points, focal: float, size: tuple[int, int], rotations: Points) -> Points:
    """Share (M,) of the segments' length that agrees with one of the three axes."""
    center = np.array([(size[0] - 1) / 2, (size[1] - 1) / 2])
    middle, half = ends.mean(axis=1) - center, (ends[:, 1] - ends[:, 0]) / 2
    total = np.zeros((len(rotations), len(ends)))
    for axis in range(3):
        direction = rotations[:, axis]
        towards = direction[:, None, :2] * focal - direction[:, None, 2:] * middle
        off = np.abs(towards[..., 0] * half[:, 1] - towards[..., 1] * half[:, 0])
        off /= np.maximum(np.linalg.norm(towards, axis=-1), 1e-9)
        total = np.maximum(total, _agreement(off, lengths / 2))
    return np.asarray(total @ lengths / lengths.sum())


def angles_of(rotation: Points) -> tuple[float, float, float]:
    """Yaw, pitch and roll, of which `rotation_of` makes room_from_camera."""
    up, forward = rotation[2], rotation[:, 2]
    yaw = float(np.arctan2(-forward[0], forward[1]))
    return wrap_angle(yaw, np.pi), float(np.arcsin(np.clip(up[2], -1, 1))), float(np.arctan2(-up[0], -up[1]))


def _assign_axes(view: View, ends: Points) -> tuple[NDArray[np.integer], Points]:
    """Axis (N,) of each segment and how well it agrees with it."""
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    every = [measure_misses(view, np.full(len(ends), axis), ends) for axis in range(3)]
    agreements = np.stack([_agreement(off, lengths / 2) for off in every])
    return np.argmax(agreements, axis=0), agreements.max(axis=0)


def _guides(ends: Points, axes: NDArray[np.integer]) -> list[Guide]:
    """Segments (N, 2, 2) as guides along their axes (N,)."""
    lines = zip(axes, ends.tolist(), strict=True)
    return [Guide(axis=AXES[axis], a=tuple(a), b=tuple(b)) for axis, (a, b) in lines]  # type: ignore[arg-type]


def propose(grey: NDArray[np.uint8], prior: Perspective, seed: int = 0) -> Perspective:
    """Guides along the three axes of the room, and the focal length that fits all segments.

    Without lines that agree there are no guides, and the camera is the usual one.

    Args:
        grey: picture (H, W).
        prior: what is known of the focal length.
    """
    height, width = grey.shape
    ends = find_segments(grey)
    if len(ends) < 6:
        return prior
    rng = np.random.default_rng(seed)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    best, best_score = None, 0.0
    for focal in (prior.likely_focal * np.exp(prior.spread * TRIALS)).tolist():
        highest = float(np.arctan(height / 2 / focal))
        rotations = _hypotheses(_planes(ends, width, height, focal), lengths, highest, rng)
        if not len(rotations):
            continue
        scores = _scores(ends, lengths, focal, (width, height), rotations)
        scores -= PRIOR * (np.log(focal / prior.likely_focal) / prior.spread) ** 2
        if scores.max() > best_score:
            best, best_score = (rotations[int(np.argmax(scores))], focal), float(scores.max())
    if best is None:
        return prior
    view = View(width, height, best[1], best[0])
    for _ in range(3):  # better lines give a better camera, which gives better lines
        axes, good = _assign_axes(view, ends)
        every = _guides(ends[good > 0], axes[good > 0])
        view = fit_view(prior.model_copy(update={"guides": every}), width, height, angles_of(view.rotation))
    axes, good = _assign_axes(view, ends)
    longest = [np.flatnonzero((axes == axis) & (good > FITS))[:GUIDES_SHOWN] for axis in range(3)]
    guides = _guides(np.round(ends, 1), axes)
    shown = [guides[number] for number in np.concatenate(longest)]
    return Perspective(guides=shown, likely_focal=view.focal, spread=min(prior.spread, 0.1))
