"""Names for masks that were made here: those that plugins/names proposes."""

from dataclasses import replace

from plugins.inputs.rgbd.frame import Frame
from plugins.inputs.rgbd.pieces import TILT
from plugins.names.propose import propose_names
from plugins.segmenter.ground import find_ground
from stages.geometry.cameras import back_project
from stages.geometry.room_planes import make_floor_frame

UNNAMED = "object"  # what a mask is called that nobody named
PROPOSED = 3  # names of a thing


def name_things(frame: Frame) -> Frame:
    """The frame with every `object` called by the surest of the names that are proposed for it; depth of its size."""
    from plugins.names.observed import WITHOUT, classifier, observe

    if frame.masks is None:
        return frame
    depth = frame.depth.astype(float)
    ground = find_ground(back_project(depth, frame.intrinsics), depth > 0, TILT)
    if ground is None:
        return frame
    level, masks = make_floor_frame(ground), frame.masks
    found = {
        value: propose_names(observe(frame.rgb, depth, masks.values == value, frame.intrinsics, level))
        for value, label in masks.labels.items()
        if label == UNNAMED and (masks.values == value).any()
    }
    proposals = {value: one.proposals[:PROPOSED] for value, one in found.items()}
    names = {value: first.name for value, (first, *_) in proposals.items()}
    if proposals and classifier() is None:
        frame = replace(frame, notes=[*frame.notes, WITHOUT])
    return replace(frame, masks=replace(masks, labels=masks.labels | names, proposals=proposals))
