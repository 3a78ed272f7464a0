"""What each voice says of outlines in pictures of other people's models: exact ones, ones with faults, and our own."""

import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.masks import frame_of
from benchmarks.name_training.dirt import OTHER, SAME, Mask, cut_patch, share_owner, soil
from benchmarks.open_rooms import packs
from benchmarks.open_rooms.pictures import read, read_masks
from roomkin.stages.config.perception import SeeSection
from roomkin.stages.contracts import InputError, write_atomically
from roomkin.stages.geometry.masks import pixel_bounds
from roomkin.stages.perception.classification.propose import gather, observe, read_network
from roomkin.stages.perception.see import look
from roomkin.stages.perception.segmentation.choosing import choose
from roomkin.stages.perception.segmentation.proposal import RoomView, list_proposals
from roomkin.stages.perception.segmentation.ssd import ONE_THING, find_boxes, overlap

EXACT, FAULTY, OWN = range(3)  # outlines: of the truth, with faults, as the pipeline finds them
NONE = "other"
MIN_PIXELS, PATCHES, DOUBTED = 60, 4, 8  # of an outline; of walls and floor, and proposals left, a picture; chosen


class TrainingOutlines(NamedTuple):
    """model (N,) and kind (N,), empty and `NONE` where an outline shows no thing; how (N,): EXACT, FAULTY, OWN; said
    (N, 3, C): by shape, ImageNet and COCO; looks (N, 512)."""

    model: NDArray[np.str_]
    kind: NDArray[np.str_]
    how: NDArray[np.int64]
    said: NDArray[np.float32]
    looks: NDArray[np.float32]

    def right(self, names: list[str]) -> NDArray[np.bool_]:
        """Which names (N, C) are right for each."""
        sensible = {kind: packs.kinds()[kind].sensible or [NONE] for kind in set(self.kind) - {NONE}} | {NONE: [NONE]}
        return np.array([[name in sensible[kind] for name in names] for kind in self.kind])


def join(some: list[TrainingOutlines]) -> TrainingOutlines:
    """Those of several pictures."""
    return TrainingOutlines(*(np.concatenate(each) for each in zip(*some, strict=True)))


def see_outlines(folder: Path, kept: Path) -> TrainingOutlines | None:
    """The outlines of a picture, from the file where they are kept, or into it; None: nothing level is seen."""
    file = kept / f"{folder.name}.npz"
    if not file.is_file():
        try:
            view = look(frame_of(folder))
        except InputError:
            return None
        found = _see(view, folder)
        with write_atomically(file) as path, path.open("wb") as stream:
            np.savez_compressed(stream, **found._asdict())
    with np.load(file) as stored:
        return TrainingOutlines(*(stored[name] for name in TrainingOutlines._fields))


def _see(view: RoomView, folder: Path) -> TrainingOutlines:
    rng, names = np.random.default_rng(zlib.crc32(folder.name.encode())), read_network()[1]
    exact, things = read_masks(folder), {thing.number: thing for thing in read(folder).things}
    wholes = {number: [exact == number] for number in things if (exact == number).any()}
    boxes = find_boxes(view.rgb)
    rows = []
    for mask, words, how in _list_masks(view, wholes, exact, rng):
        number, iou = share_owner(mask, wholes)
        if mask.sum() < MIN_PIXELS or OTHER < iou < SAME:
            continue
        thing = things[number] if iou >= SAME else None
        varied = view.rgb if how != FAULTY else vary(view.rgb, rng)
        seen = observe(varied, view.depth, mask, view.intrinsics, view.surfaces.frame)
        if words is None:  # those of the box that has its extent
            box = tuple(map(float, pixel_bounds(mask)))
            best = max(boxes, key=lambda one: overlap(one.box, box), default=None)
            words = best.scores if best is not None and overlap(best.box, box) >= ONE_THING else {}
        assert seen.looks is not None, "CLIP's weights are not here"
        voices = gather(seen._replace(looks=None), words, names)[:3]
        rows.append((thing.model if thing else "", thing.kind if thing else NONE, how, voices, seen.looks))
    model, kind, hows, said, looks = (np.array(each) for each in zip(*rows, strict=True))
    return TrainingOutlines(model, kind, hows, said.astype(np.float32), looks.astype(np.float32))


def _list_masks(
    view: RoomView, wholes: Mapping[int, list[Mask]], exact: NDArray[np.uint16], rng: np.random.Generator
) -> Iterator[tuple[Mask, Mapping[str, float] | None, int]]:
    """Masks (H, W) with COCO's words, None: those of a box, and which kind they are of."""
    owner = np.searchsorted([-1, 0, *wholes], exact).astype(np.uint8)
    owner[exact > max(wholes, default=0)] = 1
    for (mask,) in wholes.values():
        yield mask, None, EXACT
        yield soil(mask, owner, rng), None, FAULTY
    for _ in range(PATCHES):
        yield cut_patch(owner <= 1, rng), {}, FAULTY
    settings = SeeSection()
    proposals = list_proposals(view, settings, settings.proposers)
    for one in choose(view, proposals):
        yield one.mask, one.words, OWN
    for k in rng.permutation(len(proposals))[:DOUBTED]:
        logits = cv2.resize(proposals[k].logits.astype(np.float32), view.depth.shape[::-1])
        yield logits > 0, proposals[k].words, FAULTY


def vary(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A picture (H, W, 3) of another exposure, white balance, saturation and sharpness."""
    light = (rgb.astype(np.float32) / 255) ** np.exp(rng.normal(0, 0.25)) * np.exp(rng.normal(0, [0.1] * 3))
    grey = light.mean(axis=2, keepdims=True)
    varied = grey + (light - grey) * np.exp(rng.normal(0, 0.3))
    if rng.random() < 0.3:
        varied = cv2.GaussianBlur(varied, (0, 0), rng.uniform(0.5, 1.5))
    return np.rint(255 * np.clip(varied * np.exp(rng.normal(0, 0.15)), 0, 1)).astype(np.uint8)
