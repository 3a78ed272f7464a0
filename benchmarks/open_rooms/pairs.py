"""Which piece of a cut picture shows which true thing."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

FOUND = 0.5  # IoU above which a piece shows a thing; no two pieces can


def overlaps(exact: NDArray[np.uint16], cut: NDArray[np.uint16]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """IoU (E, M) of every exact mask with every mask that was cut, and the share of the latter inside; by value."""
    both = np.zeros((int(exact.max()) + 1, int(cut.max()) + 1))
    np.add.at(both, (exact.ravel(), cut.ravel()), 1)
    areas, sizes = both.sum(axis=1, keepdims=True), both.sum(axis=0, keepdims=True)
    return both / np.maximum(areas + sizes - both, 1), both / np.maximum(sizes, 1)


def pair_pieces(numbers: Iterable[int], iou: NDArray[np.float64]) -> dict[int, int]:
    """The piece of every thing that has one, by number.

    Args:
        numbers: of the things, their values in the exact masks.
        iou: (E, M) of `overlaps`; column 0 is no piece.
    """
    best = {number: int(iou[number, 1:].argmax()) + 1 for number in numbers if iou.shape[1] > 1}
    return {number: piece for number, piece in best.items() if iou[number, piece] > FOUND}
