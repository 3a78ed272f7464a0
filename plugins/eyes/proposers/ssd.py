"""Proposer `ssd`: what COCO's network finds in the picture and in six parts of it, outlined by MobileSAM."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.proposal import Proposal, RoomView
from plugins.eyes.ssd import Box, Ssd, overlap

MIN_BOX_SCORE = 0.2  # score of a box that is outlined; its class counts from `choosing.KNOWN` on
PART = 0.6  # of the picture's sides that a part has; chosen: things a sixth as large are found as well
SAME = 0.5  # IoU from which boxes of different parts are of one thing; chosen
EDGE = 4  # pixels to the edge of a part: what ends there is cut by it
INDOORS = {
    "backpack", "bed", "book", "bottle", "bowl", "cell phone", "chair", "clock", "couch", "cup", "dining table", "fork",
    "hair drier", "handbag", "keyboard", "knife", "laptop", "microwave", "mouse", "oven", "potted plant",
    "refrigerator", "remote", "scissors", "sink", "spoon", "suitcase", "teddy bear", "toaster", "toilet", "tv",
    "umbrella", "vase", "wine glass",
}  # fmt: skip


def propose(view: RoomView) -> list[Proposal]:
    """An outline for each box, the best of three, with the classes that were seen there."""
    boxes = find_boxes(view.rgb)
    if not boxes:
        return []
    outlines = view.embedded.outline_boxes([box.box for box in boxes])
    best = outlines.scores.argmax(axis=1)
    scores = outlines.scores * outlines.stability
    return [
        Proposal(outlines.logits[k, b], float(scores[k, b]), "ssd", box.scores, box.box)
        for k, (box, b) in enumerate(zip(boxes, best, strict=True))
    ]


def find_boxes(rgb: NDArray[np.uint8]) -> list[Box]:
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
            same = next((other for other in found if overlap(other.box, moved) >= SAME), None)
            if same is None:
                found.append(Box(moved, box.name, box.score, box.scores))
            else:
                same.scores.update({name: max(score, same.scores.get(name, 0.0)) for name, score in box.scores.items()})
    return found
