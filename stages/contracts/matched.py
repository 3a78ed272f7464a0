"""A person's corrections, matched with the masks that are there: a thing is known by its place, not by its number."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError

from roomkin.stages.contracts.hand import Correction, Corrections, Shown, Unmatched
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.contracts.types import Pixel
from roomkin.stages.geometry.masks import Mask, outline_mask, outline_pieces, polygons

SAME = 0.5  # intersection over union of two outlines, from which on they are of one thing: so two never share a partner
Masks = NDArray[np.uint16]
WORDS = {"joins": "a part of it", "on": "what it stands on", "like": "what it is like", "mounting": "its wall"}


class Matched(NamedTuple):
    """The corrections by the mask values that there are now; what is not applied, and a line for each of these."""

    corrections: dict[int, Correction]
    unmatched: list[Unmatched]
    lines: list[str]


def digest_masks(masks: Masks) -> str:
    """SHA-256 of masks (H, W), whatever their file looks like."""
    return hashlib.sha256(f"{masks.shape}".encode() + masks.astype("<u2").tobytes()).hexdigest()


def show_masks(named: Iterable[int], masks: Masks, labels: Mapping[int, str]) -> list[Shown]:
    """What the masks (H, W) show that corrections name, for when they are numbered otherwise; `labels`: by value."""
    pieces = {mask: outline_pieces(masks == mask) for mask in sorted(named)}
    return [Shown(mask=mask, label=labels.get(mask, ""), outlines=found) for mask, found in pieces.items() if found]


def match_corrections(said: Corrections, masks: Masks, picture: str) -> Matched:
    """The corrections of the things that are at the places of those that a person spoke of.

    As long as the masks are the same, numbers say which these are; else outlines: `SAME` of their union in common. What
    finds no partner is not applied. What was drawn keeps its outline, in the place of the thing found there, if any.

    Args:
        said: of corrections.json.
        masks: (H, W), as they were found.
        picture: SHA-256 of the picture's file.
    """
    if said.digest not in ("", picture):
        count = len(said.objects) + len(said.unmatched)
        return Matched({}, [], [f"corrections.json is of another picture: none of its corrections ({count}) applies"])
    width, height = masks.shape[::-1]
    if said.size not in (None, (width, height)):
        said = _scale(said, width / said.size[0], height / said.size[1])
    places = _Places(masks)
    now = places.keep(said) if said.masks in ("", digest_masks(masks)) else places.find(said.shown, said.objects)
    matched = Matched({}, [], [])
    shown = {one.mask: one for one in [*_show_drawn(said.objects), *said.shown]}
    for item in said.objects:
        kept = Unmatched(correction=item, shown=[shown[mask] for mask in sorted(item.named_masks) if mask in shown])
        _apply(kept, now, matched)
    for kept in said.unmatched:
        _apply(kept, places.find(kept.shown), matched)
    return matched


def _apply(said: Unmatched, now: Mapping[int, int], matched: Matched) -> None:
    """Add a correction to what is matched, as far as what it names is found; the rest to what is not."""
    item, rest = said.correction, _take_lost(said.correction, now)
    applied = None if rest is item else _renumber(item, rest, now)
    if applied is not None:
        before = matched.corrections.get(applied.mask)
        said_since = before.model_dump(exclude_defaults=True) if before else {}
        try:
            merged = Correction.model_validate(applied.model_dump(exclude_defaults=True) | said_since)
            Corrections(objects=[*(matched.corrections | {merged.mask: merged}).values()])
            matched.corrections[merged.mask] = merged
        except ValidationError:  # what was said since says otherwise
            rest = item
    if rest is not None:
        matched.unmatched.append(Unmatched(correction=rest, shown=said.shown))
        matched.lines.append(_tell(said, rest, item))


def _take_lost(item: Correction, now: Mapping[int, int]) -> Correction | None:
    """What of a correction is about masks that are not found; all of it if its own is not; None: nothing."""
    if item.mask not in now:
        return item
    lost: dict[str, Any] = {"joins": [mask for mask in item.joins if mask not in now]}
    lost |= {key: mask for key in ("on", "like") if isinstance(mask := getattr(item, key), int) and mask not in now}
    if isinstance(item.mounting, Held) and not set(item.mounting.walls) <= set(now):
        lost["mounting"] = item.mounting
    return Correction(mask=item.mask, **lost) if any(lost.values()) else None


def _renumber(item: Correction, lost: Correction | None, now: Mapping[int, int]) -> Correction | None:
    """A correction without what is lost of it, with the masks that there are now; None: nothing is left of it."""
    given: dict[str, Any] = item.model_dump(exclude_defaults=True)
    for key in lost.model_dump(exclude_defaults=True, exclude={"mask", "joins"}) if lost else ():
        del given[key]
    given |= {key: now[given[key]] for key in ("mask", "on", "like") if isinstance(given.get(key), int)}
    given["joins"] = [now[mask] for mask in item.joins if mask in now]
    if isinstance(held := given.get("mounting"), dict):
        given["mounting"] = held | {"walls": [now[wall] for wall in held.get("walls", [])]}
    found = Correction.model_validate(given)
    return found if found.model_dump(exclude_defaults=True, exclude={"mask"}) else None


def _tell(said: Unmatched, rest: Correction, item: Correction) -> str:
    """A line about what is not applied."""
    label = next((one.label for one in said.shown if one.mask == item.mask), "")
    called = f"'{item.label}', found as '{label}'" if item.label and label not in ("", item.label) else ""
    name = f"{called or item.label or label or 'object'} (mask {item.mask})"
    keys = rest.model_dump(exclude_defaults=True, exclude={"mask"})
    what = " and ".join(WORDS[key] for key in keys) if rest is not item else "it"
    return f"{name}: {what} is not found now: that correction is kept, not applied"


class _Places:
    """Where things are in masks (H, W), each found once."""

    def __init__(self, masks: Masks) -> None:
        self.masks = masks
        self.values = set(np.unique(masks).tolist()) - {0}
        self._filled: dict[int, Mask] = {}

    def keep(self, said: Corrections) -> dict[int, int]:
        """The masks that are there under their numbers, and what was drawn."""
        there = self.values | {item.mask for item in said.objects if item.is_drawn}
        return {mask: mask for mask in there}

    def find(self, shown: Sequence[Shown], objects: Iterable[Correction] = ()) -> dict[int, int]:
        """By the number that a thing had, the one that it has: that of what is found there, or a free one if drawn."""
        now: dict[int, int] = {}
        objects, seen = list(objects), {one.mask for one in shown}
        for one in [*shown, *_show_drawn(item for item in objects if item.mask not in seen)]:
            partner = self._find_partner(one.outlines)
            if partner and partner not in now.values():
                now[one.mask] = partner
        for item in objects:
            joined = item.mask not in seen and any(mask in now for mask in item.joins)
            if item.mask not in now and (item.outlines or item.around or joined):
                taken = self.values | set(now.values())
                free = 1 + max([*taken, *(one.mask for one in objects)])
                now[item.mask] = free if item.mask in taken else item.mask
        return now

    def _find_partner(self, outlines: Sequence[ArrayLike]) -> int:
        """The mask that has most of its pixels in common with outlines; 0: none has enough."""
        inside = polygons(outlines, self.masks.shape)
        shares = {}
        for value in set(np.unique(self.masks[inside]).tolist()) - {0}:
            if value not in self._filled:
                self._filled[value] = polygons(outline_mask(self.masks == value), self.masks.shape)
            shares[value] = (inside & self._filled[value]).sum() / (inside | self._filled[value]).sum()
        best = max(shares, key=lambda value: shares[value], default=0)
        return best if shares.get(best, 0) > SAME else 0


def _show_drawn(objects: Iterable[Correction]) -> Iterator[Shown]:
    """Things that a person drew, as masks show others."""
    for item in objects:
        (x0, y0), (x1, y1) = item.around or ((0, 0), (0, 0))
        outlines = item.outlines or ([[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]] if item.around else [])
        if outlines:
            yield Shown(mask=item.mask, label=item.label or "", outlines=outlines)


def _scale(said: Corrections, across: float, down: float) -> Corrections:
    """Corrections whose outlines are those of a picture so much larger."""

    def scale(points: Iterable[Pixel]) -> list[Pixel]:
        return [(across * x, down * y) for x, y in points]

    def resize(item: Correction) -> Correction:
        around = None if item.around is None else tuple(scale(item.around))
        pieces = [scale(piece) for piece in item.pieces]
        return item.model_copy(update={"outline": scale(item.outline), "pieces": pieces, "around": around})

    def resize_shown(shown: list[Shown]) -> list[Shown]:
        return [one.model_copy(update={"outlines": [scale(points) for points in one.outlines]}) for one in shown]

    unmatched = [Unmatched(correction=resize(one.correction), shown=resize_shown(one.shown)) for one in said.unmatched]
    given = {"objects": [resize(item) for item in said.objects], "unmatched": unmatched}
    return said.model_copy(update=given | {"shown": resize_shown(said.shown)})
