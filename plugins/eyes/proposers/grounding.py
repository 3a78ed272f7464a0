"""Proposer `grounding`: Grounding DINO and SAM 2, asked for the library's categories (weights: `inputs fetch`)."""

import cv2
import numpy as np

from plugins.eyes.proposal import Proposal, RoomView
from plugins.inputs.config import PhotoConfig
from stages.contracts.categories import known_categories


def propose(view: RoomView) -> list[Proposal]:
    """An outline for each box, with its label."""
    from plugins.inputs.photo.networks import detect, segment

    options = PhotoConfig()
    boxes = detect(view.rgb, [name.replace("_", " ") for name in known_categories()], options)
    found = []
    for box, mask in zip(boxes, segment(view.rgb, boxes, options), strict=True):
        share = cv2.resize(mask.astype(np.float32), view.small, interpolation=cv2.INTER_AREA)
        found.append(
            Proposal((8 * share - 4).astype(np.float16), box.score, "grounding", {box.label: box.score}, box.box)
        )
    return found
