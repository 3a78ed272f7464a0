"""What a person does on the correcting page until the things of a picture are as if drawn and named by hand.

The rule, in clicks (or keys in their place) and typed words:

* a name: none if it is sensible; one if it is another of those proposed beside its doubt; else one, and a word. A name
  that is not in doubt takes one more: its thing is chosen first;
* pieces of one thing: one to choose it, and two for each other piece (Join, and the piece);
* a thing that no pieces show: a box (B and two corners) if what the page cuts out by it has an IoU above .5, else an
  outline (O, its corners, Enter); and a word;
* doors, drawers: one and a number each, one more to choose what was not drawn;
* a piece that is no named thing and became an object: two, to choose and to delete it.

By hand every thing is drawn. Floor and walls are left out on both sides.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.open_rooms import packs, pictures
from benchmarks.open_rooms.pairs import FOUND, overlaps, pair_pieces
from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.contracts import Objects, read_json
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.scene_input import read_annotations
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.corrected_masks import Cutter
from roomkin.stages.geometry.masks import pixel_bounds

OFF = 4.0  # pixels that an outline may be off, as those of `drawn` are
BOX = 3  # clicks
DELETE = 2


class Effort(NamedTuple):
    """Clicks, and words or numbers that are typed."""

    clicks: int = 0
    words: int = 0


@dataclass(frozen=True)
class Step:
    """What is done about a thing, or about a piece that is none.

    Attributes:
        number: of the thing; 0: none.
        kind: of the thing.
        mask: found (one piece shows it), joined (several do), drawn (none), deleted (what shows none).
        name: first, chosen (from those proposed), typed.
        value: of the thing in the corrected masks.
        unaided: effort to correct.
        by_hand: effort to draw and to name it.
        correction: None: nothing is done.
    """

    number: int
    kind: str
    mask: str
    name: str
    value: int
    unaided: Effort
    by_hand: Effort
    correction: Correction | None


def draw_thing(shown: NDArray[np.bool_], cut: Cutter) -> tuple[dict[str, Any], int]:
    """How a thing (H, W) is drawn: keys of a correction, and clicks."""
    x0, y0, x1, y1 = pixel_bounds(shown)
    by_box = cut((x0, y0, x1, y1))
    if (by_box & shown).sum() > FOUND * (by_box | shown).sum():
        return {"around": ((x0, y0), (x1, y1))}, BOX
    curves, _ = cv2.findContours(shown.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    outline = cv2.approxPolyDP(max(curves, key=cv2.contourArea), OFF, True)[:, 0].tolist()
    return {"outline": outline}, len(outline) + 2


def name_piece(item: Annotation, thing: TrueThing, sensible: Sequence[str]) -> tuple[str, str, Effort]:
    """How a piece gets its name, the name, and the effort."""
    names = item.proposals or [item.label]
    right = [name for name in names if name.replace(" ", "_") in sensible]
    choose = 0 if any(doubt.cause == "name" for doubt in item.doubts) else 1
    if names[0] in right:
        return "first", names[0], Effort()
    if right:
        return "chosen", right[0], Effort(1 + choose)
    return "typed", thing.label, Effort(1 + choose, 1)


def plan_steps(
    things: Sequence[TrueThing],
    exact: NDArray[np.uint16],
    found: NDArray[np.uint16],
    pieces: Sequence[Annotation],
    placed: set[int],
    cut: Cutter,
) -> list[Step]:
    """What is done about things and pieces.

    Args:
        things: that a person would name; by `number` in `exact` (H, W).
        exact: true masks.
        found: masks (H, W) without a hand.
        pieces: the objects among them.
        placed: values of the pieces that became objects.
        cut: the page's, of the picture.
    """
    items, free = {item.mask: item for item in pieces}, int(found.max())
    found = np.where(np.isin(found, list(items)), found, 0).astype(np.uint16)
    iou, inside = overlaps(exact, found)
    pairs = pair_pieces([thing.number for thing in things], iou)
    used, steps = set[int](), list[Step]()
    for thing in things:
        shown = exact == thing.number
        drawn, clicks = draw_thing(shown, cut)
        counts = {name: count for name in ("doors", "drawers") if (count := getattr(thing, name))}
        by_hand = Effort(clicks + len(counts), 1 + len(counts))
        parts = [value for value in items if inside[thing.number, value] > FOUND] if items else []
        union = np.isin(found, parts)
        whole = (union & shown).sum() > FOUND * (union | shown).sum()
        main = pairs.get(thing.number) or (max(parts, key=lambda value: iou[thing.number, value]) if whole else None)
        if main is None:
            value = free + thing.number
            correction = Correction(mask=value, label=thing.label, named=True, **counts, **drawn)
            steps.append(Step(thing.number, thing.kind, "drawn", "typed", value, by_hand, by_hand, correction))
            continue
        others = [value for value in parts if value != main]
        used |= {main, *others}
        how, name, naming = name_piece(items[main], thing, packs.kinds()[thing.kind].sensible)
        said = {"label": name, "named": True} if how != "first" else {}
        said |= counts | ({"joins": others} if others else {})
        clicks = naming.clicks + bool(others) + 2 * len(others) + bool(counts) + len(counts)
        effort = Effort(clicks, naming.words + len(counts))
        correction = Correction.model_validate({"mask": main, **said}) if said else None
        mask = "joined" if others else "found"
        steps.append(Step(thing.number, thing.kind, mask, how, main, effort, by_hand, correction))
    gone = [Correction(mask=value, gone=True) for value in sorted((placed & set(items)) - used)]
    return steps + [Step(0, "", "deleted", "", one.mask, Effort(DELETE), Effort(), one) for one in gone]


@cache
def plan_corrections(root: Path, folder: Path) -> list[Step]:
    """The steps of a picture that `run` has reconstructed unaided; if that stopped, all is drawn."""
    made = root / "results" / "unaided" / folder.name
    exact = pictures.read_masks(folder)
    things = [thing for thing in pictures.read(folder).things if thing.named]
    found, pieces, placed = np.zeros_like(exact), list[Annotation](), set[int]()
    if (path := made / "extraction" / "objects.json").is_file():
        annotations, found = read_annotations(made / "input" / "annotations.json")
        pieces = annotations.objects
        placed = {item.mask for item in read_json(Objects, path).objects if item.status == "ok"}
    return plan_steps(things, exact, found, pieces, placed, Cutter(read_rgb(folder / "rgb.png")))


def find_things(root: Path, folder: Path, masks: str) -> dict[int, int]:
    """The value that every named thing has in masks that nobody made by hand, by number; 0: nothing shows it."""
    if masks == "corrected":
        return {step.number: step.value for step in plan_corrections(root, folder) if step.number}
    numbers = [thing.number for thing in pictures.read(folder).things if thing.named]
    annotations, found = read_annotations(root / "results" / masks / folder.name / "input" / "annotations.json")
    pieces = np.where(np.isin(found, [item.mask for item in annotations.objects]), found, 0).astype(np.uint16)
    pairs = pair_pieces(numbers, overlaps(pictures.read_masks(folder), pieces)[0])
    return {number: pairs.get(number, 0) for number in numbers}


def list_steps(root: Path, folder: Path) -> list[dict[str, Any]]:
    """The steps of a picture as rows of a table."""
    picture = pictures.read(folder)
    return [
        {
            "half": picture.half, "picture": picture.name, "number": step.number, "kind": step.kind, "mask": step.mask,
            "name": step.name, "clicks": step.unaided.clicks, "words": step.unaided.words,
            "clicks_by_hand": step.by_hand.clicks, "words_by_hand": step.by_hand.words,
        }
        for step in plan_corrections(root, folder)
    ]  # fmt: skip
