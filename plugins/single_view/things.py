"""Things of a picture without depth: outlines by the same networks as with depth, names by what they look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.choosing import KNOWN, Outlined, choose
from plugins.eyes.proposal import RoomView, find_border
from plugins.eyes.proposers import mobile_sam, ssd
from plugins.eyes.surfaces import Surfaces
from plugins.names.observed import Observed, classify
from plugins.names.propose import Names, propose_names
from plugins.single_view.ends import Ends, measure_all
from plugins.single_view.outline_kinds import FLOOR, KINDS, WALL, tell_kinds

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ALIGNED = 0.15  # of their width, by which the sides of pieces of one front are apart at most; chosen


@dataclass(frozen=True)
class Seen:
    """An outline (H, W), how likely each of `KINDS` is (6,), its names, and whether COCO's network knows it."""

    mask: Mask
    kinds: Array
    names: Names
    known: bool

    @property
    def kind(self) -> str:
        """What it shows."""
        return KINDS[int(self.kinds.argmax())]

    def choose_kind(self, without: str) -> str:
        """What it shows, if it is not this."""
        return KINDS[int(np.where(np.array(KINDS) == without, 0, self.kinds).argmax())]

    @property
    def is_sure(self) -> bool:
        """Whether COCO's network knows it, and a category of the library is likelier than none."""
        return self.known and self.names.proposals[0].probability > self.names.other


def see_outlines(rgb: NDArray[np.uint8]) -> Sequence[Seen]:
    """The outlines of a picture (H, W, 3), no pixel in two; those of known things first."""
    view = make_view(rgb)
    found = choose(view, [*ssd.propose(view), *mobile_sam.propose(view)])
    first = tell_kinds(view.embedded.features, [one.mask for one in found])
    found = join_stacked(rgb, found, [KINDS[kind] for kind in first.argmax(axis=1)])
    told = tell_kinds(view.embedded.features, [one.mask for one in found])
    return [see_outline(rgb, one, kinds) for one, kinds in zip(found, told, strict=True)]


def see_outline(rgb: NDArray[np.uint8], one: Outlined, kinds: Array) -> Seen:
    """An outline with its names."""
    names = propose_names(Observed(None, classify(rgb, one.mask)), one.words or None)
    return Seen(one.mask, kinds, names, is_known(one))


def is_known(one: Outlined) -> bool:
    """Whether COCO's network knows an outline."""
    return max(one.words.values(), default=0.0) >= KNOWN


def join_stacked(rgb: NDArray[np.uint8], found: Sequence[Outlined], kinds: Sequence[str]) -> list[Outlined]:
    """The outlines, those that lie right above another and are as wide joined to it: drawers over doors."""
    masks = [
        one.mask if kind not in (WALL, FLOOR) else np.zeros_like(one.mask)
        for one, kind in zip(found, kinds, strict=True)
    ]
    free = {value for value, one in enumerate(found, 1) if not is_known(one) and masks[value - 1].any()}
    ends, pieces = measure_outlines(rgb, masks), [one.mask for one in found]
    for value in sorted(free, key=lambda value: -ends[value].at[3]):
        own, below = ends[value].at, ends[value].met[3]
        if below not in free:
            continue
        other = ends[below].at
        wide = min(own[0] + own[2], other[0] + other[2])
        if max(abs(own[0] - other[0]), abs(own[2] - other[2])) < ALIGNED * wide:
            pieces[below - 1], pieces[value - 1] = pieces[below - 1] | pieces[value - 1], np.zeros_like(pieces[0])
    return [replace(one, mask=mask) for one, mask in zip(found, pieces, strict=True) if mask.any()]


def measure_outlines(rgb: NDArray[np.uint8], masks: Sequence[Mask]) -> Mapping[int, Ends]:
    """The ends of masks (H, W), by their places from 1; of those that show nothing none."""
    values = number_masks(rgb, dict(enumerate(masks, 1)))
    return measure_all(values, [value for value, mask in enumerate(masks, 1) if mask.any()], ~find_border(rgb))


def make_view(rgb: NDArray[np.uint8]) -> RoomView:
    """A picture of which nobody knows depth, ground or walls."""
    shape = rgb.shape[:2]
    nothing = np.zeros(shape, dtype=bool)
    points = np.zeros((*shape, 3))
    return RoomView(
        rgb, np.zeros(shape), np.eye(3), Surfaces(np.eye(4), points, 0.0, nothing, nothing, [], [], nothing)
    )


def number_masks(rgb: NDArray[np.uint8], masks: Mapping[int, Mask]) -> NDArray[np.uint16]:
    """One picture (H, W) of the masks of a picture (H, W, 3), with the value of each."""
    values = np.zeros(rgb.shape[:2], np.uint16)
    for value, mask in masks.items():
        values[mask] = value
    return values


def number_labelled(rgb: NDArray[np.uint8], seen: Sequence[Seen], labels: Mapping[int, str]) -> NDArray[np.uint16]:
    """Masks (H, W) of the outlines that have labels, by their places from 1."""
    return number_masks(rgb, {value: seen[value - 1].mask for value in sorted(labels)})
