"""SSD with MobileNet v2 on COCO: boxes of things by name (Liu et al., ECCV 2016; Sandler et al., CVPR 2018)."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.config.weights import FOLDER, SSD, SSD_GRAPH, find_weights
from roomkin.stages.perception.segmentation.proposal import Proposal, RoomView

SIDE = 300  # pixels of the square input, as trained
MIN_SCORE = 0.3  # score of a box; chosen: as the trials of COCO's boxes on real frames
SAME = 0.6  # IoU from which two boxes are of one thing, as the graph's own suppression within a class
# COCO's classes from 1 on; the numbers left empty were never published.
_CLASSES = """
person,bicycle,car,motorcycle,airplane,bus,train,truck,boat,traffic light,fire hydrant,,stop sign,parking meter,bench,
bird,cat,dog,horse,sheep,cow,elephant,bear,zebra,giraffe,,backpack,umbrella,,,handbag,tie,suitcase,frisbee,skis,snowboard,
sports ball,kite,baseball bat,baseball glove,skateboard,surfboard,tennis racket,bottle,,wine glass,cup,fork,knife,spoon,
bowl,banana,apple,sandwich,orange,broccoli,carrot,hot dog,pizza,donut,cake,chair,couch,potted plant,bed,,dining table,,,
toilet,,tv,laptop,mouse,remote,keyboard,cell phone,microwave,oven,toaster,sink,refrigerator,,book,clock,vase,scissors,
teddy bear,hair drier,toothbrush
"""
NAMES = dict(enumerate(_CLASSES.replace("\n", "").split(","), start=1))
MIN_BOX_SCORE = 0.2  # score of a box that is outlined; its class counts from `choosing.KNOWN` on
PART = 0.6  # of the picture's sides that a part has; chosen: things a sixth as large are found as well
ONE_THING = 0.5  # IoU from which boxes of different parts are of one thing; chosen
EDGE = 4  # pixels to the edge of a part: what ends there is cut by it
INDOORS = {
    "backpack", "bed", "book", "bottle", "bowl", "cell phone", "chair", "clock", "couch", "cup", "dining table", "fork",
    "hair drier", "handbag", "keyboard", "knife", "laptop", "microwave", "mouse", "oven", "potted plant",
    "refrigerator", "remote", "scissors", "sink", "spoon", "suitcase", "teddy bear", "toaster", "toilet", "tv",
    "umbrella", "vase", "wine glass",
}  # fmt: skip


@dataclass(frozen=True)
class DetectedBox:
    """A thing that was found.

    Attributes:
        box: x0, y0, x1, y1 in pixels, within the picture.
        name: of its class, COCO's.
        score: of that class, 0 to 1.
        scores: of every class that the network saw there, the best first; they need not add up to 1.
    """

    box: tuple[float, float, float, float]
    name: str
    score: float
    scores: dict[str, float]


class Ssd:
    """The network with its published weights."""

    def __init__(self, folder: Path = FOLDER) -> None:
        """Load the weights.

        Raises:
            InputError: they are not there, or others.
        """
        graph, text = find_weights(SSD, folder), find_weights(SSD_GRAPH, folder)
        self._network = cv2.dnn.readNetFromTensorflow(str(graph), str(text))

    def detect(self, rgb: NDArray[np.uint8], least: float = MIN_SCORE) -> list[DetectedBox]:
        """The things in a picture (H, W, 3) that score `least` or more, the surest first."""
        height, width = rgb.shape[:2]
        self._network.setInput(cv2.dnn.blobFromImage(rgb, size=(SIDE, SIDE)))
        rows = self._network.forward().reshape(-1, 7).astype(float)  # 0, class, score, x0, y0, x1, y1 as parts
        rows = rows[np.argsort(-rows[:, 2], kind="stable")]
        boxes = np.clip(rows[:, 3:], 0, 1) * [width, height, width, height]
        found: list[DetectedBox] = []
        for number, score, box in zip(rows[:, 1].astype(int), rows[:, 2], boxes, strict=True):
            same = next((other for other in found if overlap(other.box, tuple(box)) >= SAME), None)
            if same:
                same.scores.setdefault(NAMES[number], float(score))
            elif score >= least:
                x0, y0, x1, y1 = map(float, box)
                found.append(DetectedBox((x0, y0, x1, y1), NAMES[number], float(score), {NAMES[number]: float(score)}))
        return found


def overlap(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """Intersection over union of two boxes x0, y0, x1, y1."""
    sides = [min(one[k + 2], other[k + 2]) - max(one[k], other[k]) for k in (0, 1)]
    common = max(0.0, sides[0]) * max(0.0, sides[1])
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other))
    return common / (areas - common) if common else 0.0


def propose(view: RoomView, options: OutlineSection) -> list[Proposal]:
    """An outline for each box, the best of three, with the classes that were seen there."""
    boxes = find_boxes(view.rgb)
    if not boxes:
        return []
    outlines = view.embedded.outline_boxes([box.box for box in boxes])
    best = outlines.scores.argmax(axis=1)
    scores = outlines.scores * outlines.stability
    every = enumerate(zip(boxes, best, strict=True))
    return [Proposal(outlines.logits[k, b], float(scores[k, b]), "ssd", box.scores, box.box) for k, (box, b) in every]


def find_boxes(rgb: NDArray[np.uint8]) -> list[DetectedBox]:
    """Boxes of things of rooms in a picture (H, W, 3), those of the whole before those of parts, each thing once."""
    network, (height, width) = Ssd(), rgb.shape[:2]
    found = [box for box in network.detect(rgb, MIN_BOX_SCORE) if box.name in INDOORS]
    size = np.array([width, height])
    for down, across in product((0, 1), (0, 0.5, 1)):
        x0, y0 = ((1 - PART) * size * (across, down)).astype(int)
        x1, y1 = (x0 + int(PART * width), y0 + int(PART * height))
        for box in network.detect(rgb[y0:y1, x0:x1], MIN_BOX_SCORE):
            moved = (box.box[0] + x0, box.box[1] + y0, box.box[2] + x0, box.box[3] + y0)
            is_cut = (
                (x0 > 0 and moved[0] < x0 + EDGE)
                or (y0 > 0 and moved[1] < y0 + EDGE)
                or (x1 < width - EDGE and moved[2] > x1 - EDGE)
                or (y1 < height - EDGE and moved[3] > y1 - EDGE)
            )
            if box.name not in INDOORS or is_cut:
                continue
            same = next((other for other in found if overlap(other.box, moved) >= ONE_THING), None)
            if same is None:
                found.append(DetectedBox(moved, box.name, box.score, box.scores))
            else:
                same.scores.update({name: max(score, same.scores.get(name, 0.0)) for name, score in box.scores.items()})
    return found
