"""Whether depth belongs to its picture: where depth changes by steps the picture has edges, and masks have outlines.

Measured on ray-cast rooms and on the frames of real cameras: docs/results/your-data.md.
"""

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d, distance_transform_edt

from roomkin.stages.contracts import InputError

WIDTH = 640  # pixels at most of what is compared; larger frames are made smaller
STEP = 0.03  # share of the distance
FEWEST, SAMPLED = 200, 1000  # pixels of steps: with fewer nothing is said, of more so many are looked at
NEIGHBOURS = np.ones((5, 5))  # a step in so many pixels around an edge is on it
AROUND = 41  # pixels across which an edge is compared with what else is there: carpets are full of edges
FARTHEST, APART = 0.15, 6  # share of the width by which depth may be moved, and pixels between places that are tried
ZOOMS = [float(zoom) for zoom in np.exp(0.04 * np.arange(-10, 11))]  # by which depth may have to be shown larger
BETTER = 0.06  # how much more steps fit elsewhere; of right frames at most 0.035
SURE, FITS = 0.1, 0.75  # likewise, and how much steps fit there, where depth is refused
NOWHERE = 0.57  # how much steps fit at least in right frames: 0.6; by chance 0.5
FLIPS = {"left to right": (1,), "upside down": (0,), "by 180 degrees": (0, 1)}

Mask = NDArray[np.bool_]
Edges = NDArray[np.float32]


class Place(NamedTuple):
    """How much steps are on edges (0..1) if depth is shown `zoom` times larger, and moved by so many pixels."""

    fit: float
    zoom: float = 1.0
    right: int = 0
    down: int = 0


def doubt_depth(depth: NDArray[np.float32], rgb: NDArray[np.uint8], masks: NDArray[np.uint16] | None = None) -> str:
    """What makes it doubtful that depth (H, W) is of the view of rgb (H, W, 3) and masks (H, W); "" if nothing.

    Raises:
        InputError: it fits when it is mirrored, or shown larger or smaller.
    """
    if (shrunk := depth.shape[1] / WIDTH) > 1:
        size = WIDTH, round(depth.shape[0] / shrunk)
        depth = np.asarray(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST))
        rgb = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)).astype(np.uint8)
        masks = None if masks is None else np.asarray(cv2.resize(masks, size, interpolation=cv2.INTER_NEAREST))
    steps = np.argwhere(find_steps(depth)) if (depth > 0).any() else np.empty((0, 2))
    if len(steps) < FEWEST:
        return ""
    steps = steps[np.linspace(0, len(steps) - 1, SAMPLED).astype(int)] - (np.array(depth.shape) - 1) / 2
    edges = _find_edges(rgb, masks)
    shows_much = bool(np.median(edges) > 0)
    edges = np.pad(edges, depth.shape[1], constant_values=-1)
    moves = list(_list_moves(depth.shape[1]))
    here = _fit(edges, steps, 1.0, [(0, 0)])
    moved = _fit(edges, steps, 1.0, moves)
    best = max(moved, *(_fit(edges, steps, zoom, moves) for zoom in ZOOMS if zoom != 1))
    flips = {how: _fit(np.flip(edges, axes), steps, 1.0, moves) for how, axes in FLIPS.items()}
    turned = max(flips, key=lambda how: flips[how].fit)
    if flips[turned].fit > max(moved.fit + BETTER, best.fit - BETTER, NOWHERE):
        what = f"is turned {turned} against the picture: {_compare(here, flips[turned])}."
        fix = f"turn depth {turned}, or picture and masks, as the camera saw them"
        raise InputError("depth", what, fix, code="E-DEPTH-MIRRORED")
    is_near = best.zoom == 1 and max(abs(best.right), abs(best.down)) <= APART
    if best.fit <= max(here.fit + BETTER, NOWHERE) or is_near:
        nowhere = f"depth in doubt: its steps fit the picture's edges by {100 * here.fit:.0f} %, by chance 50"
        return (
            f"{nowhere}: it is not aligned to the picture, or of another one"
            if shows_much and here.fit < NOWHERE
            else ""
        )
    is_zoomed = best.fit > moved.fit + BETTER
    if not is_zoomed and moved.fit > here.fit + BETTER:
        best = moved
    how = _say_place(best, depth.shape)
    if is_zoomed and best.fit > max(here.fit + SURE, FITS):
        what = f"is of another camera than the picture, or place: it fits if it is {how}: {_compare(here, best)}."
        fix = "align depth to the color picture (every camera's software does)"
        raise InputError("depth", what, fix, code="E-DEPTH-UNALIGNED")
    return f"depth in doubt: it fits if it is {how}: {_compare(here, best)}; it is not aligned to the picture"


def _compare(here: Place, there: Place) -> str:
    return f"its steps fit the picture's edges by {100 * there.fit:.0f} %, now by {100 * here.fit:.0f}"


def _say_place(place: Place, shape: tuple[int, ...]) -> str:
    zoom = place.zoom if place.zoom > 1 else 1 / place.zoom
    shown = [] if place.zoom == 1 else [f"shown {zoom:.2f} times {'larger' if place.zoom > 1 else 'smaller'}"]
    right, down = 100 * place.right / shape[1], 100 * place.down / shape[0]
    moved = [f"moved by {right:+.0f} % of the width and {down:+.0f} % of the height"] if right or down else []
    return " and ".join(shown + moved)


def find_steps(depth: NDArray[np.float32]) -> Mask:
    """Where depth (H, W), 0: unknown, changes by a step; gaps are filled with what is nearest to them."""
    rows, columns = distance_transform_edt(depth <= 0, return_distances=False, return_indices=True)
    inverse = 1 / np.maximum(cv2.medianBlur(depth[rows, columns], 5), 1e-6)
    bend = [1, 0, 0, -2, 0, 0, 1]  # 0 on planes
    return np.asarray(np.max([np.abs(correlate1d(inverse, bend, axis)) for axis in (0, 1)], axis=0) > STEP * inverse)


def _find_edges(rgb: NDArray[np.uint8], masks: NDArray[np.uint16] | None) -> Edges:
    """How strong the edges at each pixel are (H, W): the share of all pixels that have weaker ones; outlines are 1."""
    smooth = cv2.GaussianBlur(rgb, (0, 0), 1.2).astype(np.float32)
    change = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)).max(axis=2)
    strength = cv2.dilate(change / (cv2.blur(change, (AROUND, AROUND)) + 2), NEIGHBOURS)
    if masks is not None:
        outline = cv2.dilate(masks, np.ones((3, 3))) != cv2.erode(masks, np.ones((3, 3)))
        strength[cv2.dilate(outline.astype(np.uint8), NEIGHBOURS) > 0] = np.inf
    return (np.searchsorted(np.sort(strength.ravel()), strength) / strength.size).astype(np.float32)


def _fit(edges: Edges, steps: NDArray[np.float64], zoom: float, moves: list[tuple[int, int]]) -> Place:
    """The best of the moves of steps (N, 2: rows and columns from the center) that are shown `zoom` times larger.

    Edges below 0 lie beyond the picture; of steps there, up to half of all, nothing is known.
    """
    wide = edges.shape[1]
    rows, columns = np.rint((np.array(edges.shape) - 1) / 2 + zoom * steps).astype(int).T
    flat = rows * wide + columns
    found = edges.ravel()[flat + np.array([[down * wide + right] for right, down in moves])]
    inside = found >= 0
    fits = np.where(inside, found, 0).sum(axis=1) / np.maximum(inside.sum(axis=1), len(steps) / 2)
    best = int(fits.argmax())
    return Place(float(fits[best]), zoom, *moves[best])


def _list_moves(width: int) -> Iterator[tuple[int, int]]:
    """Pixels to the right and down."""
    farthest = round(FARTHEST * width) // APART * APART
    for right in range(-farthest, farthest + 1, APART):
        for down in range(-farthest, farthest + 1, APART):
            yield right, down
