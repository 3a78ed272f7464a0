"""Proposer `grounding`: Grounding DINO and SAM 2, asked for `perception.labels`, else the library's categories."""

import cv2
import numpy as np

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.perception.segmentation.proposal import Proposal, RoomView


def propose(view: RoomView, options: OutlineSection) -> list[Proposal]:
    """An outline for each box, with its label.

    Raises:
        InputError: the weights are missing or broken (`roomkin perception fetch --networks`).
    """
    from roomkin.plugins.pretrained.networks import detect, segment

    labels = options.labels or [name.replace("_", " ") for name in known_categories()]
    boxes = detect(view.rgb, labels, options, view.device)
    found = []
    for box, mask in zip(boxes, segment(view.rgb, boxes, options, view.device), strict=True):
        share = cv2.resize(mask.astype(np.float32), view.small, interpolation=cv2.INTER_AREA)
        logits = (8 * share - 4).astype(np.float16)
        found.append(Proposal(logits, box.score, "grounding", {box.label: box.score}, box.box))
    return found
