"""The outline of a mask as its ends along many directions of the picture, and how far the thing may go on unseen."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.masks import OUTLINE, Mask

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
