"""Proposer `pieces`: a network learnt in our own rooms, which needs no weights but its own (plugins/segmenter)."""

import cv2
import numpy as np

from plugins.eyes.proposal import Proposal, RoomView
from plugins.inputs.rgbd.frame import TILT
from plugins.segmenter.segment import cut


def propose(view: RoomView) -> list[Proposal]:
    """Its things."""
    pieces = cut(view.depth.astype(np.float32), view.rgb, view.intrinsics, TILT)
    if pieces is None:
        return []
    found = []
    for value, score in pieces.things.items():
        share = cv2.resize((pieces.values == value).astype(np.float32), view.small, interpolation=cv2.INTER_AREA)
        found.append(Proposal((8 * share - 4).astype(np.float16), score, "pieces"))
    return found
