"""Masks of an image (H, W): bounds, polygons, pixels to trust (paper A.7), ends, crops for encoders."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Mask = NDArray[np.bool_]
FARTHEST_CORNER = 30_000  # pixels: corners are drawn no farther out (OpenCV counts in 16 bits)
OUTLINE = 3  # pixels by which the outline of a mask may be off; chosen
EROSION = 2  # pixels taken off the border of masks before clouds are made; A.7 gives no number; chosen
SPECK = 0.01  # parts of a mask with a smaller share of its pixels are specks; chosen
CORNERS = 1000  # of an outline, as `roomkin.stages.contracts.types.Outline`
PIECES = 50  # of an outline beside its first
MIN_PIXELS = 60  # of a mask: fewer show neither a shape nor a surface; chosen


def pixel_bounds(mask: Mask) -> tuple[int, int, int, int]:
    """Bounds x0, y0, x1, y1 (exclusive) of a mask; all 0 if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return 0, 0, 0, 0
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def polygon(points: ArrayLike, shape: tuple[int, int]) -> Mask:
    """Pixels (H, W) inside a polygon of corners (N, 2), x and y; none if there are less than three."""
    mask = np.zeros(shape, dtype=np.uint8)
    corners = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(corners) >= 3 and np.isfinite(corners).all():
        cv2.fillPoly(mask, [np.rint(np.clip(corners, -FARTHEST_CORNER, FARTHEST_CORNER)).astype(np.int32)], 1)
    return mask > 0


def polygons(outlines: Iterable[ArrayLike], shape: tuple[int, int]) -> Mask:
    """Pixels (H, W) inside any of some polygons."""
    inside = np.zeros(shape, dtype=bool)
    for points in outlines:
        inside |= polygon(points, shape)
    return inside


def central_crop(shape: tuple[int, int], share: float) -> Mask:
    """Mask (H, W) of the central `share` of the image in either direction."""
    inside = np.zeros(shape, dtype=bool)
    v, u = (round(length * (1 - share) / 2) for length in shape)
    inside[v : shape[0] - v, u : shape[1] - u] = True
    return inside


def remove_specks(mask: Mask) -> Mask:
    """The mask without its tiny separate parts."""
    _, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= SPECK * mask.sum()
    large[0] = False
    return large[parts]


def outline_mask(mask: Mask) -> list[list[list[int]]]:
    """Outlines of a mask as lists of pixels x, y, a pixel off at most, the largest first, without specks."""
    curves, _ = cv2.findContours(remove_specks(mask).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = sorted(curves, key=cv2.contourArea, reverse=True)
    return [cv2.approxPolyDP(curve, 1.0, True)[:, 0].tolist() for curve in largest]


def erode(mask: Mask, keep: float = 0.25) -> Mask:
    """Take `EROSION` pixels off the border, fewer if less than a share of `keep` of the mask would remain."""
    for size in range(EROSION, 0, -1):
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * size + 1, 2 * size + 1))
        smaller = cv2.erode(mask.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
        if smaller.sum() >= keep * mask.sum():
            return smaller
    return mask


def lowest_pixels(own: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns (N,) and rows (N,) of the lowest pixel of a mask (H, W) in each column."""
    columns = np.flatnonzero(own.any(axis=0))
    return columns, own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)


def outline_pieces(mask: Mask) -> list[list[list[int]]]:
    """Outlines of a mask's pieces, the largest first."""
    rings = [points[:: 1 + (len(points) - 1) // CORNERS] for points in outline_mask(mask)]
    return [points for points in rings if len(points) > 2][: PIECES + 1]


def look_below(
    masks: NDArray[np.integer],
    value: int,
    steps: Iterable[int],
    heights: NDArray[np.float64] | None = None,
    apart: float = np.inf,
) -> int:
    """What masks (H, W) show below most of the lower edge of one of them: the value of another; 0: not one thing.

    Args:
        steps: pixels below it at which is looked, the nearest first.
        heights: (H, W) metres, NaN: unknown; what is `apart` metres higher or lower does not count.
    """
    columns, rows = lowest_pixels(masks == value)
    below = np.zeros(len(columns), dtype=masks.dtype)
    for step in steps:
        at = np.minimum(rows + step, len(masks) - 1)
        met = np.where(masks[at, columns] == value, 0, masks[at, columns])
        if heights is not None:
            met = np.where(np.abs(heights[at, columns] - heights[rows, columns]) < apart, met, 0)
        below = np.where(below == 0, met, below)
    counts = np.bincount(below, minlength=1)
    counts[0] = 0
    return int(counts.argmax()) if 2 * counts.max() >= len(columns) else 0


DIRECTIONS = 32  # of ends, all around; twice as many change nothing
SIDE = 0.03  # of the mask's extent along a direction: the pixels that make up its end; chosen
SAMPLES = 20  # of these pixels, for time
NEARER = 0.05  # metres, beyond the noise of depth (`noise`), by which what hides a thing is nearer; chosen
STRIDE = 4  # pixels between looks behind what hides a thing; chosen for time
Array = NDArray[np.float64]


class Outline(NamedTuple):
    """Ends (K,), pixels, of a mask along the unit vectors `directions` (K, 2), x right and y down.

    reach: where what is seen ends. limit: where the thing ends at the latest: `reach` where it is seen to end, more
    where something nearer hides it, infinite where the picture ends.
    """

    directions: Array
    reach: Array
    limit: Array

    def measure_misfit(self, pixels: Array) -> Array:
        """By how many pixels (K,) a thing with these points (N, 2) ends too far out; negative: too far in."""
        ends = (pixels @ self.directions.T).max(axis=0)
        return np.minimum(ends - self.reach, 0) + np.maximum(ends - self.limit, 0)


def measure_outline(mask: Mask, depth: NDArray[np.floating], inside: Mask, noise: Callable[[Array], Array]) -> Outline:
    """The outline of a mask (H, W) that is not empty.

    Args:
        depth: (H, W) metres of all that is seen, 0 where unknown.
        inside: pixels (H, W) that are used; the picture ends where they end.
        noise: metres by which depth is wrong before and behind it, at distances (N,).
    """
    angles = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    rows, columns = np.nonzero(mask)
    pixels = np.column_stack([columns, rows])
    along = pixels @ directions.T
    reach = along.max(axis=0)
    own = depth[rows, columns].astype(float)
    own = np.where(own > 0, own, np.median(own[own > 0]) if (own > 0).any() else np.inf)
    band = np.maximum(1.0, SIDE * (reach - along.min(axis=0)))
    steps = np.arange(2 * OUTLINE, sum(mask.shape), STRIDE)
    hidden = np.zeros(DIRECTIONS)
    for number, direction in enumerate(directions):
        ends = np.flatnonzero(along[:, number] >= reach[number] - band[number])
        ends = ends[:: max(1, len(ends) // SAMPLES)]
        hidden[number] = _measure_hidden(pixels[ends], own[ends], direction, steps, mask, depth, inside, noise)
    return Outline(directions, reach + 0.5, reach + 0.5 + hidden)


def _measure_hidden(
    ends: NDArray[np.integer],
    own: Array,
    direction: Array,
    steps: NDArray[np.integer],
    mask: Mask,
    depth: NDArray[np.floating],
    inside: Mask,
    noise: Callable[[Array], Array],
) -> float:
    """Pixels by which a thing may go on beyond most of the pixels `ends` (N, 2), `own` (N,) metres away."""
    height, width = mask.shape
    known = np.isfinite(own)  # not where it is shown as floor: nothing hides that
    gap = np.where(known, NEARER + noise(own), 0)

    def look(step: float) -> tuple[Mask, Array]:
        """Which pixels, `step` farther out, are outside the picture, and the depth of the others."""
        x, y = np.rint(ends + step * direction).astype(int).T
        there = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = np.where(there, x, 0), np.where(there, y, 0)
        there &= inside[y, x] | mask[y, x]
        return ~there, np.where(there & ~mask[y, x], depth[y, x], 0)

    outside, shown = look(float(steps[0]))
    nearer = (shown > 0) & (shown < own - gap) & known
    if (outside | nearer).mean() < 0.5:
        return 0.0
    far = np.full(len(ends), np.inf)
    open_ = np.ones(len(ends), dtype=bool)
    for step in steps:
        outside, shown = look(float(step))
        passed = open_ & (shown > own + gap / 2)
        far[passed] = step
        open_ &= ~passed & ~outside
        if not open_.any():
            break
    return float(far.max())


GREY = 127  # color of what is masked out


@dataclass(frozen=True)
class ObjectView:
    """An object as a camera sees it.

    rgb (H, W, 3) uint8; mask (H, W) bool, the object's visible pixels; depth (H, W) float32 metres along
    the optical axis, 0: unknown, or None; intrinsics (3, 3) in pixels; up (3,) the unit vector against
    gravity in the camera frame, or None where it is not known.
    """

    rgb: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32] | None = None
    intrinsics: NDArray[np.float64] | None = None
    up: NDArray[np.float64] | None = None


def cut(view: ObjectView) -> ObjectView:
    """The view cut to the box of its mask; the principal point moves along, everything else stays as it is."""
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    window = np.s_[y0:y1, x0:x1]
    intrinsics = None
    if view.intrinsics is not None:
        intrinsics = np.array(view.intrinsics, dtype=float)
        intrinsics[0, 2] -= x0
        intrinsics[1, 2] -= y0
    depth = None if view.depth is None else view.depth[window]
    return ObjectView(view.rgb[window], view.mask[window], depth, intrinsics, view.up)


def darken_rest(view: ObjectView) -> NDArray[np.uint8]:
    """The object's part of the picture, what is not the object darkened."""
    shade = np.where(view.mask[..., None], view.rgb, view.rgb // 3).astype(np.uint8)
    return cut(ObjectView(shade, view.mask)).rgb


def masked_square(view: ObjectView, width: int, height: int) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """A cut view as a picture (height, width, 3), grey outside the mask, and the mask's coverage (height, width).

    The aspect ratio is not kept: cousins are rescaled per axis, so it says little about the model.
    """
    rgb = np.where(view.mask[..., None], view.rgb, np.uint8(GREY))
    shrinks = view.mask.shape[0] > height or view.mask.shape[1] > width
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    coverage = cv2.resize(view.mask.astype(np.float32), (width, height), interpolation=method)
    picture = cv2.resize(rgb, (width, height), interpolation=method)
    return picture.astype(np.uint8, copy=False), coverage.astype(np.float32, copy=False)


def patch_positions(rows: int, columns: int) -> NDArray[np.float32]:
    """Centers (rows, columns, 2) of the patches as (x, y) in [-1, 1] of the crop."""
    y = (np.arange(rows) + 0.5) / rows * 2 - 1
    x = (np.arange(columns) + 0.5) / columns * 2 - 1
    return np.stack(np.meshgrid(x, y), axis=-1).astype(np.float32)


def foreground(coverage: NDArray[np.float32], rows: int, columns: int, least: float = 0.5) -> NDArray[np.bool_]:
    """Patches (rows, columns) that the mask covers by a share of `least`; if there are none, those it touches."""
    share = cv2.resize(coverage, (columns, rows), interpolation=cv2.INTER_AREA)
    return share >= least if (share >= least).any() else share > 0
