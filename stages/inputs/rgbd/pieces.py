"""Pieces that are one thing: what would float else, and the insides of cups, bowls and crates."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

STEP = 0.015  # share of the distance, between neighbouring pixels: a step from one surface to another
DOWN = 3  # pixels beneath a piece at which the next one is looked for
LOWEST, HIGH = 0.005, 2.0  # share of a piece's points that are its lowest; times the noise: it does not reach down
HOLLOW = 0.15  # correlation of places with normals that point inwards
TOP, OUTSIDE = 0.95, 0.25  # share of heights up to which an edge is; of what is beneath an inside, to be its outside


class Surface(NamedTuple):
    """What is seen, per pixel: points and normals (H, W, 3), camera frame, and heights (H, W) above the table."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    height: NDArray[np.float64]


def joined(
    parts: NDArray[np.uint16], heaps: NDArray[np.uint16], surface: Surface, noise: float
) -> Iterator[tuple[int, int]]:
    """Parts, each with the one that it is a piece of, in the order in which they are to be joined.

    Args:
        parts: (H, W), 0: nothing.
        heaps: (H, W) that they were cut out of.
        surface: what is seen.
        noise: metres that heights may be off.
    """
    parts = parts.copy()
    for whole in (_beneath_floating, _outside):
        values = np.unique(parts[parts > 0]).tolist()
        while values:
            value = values.pop(0)
            other = whole(value, parts, heaps, surface, noise)
            if other not in (0, value):
                parts[parts == value] = other
                yield value, other
                values = np.unique(parts[parts > 0]).tolist()


def _beneath_floating(
    value: int, parts: NDArray[np.uint16], heaps: NDArray[np.uint16], surface: Surface, noise: float
) -> int:
    """What is seen beneath a part that does not reach down, stands on nothing and is not hidden by anything nearer.

    Of see-through things depth knows some places only.
    """
    mask, depth = parts == value, surface.points[..., 2]
    if np.quantile(surface.height[mask], LOWEST) < HIGH * noise:
        return 0
    columns, lowest, beneath = _under(mask)
    own, others = depth[np.maximum(lowest - DOWN, 0), columns], parts[beneath, columns]
    under = np.where(depth[beneath, columns] > 0, depth[beneath, columns], np.inf)
    nearer, stands = under < own * (1 - STEP), (others > 0) & (under < own * (1 + STEP))
    if 2 * (nearer | stands).sum() > len(columns):
        return 0
    return _most(others[heaps[beneath, columns] == heaps[mask][0]])[0]


def _outside(value: int, parts: NDArray[np.uint16], heaps: NDArray[np.uint16], surface: Surface, noise: float) -> int:
    """The part that shows the outside of what this is the inside of: hollow, and behind an edge as high as it is.

    Or an edge that goes all around. What stands in it may hide a part of that edge.
    """
    mask = parts == value
    spread, turned = (array[mask] - array[mask].mean(axis=0) for array in (surface.points, surface.normals))
    if not (spread * turned).sum() < -HOLLOW * np.sqrt((spread**2).sum() * (turned**2).sum()):
        return 0
    columns, lowest, beneath = _under(mask | _within(mask, parts))
    outside, count = _most(parts[beneath, columns])
    if count < OUTSIDE * len(columns):
        return 0
    in_front = (parts[:, columns] == outside) & (np.arange(len(parts))[:, None] > lowest)
    edge = np.where(in_front, surface.height[:, columns], -np.inf).max(axis=0)[in_front.any(axis=0)]
    if abs(float(np.median(edge)) - float(np.quantile(surface.height[mask], TOP))) < noise:
        return outside
    columns, _, above = _under(mask[::-1])
    return outside if 2 * (parts[::-1][above, columns] == outside).sum() > len(columns) else 0


def _within(mask: NDArray[np.bool_], parts: NDArray[np.uint16]) -> NDArray[np.bool_]:
    """Parts that the mask is to the left and to the right of."""
    left, right = (np.logical_or.accumulate(mask[:, ::way], axis=1)[:, ::way] for way in (1, -1))
    between, beside = left & right, mask.any(axis=1)
    shares = {int(other): between[beside][parts[beside] == other].mean() for other in np.unique(parts[between])}
    return np.isin(parts, [other for other, share in shares.items() if other and share > 0.5])


def _under(mask: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Columns of a mask, and per column the rows of its lowest pixel and of the one beneath it that is looked at."""
    columns = np.flatnonzero(mask.any(axis=0))
    lowest = mask.shape[0] - 1 - np.argmax(mask[::-1, columns], axis=0)
    return columns, lowest, np.minimum(lowest + DOWN, mask.shape[0] - 1)


def _most(parts: NDArray[np.uint16]) -> tuple[int, int]:
    """The part that is seen most often, and how often; 0: none is."""
    counts = np.bincount(parts, minlength=1)
    counts[0] = 0
    return int(counts.argmax()), int(counts.max())
