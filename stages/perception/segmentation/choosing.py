"""Choose among proposals: what shows one whole thing each, so that no pixel is shown twice.

First what a network that knows things has found, surest first; then the rest, well outlined and large first: wholes
before their parts. What is ground or wall is no thing; what is flat on a wall must be compact, and wall around it.
What stands on the level top of something is a thing of its own; other pieces within the outline of a thing are parts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from roomkin.stages.perception.camera.surfaces import NOISE
from roomkin.stages.perception.segmentation.proposal import Array, Mask, Proposal, RoomView

KNOWN = 0.3  # least score of a class of COCO from which on its outline comes first; chosen
MIN_PIXELS = 25  # of an outline, whose picture has a longer side of 256; chosen
LARGEST = 0.35  # share of the picture that a thing of no known class covers at most; chosen
FREE = 0.7  # share of an outline that nothing chosen before it has taken; chosen
FREE_KNOWN = 0.5  # likewise, of a known class: a sofa behind a table; chosen
ON_GROUND = 0.5  # share of an outline that shows the ground, above which it is no thing; chosen
ON_GROUND_KNOWN = 0.85  # likewise, of a known class: a bowl, all but its rim; chosen
ON_WALL = 0.6  # share that shows a wall, or what is behind one, above which it is flat on the wall; chosen
CRISP = 0.95  # least score of the outline of a flat thing: a picture's is clear, that of a piece of wall is not; chosen
COMPACT = 0.72  # share of its turned rectangle that a flat thing fills; chosen
LARGEST_FLAT = 0.12  # share of the picture that it covers at most; chosen
WALL_AROUND = 0.5  # share of what is around it that shows a wall; chosen
CUT = 0.35  # share of its outline that may lie on the picture's edge; chosen
SEATS = {"bed", "chair", "couch"}  # cushions and covers that lie on them belong to them
WITHIN = 0.7  # share of a piece that lies within a thing's hull or box, above which it is a part; chosen
ROW = 1.2  # metres that a row of things is long at least: fewer is a wardrobe with two doors; chosen
MIN_PIECE, IN_ROW = 0.15, 0.85  # share of a row that a piece has at least, and of a piece that lies in it; chosen
RISES, ON_TOP = 0.01, 0.6  # metres above a level top, and the share of a piece's points that rise so far; chosen
LEVEL_TOP = 0.4  # share of a thing's points that lie at one height, within 2 `RISES`, if it has a level top; chosen
ALIKE = 0.15  # metres by which the depth of a part is out of that of its thing at most; chosen


@dataclass(frozen=True)
class Outlined:
    """One thing: its pixels (H, W), how good its outline is, what proposed it, COCO's classes with their scores, and
    whether it is flat on a wall."""

    mask: Mask
    score: float
    source: str
    words: Mapping[str, float]
    flat: bool


@dataclass(frozen=True)
class Choice:
    """A proposal and the pixels (h, w) that it gets."""

    proposal: Proposal
    mask: Mask
    flat: bool = False


class Chooser:
    """One picture, in the pixels of outlines (h, w)."""

    def __init__(self, view: RoomView) -> None:
        self.view = view
        surfaces = view.surfaces
        self.border, self.floor, self.beyond = map(view.shrink, (view.border, surfaces.floor, surfaces.beyond))
        self.depth = cv2.resize(view.depth, view.small, interpolation=cv2.INTER_NEAREST)
        self.points = cv2.resize(surfaces.points, view.small, interpolation=cv2.INTER_NEAREST)
        self.heights = self.points[..., 2]

    def choose(self, proposals: Sequence[Proposal]) -> list[Choice]:
        """The things, each pixel of one at most; those of known classes first."""
        chosen, taken = list[Choice](), self.border.copy()
        known = [one for one in proposals if one.known >= KNOWN]
        for one in sorted(known, key=lambda one: -one.known):
            free = one.mask & ~taken
            enough = free.sum() >= max(MIN_PIXELS, FREE_KNOWN * one.mask.sum())
            if enough and share(self.floor, free) <= ON_GROUND_KNOWN:
                hung = share(self.beyond, free & (self.depth > 0)) > ON_WALL and self.hangs_flat(free)
                chosen.append(Choice(one, free, hung))
                taken |= free
        others = [one for one in proposals if one.known < KNOWN and not self.is_row(one, proposals)]
        for one in sorted(others, key=lambda one: -one.score * np.log(max(one.mask.sum(), 2))):
            mask = one.mask & ~self.border
            flat = share(self.beyond, mask & (self.depth > 0)) > ON_WALL
            if mask.sum() > LARGEST * mask.size or share(self.floor, mask) > ON_GROUND:
                continue
            if mask.sum() < MIN_PIXELS or (flat and not (one.score >= CRISP and self.hangs_flat(mask))):
                continue
            carrier = self.find_carrier(chosen, mask)
            free = mask & ~taken if carrier is None else mask & (~taken | chosen[carrier].mask)
            if free.sum() >= max(MIN_PIXELS, FREE * mask.sum()):
                if carrier is not None:
                    chosen[carrier] = replace(chosen[carrier], mask=chosen[carrier].mask & ~free)
                chosen.append(Choice(one, free, flat))
                taken |= free
        return self.join_parts(chosen)

    def is_row(self, one: Proposal, proposals: Sequence[Proposal]) -> bool:
        """Whether a proposal is a row of things side by side, as cabinets of a kitchen, each proposed as well."""
        points = self.points[one.mask & (self.depth > 0)][:, :2]
        if len(points) < MIN_PIXELS or max(cv2.minAreaRect(points.astype(np.float32))[1]) < ROW:
            return False
        tall, rest = one.mask.any(axis=1).sum(), one.mask.copy()
        for part in sorted(proposals, key=lambda part: -part.score):
            inside = part.mask & one.mask
            is_piece = MIN_PIECE < share(part.mask, one.mask) < 1 - MIN_PIECE and share(one.mask, part.mask) > IN_ROW
            if is_piece and inside.any(axis=1).sum() > FREE * tall and share(rest, inside) > IN_ROW:
                rest &= ~inside
        return share(rest, one.mask) < 1 - IN_ROW

    def hangs_flat(self, mask: Mask) -> bool:
        """Whether a mask may be a thing that hangs flat on a wall: small, near a rectangle, with wall around it."""
        if mask.sum() > LARGEST_FLAT * mask.size:
            return False
        around = cv2.dilate(np.pad(mask, 2).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        ring = around[2:-2, 2:-2] & ~mask & ~self.border
        outline, inside = mask & ~erode(mask), erode(~self.border)
        rows, columns = np.nonzero(mask)
        _, (long, short), _ = cv2.minAreaRect(np.stack([columns, rows], axis=1).astype(np.float32))
        return bool(
            len(rows) > COMPACT * (long + 1) * (short + 1)
            and share(self.beyond, ring) >= WALL_AROUND
            and share(~inside, outline) <= CUT
        )

    def find_carrier(self, chosen: Sequence[Choice], mask: Mask) -> int | None:
        """Which of the chosen things has taken most of a mask that stands on its level top; None: none."""
        for k, one in enumerate(chosen):
            covers = share(one.mask, mask) > 1 - FREE and one.mask.sum() > 2 * mask.sum()
            can_carry = not one.flat and one.proposal.word not in SEATS
            if covers and can_carry and self.stands_on(mask, one.mask & ~mask):
                return k
        return None

    def stands_on(self, mask: Mask, carrier: Mask) -> bool:
        """Whether most of a piece rises above the level at which most of its carrier lies."""
        heights = self.heights[carrier & (self.depth > 0)]
        own = self.heights[mask & (self.depth > 0)]
        if len(heights) < MIN_PIXELS or not len(own):
            return False
        thick = max(2 * RISES, NOISE * float(np.median(self.depth[mask & (self.depth > 0)])) ** 2)
        counts, edges = np.histogram(heights, np.arange(heights.min(), heights.max() + 2 * thick, thick))
        if counts.max() < LEVEL_TOP * len(heights):
            return False  # it has no level top
        top = float(edges[counts.argmax()]) + thick
        return bool((own > top).mean() > ON_TOP and np.quantile(own, 0.05) < top + ALIKE)

    def join_parts(self, chosen: list[Choice]) -> list[Choice]:
        """What was chosen; pieces of no known class that are parts of a thing of a known class belong to it."""
        kept = list[Choice]()
        for one in chosen:
            whole = next((k for k, other in enumerate(kept) if self.is_part(one, other)), None)
            if whole is None:
                kept.append(one)
            else:
                kept[whole] = replace(kept[whole], mask=kept[whole].mask | one.mask)
        return kept

    def is_part(self, one: Choice, whole: Choice) -> bool:
        """Whether a piece of no known class lies within a thing of a known one and at its depth, and not on its top."""
        if one.flat or one.proposal.known >= KNOWN or whole.proposal.box is None or whole.proposal.known < KNOWN:
            return False
        scale = max(self.depth.shape) / max(self.view.depth.shape)
        x0, y0, x1, y1 = (round(side * scale) for side in whole.proposal.box)
        box = np.zeros_like(one.mask)
        box[max(0, y0) : y1, max(0, x0) : x1] = True
        if share(box, one.mask) < WITHIN or one.mask.sum() > whole.mask.sum():
            return False
        own, others = (self.depth[mask & (self.depth > 0)] for mask in (one.mask, whole.mask))
        if not len(own) or not len(others):
            return False
        near, far = np.quantile(others, [0.02, 0.98])
        if not near - ALIKE < np.median(own) < far + ALIKE:
            return False
        return whole.proposal.word in SEATS or not self.stands_on(one.mask, whole.mask)


def choose(view: RoomView, proposals: Sequence[Proposal]) -> list[Outlined]:
    """The things of a picture at its size; a pixel on the line between two is of the first."""
    size, found = view.depth.shape[::-1], list[Outlined]()
    taken = view.border.copy()
    for one in Chooser(view).choose(proposals):
        whole = _enlarge(one, size) & ~taken
        found.append(Outlined(whole, one.proposal.score, one.proposal.source, one.proposal.words, one.flat))
        taken |= whole
    return [one for one in found if one.mask.any()]


def erode(mask: Mask) -> Mask:
    """A mask (h, w) without its outermost pixels, and those at the picture's edge."""
    return np.asarray(cv2.erode(np.pad(mask, 1).astype(np.uint8), np.ones((3, 3), np.uint8))[1:-1, 1:-1] > 0)


def share(part: Mask, mask: Mask) -> float:
    """Share of a mask (h, w) that is of a part of the picture (h, w)."""
    return float((part & mask).sum() / max(1, mask.sum()))


def _enlarge(one: Choice, size: tuple[int, int]) -> Mask:
    """The pixels of a choice in the picture; where they are those of its outline, as finely as that tells."""
    logits = one.proposal.logits.astype(np.float32).clip(-4, 4)
    agreeing = np.where(one.mask, np.maximum(logits, 0.5), np.minimum(logits, -0.5))
    enlarged: Array = cv2.resize(agreeing, size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(enlarged > 0)
