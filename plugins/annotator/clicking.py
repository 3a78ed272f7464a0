"""A click outlines and names a thing: MobileSAM's guesses at what lies there, of a picture that is looked at once."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Annotated, Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter

from roomkin.plugins.annotator.described import jpeg
from roomkin.stages.config.weights import list_lacking
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.parts import says_opening
from roomkin.stages.contracts.types import Outline, Pixel, PixelCoordinate
from roomkin.stages.geometry.masks import PIECES, Mask, outline_pieces, pixel_bounds, polygons
from roomkin.stages.perception.classification.naming import name_outline
from roomkin.stages.perception.classification.propose import Names, observe_looks, propose_names
from roomkin.stages.perception.segmentation.choosing import ON_WALL, share
from roomkin.stages.perception.segmentation.mobile_sam import Embedded, MobileSam, Outlines
from roomkin.stages.perception.segmentation.proposal import RoomView
from roomkin.stages.perception.segmentation.ssd import DetectedBox, find_boxes
from roomkin.stages.perception.segmentation.ssd import overlap as overlap_boxes

LACKING = "a click outlines things once the networks' weights are there: make weights"
LIKE_BEST = 0.1  # by which the score of a larger outline may lie below the best: wholes before parts; on 26 things
SAME = 0.7  # IoU from which an outline is that of a thing that COCO's network has found; on the same
GOOD = 0.75  # least score of an outline by several clicks; chosen
COVERS = 0.9  # share of what was outlined before that a further click keeps; chosen
LEFT = 0.1  # share of what was outlined that a click which takes away leaves; chosen
ALIKE = 0.5  # share of the size of one of two alike things that the other has at least; chosen
BESIDE = 0.1  # IoU of boxes around two of them at most; chosen
BOTH = 0.8  # IoU from which two of them are what both were taken for; chosen
SAME_BOX = 0.5  # IoU from which a box of COCO's network says what an outline is; chosen
SURE = 0.4  # least probability of a name that is taken, among those of the library; chosen
NAMES = 5  # that are proposed; chosen
OUTLINES = TypeAdapter(Annotated[list[Outline], Field(max_length=PIECES + 1)])
Click = tuple[PixelCoordinate, PixelCoordinate, bool]  # x, y, whether it adds; else it takes away


class Asked(Contract):
    """Clicks on one thing, the last one new, and its outlines before it; or a box around it, by opposite corners."""

    clicks: list[Click] = Field([], max_length=100)
    box: tuple[Pixel, Pixel] | None = None
    before: list[Outline] = Field([], max_length=PIECES + 1)


@dataclass(frozen=True)
class ClickedPicture:
    """A picture as MobileSAM sees it, and boxes of COCO's network with their outlines (H, W)."""

    picture: Embedded
    boxes: list[DetectedBox]
    outlines: list[Mask]


def look(rgb: NDArray[np.uint8]) -> ClickedPicture:
    """Look at a picture (H, W, 3): about four seconds of one core."""
    picture, boxes = MobileSam().embed(rgb), find_boxes(rgb)
    if not boxes:
        return ClickedPicture(picture, [], [])
    found = picture.outline_boxes([box.box for box in boxes])
    best = found.scores.argmax(axis=1)
    return ClickedPicture(picture, boxes, [picture.upsample(found.logits[k, one]) for k, one in enumerate(best)])


class Clicker:
    """A picture (H, W, 3) that is looked at in the background; with depth, the room that it shows."""

    def __init__(self, rgb: NDArray[np.uint8], room: RoomView | None = None) -> None:
        self.rgb, self.room = rgb, room
        self._looking: Future[ClickedPicture] = ThreadPoolExecutor(1).submit(look, rgb)

    @property
    def seen(self) -> ClickedPicture:
        """The picture once it is looked at."""
        return self._looking.result()

    def outline(self, asked: Asked) -> list[Mask]:
        """What clicks or a box show (H, W): guesses, the likeliest first; none beside the picture."""
        if asked.box is not None:
            corners = np.sort(asked.box, axis=0)
            return [mask for mask, _ in self._rank(self.seen.picture.outline_boxes([corners.ravel()]))]
        *_, (x, y, adds) = asked.clicks
        height, width = self.rgb.shape[:2]
        if not (-0.5 <= x < width - 0.5 and -0.5 <= y < height - 0.5):
            return []
        alone = self._outline_alone((x, y))
        before = polygons(asked.before, (height, width))
        if not before.any():
            return alone if adds else []
        if adds:
            return [*self._outline_together(asked.clicks, before), *(before | one for one in alone)]
        return [rest for one in alone if (rest := before & ~one).sum() > LEFT * before.sum()]

    def _rank(self, found: Outlines) -> list[tuple[Mask, float]]:
        """Guesses (H, W) at one prompt with their scores, wholes before parts: the largest of the good ones first."""
        scores = (found.scores * found.stability)[0]
        guesses = [(self.seen.picture.upsample(found.logits[0, k]), float(scores[k])) for k in np.argsort(-scores)]
        good = [mask.sum() for mask, score in guesses if score >= guesses[0][1] - LIKE_BEST]
        first = guesses.pop(int(np.argmax(good)))
        return [first, *guesses]

    def _outline_alone(self, point: tuple[float, float]) -> list[Mask]:
        """Guesses at one click; before them what COCO's network has found there, if that is nearly one of them.

        Unless the others are nearly the same: then a thing lies there on what was found, as a candle on a table.
        """
        whole, *parts = self._guess(point)
        guesses = sorted([whole, *parts], key=lambda part: not self._is_of_pair(part, whole))
        x, y = round(point[0]), round(point[1])
        for known in sorted((one for one in self.seen.outlines if one[y, x]), key=lambda one: one.sum()):
            others = [mask for mask in guesses if overlap(mask, known) < SAME]
            if len(others) < len(guesses):
                agree = len(others) == 2 and overlap(*others) >= SAME
                return [*guesses, known] if agree else [known, *guesses]
        return guesses

    def _guess(self, point: tuple[float, float]) -> list[Mask]:
        """Guesses (H, W) at one click, wholes before parts."""
        return [mask for mask, _ in self._rank(self.seen.picture.outline_points([point]))]

    def _is_of_pair(self, part: Mask, whole: Mask) -> bool:
        """Whether a guess is one of two things of about one size that hang beside each other, flat on a wall, and
        another is both. Without depth nobody knows: the doors of a cupboard look so, too."""
        rest = whole & ~part
        if self.room is None or not rest.any():
            return False
        if share(self.room.surfaces.beyond, whole & (self.room.depth > 0)) <= ON_WALL:
            return False
        distance = cv2.distanceTransform(rest.astype(np.uint8), cv2.DIST_L2, 3)
        y, x = np.unravel_index(distance.argmax(), distance.shape)
        return bool(part.any()) and any(
            ALIKE < other.sum() / part.sum() < 1 / ALIKE
            and overlap_boxes(pixel_bounds(other), pixel_bounds(part)) < BESIDE
            and overlap(other | part, whole) > BOTH
            for other in self._guess((float(x), float(y)))
        )

    def _outline_together(self, clicks: list[Click], before: Mask) -> list[Mask]:
        """Good guesses at the one thing of several clicks, which keep what was outlined before."""
        if len(clicks) < 2:
            return []
        inside = [adds for *_, adds in clicks]
        guesses = self._rank(self.seen.picture.outline_clicks([click[:2] for click in clicks], inside))
        height, width = self.rgb.shape[:2]
        columns, rows = np.clip(np.rint([click[:2] for click in clicks]), 0, [width - 1, height - 1]).astype(int).T
        return [
            mask
            for mask, score in guesses
            if score >= GOOD
            and (mask[rows, columns] == inside).all()
            and (mask & before).sum() >= COVERS * before.sum()
        ]

    def name(self, mask: Mask) -> Names:
        """What a mask (H, W) may be called: by its look, COCO's network, and with depth by its shape and its wall."""
        words = self._words(mask)
        if self.room is not None:
            return name_outline(self.room, mask, words)
        return propose_names(observe_looks(self.rgb, mask), words or None)

    def _words(self, mask: Mask) -> dict[str, float]:
        """COCO's classes, with their scores, of the box that agrees with a mask best."""
        bounds = pixel_bounds(mask)
        shares = [overlap_boxes(box.box, bounds) for box in self.seen.boxes]
        best = int(np.argmax(shares)) if shares else 0
        return self.seen.boxes[best].scores if shares and shares[best] >= SAME_BOX else {}


class Clicked:
    """What both pages answer; without weights there is no `clicker`, and the page does not ask for outlines."""

    clicker: Clicker | None = None
    finished = False

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """The picture (H, W, 3)."""
        raise NotImplementedError

    def picture(self) -> bytes:
        """The picture as JPEG."""
        return jpeg(self.rgb)

    def close(self, _: Any) -> dict[str, Any]:
        """The page is done with."""
        self.finished = True
        return {}

    @property
    def room(self) -> RoomView | None:
        """The room that depth shows; None: there is none."""
        return None

    def begin_looking(self) -> None:
        """Look at the picture in the background, or print what lacks."""
        if list_lacking():
            print(LACKING)
        else:
            self.clicker = Clicker(self.rgb, self.room)

    def ready(self) -> dict[str, Any]:
        """Answer once the picture is looked at."""
        return {"ready": self.clicker is not None and bool(self.clicker.seen)}

    def outline(self, body: Any) -> dict[str, Any]:
        """Outlines of what clicks show: guesses, the likeliest first, of one or more pieces each."""
        masks = self._look().outline(Asked.model_validate(body))
        return {"guesses": [rings for mask in masks if (rings := outline_pieces(mask))]}

    def names(self, body: Any) -> dict[str, Any]:
        """Names of outlines, surest first; the surest alone, if it is sure enough; whether that opens."""
        clicker = self._look()
        mask = polygons(OUTLINES.validate_python(body["outlines"]), clicker.rgb.shape[:2])
        if not mask.any():
            return {"names": [], "label": "", "opens": False}
        found = self.weigh_names(clicker.name(mask), body)
        first, names = found.proposals[0], [one.name for one in found.proposals[:NAMES]]
        label = first.name if first.probability > SURE * (1 - found.other) else ""
        return {"names": names, "label": label, "opens": says_opening(label)}

    def weigh_names(self, names: Names, body: Any) -> Names:
        """The names of an outlined thing with what the page knows of it besides."""
        return names

    def _look(self) -> Clicker:
        if self.clicker is None:
            raise InputError("the picture", "was not looked at.", "make weights", code="E-WEIGHTS-MISSING")
        return self.clicker


def overlap(one: Mask, other: Mask) -> float:
    """Intersection over union."""
    return float((one & other).sum() / max(1, (one | other).sum()))
