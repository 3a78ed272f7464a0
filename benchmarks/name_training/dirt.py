"""Masks as segmenters and hands make them: too small, too large, shifted, cut, pierced, in two, with what is beside."""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.name_training.solids import Rng

Mask = NDArray[np.bool_]
CLEAN = 0.25  # share of masks that stay as they are; chosen
SAME, OTHER = 0.5, 0.4  # IoU from which a mask is a thing (docs/results/masks.md), and up to which it is none


def soil(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """A mask with faults of one to three kinds, or with none.

    Args:
        mask: (H, W).
        owner: (H, W) whose each pixel is; what is beside the mask comes with it owner by owner.
    """
    if rng.random() < CLEAN:
        return mask
    for change in rng.permutation(len(CHANGES))[: int(rng.choice([1, 1, 2, 3]))]:
        mask = CHANGES[change](mask, owner, rng)
    return mask


def share_owner(mask: Mask, wholes: Mapping[int, list[Mask]]) -> tuple[int, float]:
    """The thing with which a mask has the largest IoU, by the masks in `wholes` that show it, and that; 0: none."""
    found = [
        (float((mask & whole).sum() / max(1, (mask | whole).sum())), number)
        for number, some in wholes.items()
        for whole in some
    ]
    iou, number = max(found, default=(0.0, 0))
    return number, iou


def _resize(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """One to three pixels smaller or larger all round."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (1 + 2 * int(rng.integers(1, 4)),) * 2)
    change = cv2.erode if rng.random() < 0.5 else cv2.dilate
    return np.asarray(change(mask.astype(np.uint8), kernel)) > 0


def _shift(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """Up to five pixels off."""
    move = np.hstack([np.eye(2), rng.uniform(-5, 5, (2, 1))])
    return np.asarray(cv2.warpAffine(mask.astype(np.uint8), move, mask.shape[::-1], flags=cv2.INTER_NEAREST)) > 0


def _coarsen(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """A polygon of few corners, as a hand draws it."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    coarse = [cv2.approxPolyDP(one, rng.uniform(0.5, 4), True) for one in outlines]
    drawn = np.zeros(mask.shape, np.uint8)
    cv2.fillPoly(drawn, coarse, 1)
    return drawn > 0


def _split(mask: Mask, share: float, rng: Rng) -> Mask:
    """The side of a line beyond which a share of the pixels lies."""
    rows, columns = np.nonzero(mask)
    angle = rng.choice([0, np.pi / 2, rng.uniform(0, 2 * np.pi)]) + np.pi * rng.integers(2)
    along = np.cos(angle) * columns + np.sin(angle) * rows
    kept = along <= np.quantile(along, 1 - share) if len(along) else np.zeros(0, bool)
    left = np.zeros_like(mask)
    left[rows[kept], columns[kept]] = True
    return left


def _cut_corner(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """Up to a quarter is lost at one side."""
    return _split(mask, rng.uniform(0.03, 0.25), rng)


def _halve(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """A third to two thirds are lost, as if it were segmented in two."""
    return _split(mask, rng.uniform(0.35, 0.7), rng)


def _pierce(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """Holes."""
    rows, columns = np.nonzero(mask)
    pierced, reach = mask.astype(np.uint8), np.sqrt(len(rows))
    for _ in range(int(rng.integers(1, 4)) if len(rows) else 0):
        at = int(rng.integers(len(rows)))
        axes = [max(1, int(reach * rng.uniform(0.05, 0.25))) for _ in range(2)]
        cv2.ellipse(pierced, (int(columns[at]), int(rows[at])), axes, float(rng.uniform(0, 180)), 0, 360, 0, -1)
    return pierced > 0


def _add_behind(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """A piece of what is beside or behind, as wide as a share of the mask."""
    reach = max(2, int(np.sqrt(mask.sum()) * rng.uniform(0.1, 0.5)))
    near = np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))) > 0
    return mask | _split(near & ~mask, rng.uniform(0.5, 0.95), rng)


def _add_neighbour(mask: Mask, owner: NDArray[np.uint8], rng: Rng) -> Mask:
    """All that shows of a thing that touches it."""
    near = np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8))) > 0
    beside = [one for one in np.unique(owner[near & ~mask]) if 1 < one < 255]
    return mask | (owner == rng.choice(beside)) if beside else mask


# What happens more often stands more often; chosen.
CHANGES = (
    *(_resize, _resize, _resize, _shift, _shift, _coarsen, _coarsen, _coarsen),
    *(_cut_corner, _cut_corner, _pierce, _pierce, _add_behind, _add_behind, _halve, _add_neighbour),
)


def cut_patch(free: Mask, rng: Rng) -> Mask:
    """A random piece of what is no thing: of floor, walls, ceiling."""
    rows, columns = np.nonzero(free)
    if not len(rows):
        return free
    at = int(rng.integers(len(rows)))
    height, width = (int(side) // 2 + 1 for side in np.exp(rng.uniform(np.log(0.06), np.log(0.9), 2)) * free.shape)
    drawn, x, y = np.zeros(free.shape, np.uint8), int(columns[at]), int(rows[at])
    if rng.random() < 0.5:
        cv2.ellipse(drawn, (x, y), (width, height), 0, 0, 360, 1, -1)
    else:
        cv2.rectangle(drawn, (x - width, y - height), (x + width, y + height), 1, -1)
    return (drawn > 0) & free
