"""The input and output of proposers: a picture with depth, and outlines that may each be one thing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.perception.camera.surfaces import Surfaces
from roomkin.stages.plugins import load

if TYPE_CHECKING:
    from roomkin.stages.perception.segmentation.mobile_sam import Embedded


Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SIDE = 256  # pixels of an outline's longer side, as MobileSAM gives them
FRAME = 0.1  # share of the picture's sides that a frame around it may take; chosen
PLAIN, FILLED = 8, 0.9  # of 255: how black or white a frame is, and the share of its lines that are; chosen


@dataclass(frozen=True)
class RoomView:
    """A picture with depth, and where ground and walls are in it.

    rgb (H, W, 3) uint8; depth (H, W) metres, 0: unknown; intrinsics (3, 3) in pixels; device: of networks.
    """

    rgb: NDArray[np.uint8]
    depth: Array
    intrinsics: Array
    surfaces: Surfaces
    device: str = "cpu"

    @cached_property
    def border(self) -> Mask:
        """Pixels (H, W) of a plain frame around the picture, as undistorting leaves one: they show nothing."""
        return find_border(self.rgb)

    @cached_property
    def embedded(self) -> "Embedded":
        """The picture as MobileSAM sees it."""
        from roomkin.stages.perception.segmentation.mobile_sam import MobileSam

        return MobileSam().embed(self.rgb)

    def shrink(self, mask: Mask) -> Mask:
        """A mask (H, W) in the pixels of an outline, (h, w)."""
        return np.asarray(cv2.resize(mask.astype(np.uint8), self.small, interpolation=cv2.INTER_NEAREST) > 0)

    @property
    def small(self) -> tuple[int, int]:
        """Columns and rows of an outline."""
        height, width = self.depth.shape
        scale = SIDE / max(height, width)
        return int(np.ceil(width * scale)), int(np.ceil(height * scale))


@dataclass(frozen=True)
class Proposal:
    """An outline that may be one thing.

    logits (h, w) float16, above 0 inside, the picture with a longer side of `SIDE`; score in [0, 1] of the outline;
    source: what proposed it; words: COCO's classes that were seen there, each with its score; box: x0, y0, x1, y1 of
    these in pixels of the picture.
    """

    logits: NDArray[np.float16]
    score: float
    source: str
    words: Mapping[str, float] = field(default_factory=dict)
    box: tuple[float, float, float, float] | None = None

    @property
    def known(self) -> float:
        """How sure the surest of the classes is."""
        return max(self.words.values(), default=0.0)

    @property
    def word(self) -> str:
        """The surest of the classes; empty: none."""
        return max(self.words, key=self.words.__getitem__, default="")

    @cached_property
    def mask(self) -> Mask:
        """(h, w)."""
        return np.asarray(self.logits > 0)


def find_border(rgb: NDArray[np.uint8]) -> Mask:
    """Pixels (H, W) of a plain black or white frame around a picture (H, W, 3)."""
    plain = (rgb.max(axis=2) < PLAIN) | (rgb.min(axis=2) > 255 - PLAIN)
    inside = np.ones(plain.shape, dtype=bool)
    for turn in (np.asarray, np.flipud, np.transpose, np.rot90):
        lines, kept = turn(plain), turn(inside)
        whole = lines[: int(FRAME * len(lines))].mean(axis=1) > FILLED
        kept[: int(np.argmin(np.append(whole, False)))] = False
    return ~inside


def list_proposals(view: RoomView, options: OutlineSection, proposers: Sequence[str]) -> list[Proposal]:
    """The proposals of these proposers, who read the user's options."""
    asked = [load("proposers", name) for name in proposers]
    return [found for propose in asked for found in propose(view, options)]
