"""Things of a picture without depth: outlines by the same networks as with depth, names by what they look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.choosing import KNOWN, Outlined, choose
from plugins.eyes.proposal import RoomView
from plugins.eyes.proposers import mobile_sam, ssd
from plugins.eyes.surfaces import Surfaces
from plugins.names.observed import Observed, classify
from plugins.names.propose import Names, propose_names

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Seen:
    """An outline (H, W), how good it is, its names, and whether COCO's network knows it."""

    mask: Mask
    score: float
    names: Names
    known: bool

    @property
    def is_sure(self) -> bool:
        """Whether COCO's network knows it, and a category of the library is likelier than none."""
        return self.known and self.names.proposals[0].probability > self.names.other


def see_outlines(rgb: NDArray[np.uint8]) -> Sequence[Seen]:
    """The outlines of a picture (H, W, 3), no pixel in two; those of known things first."""
    view = make_view(rgb)
    found = choose(view, [*ssd.propose(view), *mobile_sam.propose(view)])
    return [see_outline(rgb, one) for one in found]


def see_outline(rgb: NDArray[np.uint8], one: Outlined) -> Seen:
    """An outline with its names."""
    known = max(one.words.values(), default=0.0) >= KNOWN
    names = propose_names(Observed(None, classify(rgb, one.mask)), one.words or None)
    return Seen(one.mask, one.score, names, known)


def make_view(rgb: NDArray[np.uint8]) -> RoomView:
    """A picture of which nobody knows depth, ground or walls."""
    shape = rgb.shape[:2]
    nothing = np.zeros(shape, dtype=bool)
    points = np.zeros((*shape, 3))
    return RoomView(
        rgb, np.zeros(shape), np.eye(3), Surfaces(np.eye(4), points, 0.0, nothing, nothing, [], [], nothing)
    )


def number_masks(rgb: NDArray[np.uint8], seen: Mapping[int, Seen]) -> NDArray[np.uint16]:
    """Masks (H, W) of a picture (H, W, 3) with the value of each thing."""
    values = np.zeros(rgb.shape[:2], np.uint16)
    for value, one in seen.items():
        values[one.mask] = value
    return values
