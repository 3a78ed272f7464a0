"""Things of a picture without depth: outlines by the same networks as with depth, names by what they look like, and
what each shows: a thing that stands, rests on another or hangs, a wall, the floor, or no thing."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.contracts import InputError
from roomkin.stages.perception.camera.surfaces import Surfaces
from roomkin.stages.perception.classification.names import ODD, Names
from roomkin.stages.perception.classification.propose import observe_looks, propose_names
from roomkin.stages.perception.layout.ends import measure_all, number_masks
from roomkin.stages.perception.segmentation.choosing import KNOWN, Outlined, choose
from roomkin.stages.perception.segmentation.mobile_sam import INPUT
from roomkin.stages.perception.segmentation.proposal import RoomView, list_proposals

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
WEIGHTS = Path(__file__).parent / "outline_kinds.safetensors"
STANDS, RESTS, HANGS, WALL, FLOOR, NOTHING = KINDS = ("stands", "rests", "hangs", "wall", "floor", "nothing")
COLUMNS = 779  # numbers of an outline: 3 of each of MobileSAM's 256 channels, 11 of where it lies
AROUND = 7  # cells of the embedding, 16 pixels each, in the square that widens an outline to its surroundings
ALIGNED = 0.15  # of their width, by which the sides of pieces of one front are apart at most; chosen


def tell_kinds(features: NDArray[np.float32], masks: Sequence[Mask]) -> Array:
    """The probability (N, 6) of each of `KINDS` for the outlines (H, W) of a picture.

    Args:
        features: (256, 64, 64), MobileSAM's of the picture.
    """
    weights, bias = read_weights()
    scores = np.array([measure_outline(features, mask) for mask in masks]).reshape(-1, COLUMNS) @ weights + bias
    share = np.exp(scores - scores.max(axis=1, keepdims=True, initial=-np.inf))
    return np.asarray(share / share.sum(axis=1, keepdims=True))


@cache
def read_weights(path: Path = WEIGHTS) -> tuple[Array, Array]:
    """Weights (779, 6) and bias (6,), as `python -m benchmarks.outline_kinds` writes them.

    Raises:
        InputError: the file holds others.
    """
    from safetensors.numpy import load_file

    held = {name: np.asarray(one, float) for name, one in load_file(path).items()}
    if {name: one.shape for name, one in held.items()} != {"weights": (COLUMNS, len(KINDS)), "bias": (len(KINDS),)}:
        raise InputError(path, "holds other weights.", "take the file from the repository", code="E-WEIGHTS-OTHER")
    return held["weights"], held["bias"]


def measure_outline(features: NDArray[np.float32], mask: Mask) -> Array:
    """What the classifier knows of an outline (H, W): (779,).

    The mean of MobileSAM's features inside, around and their spread inside; the box, area and fill of the outline as
    shares of the picture, the logarithm of its width over its height, and which borders it touches.
    """
    height, width = mask.shape
    cells = [max(1, round(side * INPUT / max(mask.shape) / 16)) for side in (height, width)]
    inside, shown = np.zeros((2, *features.shape[1:]), np.float32)
    inside[: cells[0], : cells[1]] = cv2.resize(mask.astype(np.float32), cells[::-1], interpolation=cv2.INTER_AREA)
    shown[: cells[0], : cells[1]] = 1
    around = np.clip(np.asarray(cv2.dilate(inside, np.ones((AROUND, AROUND)))) - inside, 0, 1) * shown
    mean, beside = _average(features, inside), _average(features, around)
    spread = np.sqrt(np.maximum(_average(features**2, inside) - mean**2, 0))
    rows, columns = np.nonzero(mask)
    left, top, right, bottom = columns.min(), rows.min(), columns.max(), rows.max()
    wide, tall = right - left + 1, bottom - top + 1
    box = [left / width, right / width, top / height, bottom / height]
    form = [np.sqrt(mask.mean()), mask.sum() / (wide * tall), np.log(wide / tall)]
    touches = [left < 4, right > width - 5, top < 4, bottom > height - 5]
    return np.concatenate([mean, beside, spread, box, form, touches]).astype(float)


def _average(features: NDArray[np.float32], weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means (C,) of features (C, h, w) by weights (h, w)."""
    return np.asarray(np.einsum("chw,hw->c", features, weight) / max(float(weight.sum()), 1e-6))


@dataclass(frozen=True)
class OutlineCandidate:
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


def see_outlines(rgb: NDArray[np.uint8], options: OutlineSection, device: str = "cpu") -> list[OutlineCandidate]:
    """The outlines of a picture (H, W, 3), no pixel in two; those of known things first."""
    view = make_view(rgb, device)
    found = choose(view, list_proposals(view, options, options.proposers))
    found = join_stacked(view, found, [KINDS[kind] for kind in tell_outlines(view, found).argmax(axis=1)])
    told = tell_outlines(view, found)
    names = [propose_names(observe_looks(rgb, one.mask), one.words or None) for one in found]
    every = zip(found, told, names, strict=True)
    return [OutlineCandidate(one.mask, kinds, name, is_known(one)) for one, kinds, name in every]


def tell_outlines(view: RoomView, found: Sequence[Outlined]) -> Array:
    """How likely each of `KINDS` is (N, 6) of each outline; one that cannot be measured shows nothing."""
    told = np.zeros((len(found), len(KINDS)))
    for k, one in enumerate(found):
        try:
            told[k] = tell_kinds(view.embedded.features, [one.mask])[0]
        except ODD:
            told[k, KINDS.index(NOTHING)] = 1.0
    return told


def is_known(one: Outlined) -> bool:
    """Whether COCO's network knows an outline."""
    return max(one.words.values(), default=0.0) >= KNOWN


def join_stacked(view: RoomView, found: Sequence[Outlined], kinds: Sequence[str]) -> list[Outlined]:
    """The outlines, those that lie right above another and are as wide joined to it: drawers over doors."""
    pieces = [one.mask for one in found]
    things = [value for value, kind in enumerate(kinds, 1) if kind not in (WALL, FLOOR) and pieces[value - 1].any()]
    free = {value for value in things if not is_known(found[value - 1])}
    ends = measure_all(number_masks(dict(enumerate(pieces, 1)), pieces[0].shape), things, ~view.border) if free else {}
    for value in sorted(free, key=lambda value: -ends[value].at[3]):
        own, below = ends[value].at, ends[value].met[3]
        if below not in free:
            continue
        other = ends[below].at
        wide = min(own[0] + own[2], other[0] + other[2])
        if max(abs(own[0] - other[0]), abs(own[2] - other[2])) < ALIGNED * wide:
            pieces[below - 1], pieces[value - 1] = pieces[below - 1] | pieces[value - 1], np.zeros_like(pieces[0])
    return [replace(one, mask=mask) for one, mask in zip(found, pieces, strict=True) if mask.any()]


def make_view(rgb: NDArray[np.uint8], device: str = "cpu") -> RoomView:
    """A picture of which nobody knows depth, ground or walls."""
    shape = rgb.shape[:2]
    nothing = np.zeros(shape, dtype=bool)
    surfaces = Surfaces(np.eye(4), np.zeros((*shape, 3)), 0.0, nothing, nothing, [], [], nothing)
    return RoomView(rgb, np.zeros(shape), np.eye(3), surfaces, device)
