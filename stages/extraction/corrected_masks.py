"""Masks and annotations after a person corrected masks, labels, counts and mountings."""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.hand import MEASURED, Correction
from roomkin.stages.contracts.parts import count_fronts, says_opening
from roomkin.stages.contracts.scenes import Annotation, Annotations, Held
from roomkin.stages.contracts.types import FLOOR, WALL, Pixel
from roomkin.stages.geometry.masks import pixel_bounds, polygons

ROOM = (FLOOR, WALL)  # labels of what is no object
AROUND = 0.25  # share of a box by which the picture around it is looked at, to tell what is behind; chosen
SWALLOWED = 0.5  # share of a thing that a later outline covers, from which a person is told; chosen
CUT_SIDE = 320  # pixels of the longer side at which GrabCut works; chosen for time


def list_found(annotations: Annotations) -> dict[int, Correction]:
    """Objects, floor and walls of an input folder as corrections, by mask value."""
    rooms = [(value, FLOOR) for value in [annotations.floor] if value is not None]
    rooms += [(value, WALL) for value in annotations.walls]
    kept = {"mask", "label", "articulated", "doors", "drawers", "panels", "mounting"}
    things = [Correction(**item.model_dump(include=kept)) for item in annotations.objects]
    return {item.mask: item for item in [*things, *(Correction(mask=value, label=label) for value, label in rooms)]}


def apply_corrections(found: dict[int, Correction], stated: dict[int, Correction]) -> dict[int, Correction]:
    """The found objects with the corrections applied; removed ones are left out."""
    merged = dict(found)
    for mask, item in stated.items():
        given = {name: getattr(item, name) for name in item.model_dump(exclude_defaults=True)}
        if item.mounting == MEASURED:
            given["mounting"] = None
        if item.panels:
            given |= count_fronts(item.panels)
        elif given.keys() & {"doors", "drawers"}:
            given["panels"] = []  # those that were found are of other doors and drawers
        merged[mask] = merged.get(mask, Correction(mask=mask)).model_copy(update=given)
    joined = {mask for item in merged.values() if not item.gone for mask in item.joins}
    return {mask: item for mask, item in merged.items() if not item.gone and mask not in joined}


class Cutter:
    """Cuts things out of a picture by their boxes (GrabCut), each box once."""

    def __init__(self, rgb: NDArray[np.uint8]) -> None:
        self.rgb = rgb
        self._done: dict[tuple[int, int, int, int], NDArray[np.bool_]] = {}

    def __call__(self, box: tuple[int, int, int, int]) -> NDArray[np.bool_]:
        """Mask (H, W) of what the box x0, y0, x1, y1 (exclusive) shows."""
        if box not in self._done:
            self._done[box] = self._cut(*box)
        return self._done[box]

    def _cut(self, x0: int, y0: int, x1: int, y1: int) -> NDArray[np.bool_]:
        height, width = self.rgb.shape[:2]
        mask = np.zeros((height, width), dtype=bool)
        margin = 2 + round(AROUND * max(x1 - x0, y1 - y0))
        left, top = max(0, x0 - margin), max(0, y0 - margin)
        part = self.rgb[top : y1 + margin, left : x1 + margin]
        scale = min(1.0, CUT_SIDE / max(part.shape[:2]))
        size = tuple(max(8, round(side * scale)) for side in part.shape[1::-1])
        small = np.ascontiguousarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA))
        zoom = size[0] / part.shape[1], size[1] / part.shape[0]
        low = round((x0 - left) * zoom[0]), round((y0 - top) * zoom[1])
        high = round((x1 - left) * zoom[0]), round((y1 - top) * zoom[1])
        kinds = np.full(small.shape[:2], cv2.GC_BGD, dtype=np.uint8)
        kinds[low[1] : high[1], low[0] : high[0]] = cv2.GC_PR_FGD
        if (kinds == cv2.GC_BGD).any() and (kinds == cv2.GC_PR_FGD).any():
            cv2.setRNGSeed(0)
            background, foreground = np.zeros((1, 65)), np.zeros((1, 65))
            cv2.grabCut(small, kinds, (0, 0, 0, 0), background, foreground, 4, cv2.GC_INIT_WITH_MASK)
        seen = ((kinds == cv2.GC_FGD) | (kinds == cv2.GC_PR_FGD)).astype(np.uint8)
        whole = cv2.resize(seen, part.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
        mask[top : top + part.shape[0], left : left + part.shape[1]] = whole
        if not mask[y0:y1, x0:x1].any():
            mask[y0:y1, x0:x1] = True
        return mask


def clip_box(box: tuple[Pixel, Pixel], width: int, height: int) -> tuple[int, int, int, int]:
    """Whole pixels of a drawn box, inside the picture, at least one."""
    (xa, ya), (xb, yb) = box
    x0, x1 = (int(np.clip(round(x), 0, width)) for x in sorted((xa, xb)))
    y0, y1 = (int(np.clip(round(y), 0, height)) for y in sorted((ya, yb)))
    x0, y0 = min(x0, width - 1), min(y0, height - 1)
    return x0, y0, max(x1, x0 + 1), max(y1, y0 + 1)


class CorrectedMasks(NamedTuple):
    """Corrected masks (H, W); `swallowed`: what a later outline mostly covers, with share and value of that outline."""

    masks: NDArray[np.uint16]
    swallowed: dict[int, tuple[float, int]]


def paint_masks(things: dict[int, Correction], found: NDArray[np.uint16], cut: Cutter) -> CorrectedMasks:
    """Paint the masks: objects over floor and walls, then by layer; else drawn over found ones, later over earlier."""
    masks = np.zeros_like(found)
    height, width = masks.shape
    pixels: dict[int, int] = {}
    swallowed: dict[int, tuple[float, int]] = {}
    for item in sorted(things.values(), key=lambda item: (item.label not in ROOM, item.layer, item.is_drawn)):
        if item.outlines:
            shown = polygons(item.outlines, masks.shape)
        elif item.around is not None:
            shown = cut(clip_box(item.around, width, height))
        else:
            shown = np.isin(found, [item.mask, *item.joins])
        for value, covered in zip(*np.unique(masks[shown], return_counts=True), strict=True):
            if value in pixels and covered > SWALLOWED * pixels[value]:
                swallowed[int(value)] = float(covered / pixels[value]), item.mask
        masks[shown] = item.mask
        if item.label not in ROOM:  # what stands before floor and walls takes nothing from them
            pixels[item.mask] = int(shown.sum())
    return CorrectedMasks(masks, swallowed)


def list_losses(things: dict[int, Correction], painted: CorrectedMasks) -> dict[int, str]:
    """Things that lost pixels, by mask value: all their pixels, or most of them to a later outline."""
    shown = set(np.unique(painted.masks).tolist())
    losses = {mask: "no pixel shows it, left out" for mask in things if mask not in shown}
    for mask, (share, by) in painted.swallowed.items():
        where = f"under the outline of {things[by].label or 'object'}"
        losses[mask] = f"{int(100 * share)} % of it is {where}" if mask in shown else f"{losses[mask]}: it is {where}"
    return losses


def correct_masks(
    given: Annotations, found: NDArray[np.uint16], stated: dict[int, Correction], cut: Cutter
) -> tuple[Annotations | None, NDArray[np.uint16], list[str]]:
    """Corrected annotations and masks (H, W), and a line for each thing of which something is lost. None: no object is
    left."""
    things = apply_corrections(list_found(given), stated)
    painted = paint_masks(things, found, cut)
    masks, shown = painted.masks, set(np.unique(painted.masks).tolist())
    seen = [item for mask, item in things.items() if mask in shown]
    notes = [f"{things[mask].label or 'object'}: {what}" for mask, what in list_losses(things, painted).items()]
    floors = [item.mask for item in seen if item.label == FLOOR]
    masks = np.where(np.isin(masks, floors), floors[0], masks).astype(np.uint16) if floors else masks
    walls = [item.mask for item in seen if item.label == WALL]
    known = {item.mask: item for item in given.objects}
    objects = []
    for item in (entry for entry in seen if entry.label not in ROOM):
        held = item.mounting if isinstance(item.mounting, Held) else None
        if held is not None and not set(held.walls) <= set(walls):
            notes.append(f"{item.label or 'object'}: its wall is gone, mounting by geometry")
            held = None
        doors, drawers = item.doors or 0, item.drawers or 0
        before = None if item.is_drawn else known.get(item.mask)
        objects.append(Annotation(
            mask=item.mask, label=item.label or "object", doors=doors, drawers=drawers, panels=item.panels or [],
            articulated=is_opening(item, known.get(item.mask)) or doors + drawers > 0, mounting=held,
            **(keep_known(item, before) if before else {}),
        ))  # fmt: skip
    if not objects:
        return None, masks, notes
    return Annotations(objects=objects, floor=floors[0] if floors else None, walls=walls), masks, notes


def is_opening(item: Correction, found: Annotation | None) -> bool:
    """Whether it opens, as far as its doors and drawers are not counted. A proposed name said so, and another name that
    a person gives says it anew."""
    if found is not None and found.proposals and item.label != found.label and item.articulated == found.articulated:
        return says_opening(item.label or "")
    return bool(item.articulated)


def keep_known(item: Correction, before: Annotation) -> dict[str, Any]:
    """Its stated box and front; the names that were proposed for it, and their doubts, unless a person names it."""
    known = before.model_dump(include={"box", "guessed", "front"})
    if item.named or item.label != before.label:
        return known
    doubts = [one for one in before.doubts if one.cause == "name"]
    return known | {"proposals": before.proposals, "probabilities": before.probabilities, "doubts": doubts}


def find_corners(mask: NDArray[np.bool_]) -> tuple[Pixel, Pixel] | None:
    """Opposite corners of a mask's pixels."""
    if not mask.any():
        return None
    x0, y0, x1, y1 = pixel_bounds(mask)
    return (x0, y0), (x1, y1)
