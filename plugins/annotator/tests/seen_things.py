"""A picture whose things are known, in the place of one that networks have looked at."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.plugins.annotator.clicking import ClickedPicture, Clicker
from roomkin.stages.geometry.masks import Mask, pixel_bounds
from roomkin.stages.perception.classification.propose import LikelyName, Names
from roomkin.stages.perception.segmentation.mobile_sam import Outlines
from roomkin.stages.perception.segmentation.ssd import DetectedBox


class KnownPicture:
    """Answers as MobileSAM: of a point the upper half of what lies there, the whole, and nothing."""

    def __init__(self, things: list[Mask]) -> None:
        self.things = things
        self.guesses: list[Mask] = []

    def upsample(self, logits: NDArray[np.float16]) -> Mask:
        """The mask (H, W), which is as fine as the picture."""
        return np.asarray(logits > 0)

    def outline_points(self, points: ArrayLike) -> Outlines:
        """Of the thing at the only point, or what a test says."""
        if self.guesses:
            return _outlines(self.guesses, [0.95, 0.7, 0.6])
        ((x, y),) = np.rint(points).astype(int)
        whole = next((one for one in self.things if one[y, x]), np.zeros_like(self.things[0]))
        half = whole.copy()
        half[y + 1 :] = False
        return _outlines([half, whole, np.zeros_like(whole)], [0.95, 0.9, 0.1])

    def outline_clicks(self, points: ArrayLike, inside: ArrayLike) -> Outlines:
        """Of all the things at points inside, together, or what a test says."""
        if self.guesses:
            return _outlines(self.guesses, [0.95, 0.7, 0.6])
        height, width = self.things[0].shape
        columns, rows = np.clip(np.rint(points), 0, [width - 1, height - 1]).astype(int)[np.asarray(inside, bool)].T
        return _outlines(
            [np.any([one for one in self.things if one[rows, columns].any()], axis=0)] * 3, [0.9, 0.1, 0.1]
        )

    def outline_boxes(self, boxes: ArrayLike) -> Outlines:
        """Of all that lies in the only box."""
        ((x0, y0, x1, y1),) = np.asarray(boxes, float)
        found = np.zeros_like(self.things[0])
        for one in self.things:
            a, b, c, d = pixel_bounds(one)
            if x0 <= a and y0 <= b and c <= x1 + 1 and d <= y1 + 1:
                found |= one
        return _outlines([found] * 3, [0.9, 0.1, 0.1])


def _outlines(masks: list[Mask], scores: list[float]) -> Outlines:
    logits = np.where(np.array(masks), 4, -4).astype(np.float16)[None]
    return Outlines(logits, np.array([scores], np.float32), np.ones((1, 3), np.float32))


class KnownClicker(Clicker):
    """Clicks on a picture whose things (H, W) and names are known."""

    def __init__(self, rgb: NDArray[np.uint8], things: dict[str, Mask]) -> None:
        self.rgb, self.room, self.things = rgb, None, things
        self._picture: Any = KnownPicture(list(things.values()))
        self.boxes: list[DetectedBox] = []
        self.found: list[Mask] = []
        self.guesses: list[Mask] = []

    @property
    def seen(self) -> ClickedPicture:
        """At once."""
        self._picture.guesses = self.guesses
        return ClickedPicture(self._picture, self.boxes, self.found)

    def name(self, mask: Mask) -> Names:
        """Of the thing that most of a mask shows."""
        names = sorted(self.things, key=lambda name: -(self.things[name] & mask).sum())
        return Names([LikelyName(names[0], 0.7), LikelyName("nightstand", 0.1)], 0.2)
