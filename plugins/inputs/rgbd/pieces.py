"""Masks without a segmenter of one's own: things, floor and walls as the network of plugins/segmenter cuts them."""

from plugins.inputs.rgbd.frame import Frame, Labelled
from stages.contracts import InputError
from stages.contracts.types import WALL

TILT = 75.0  # degrees: largest angle between image-up and the ground's normal, as cameras look down at tables; chosen


def cut_frame(frame: Frame) -> Labelled:
    """Masks of a frame whose depth has the size of its picture: things called `object`, a floor, walls.

    Raises:
        InputError: nothing level is seen, or nothing on it.
    """
    from plugins.segmenter.segment import cut

    pieces = cut(frame.depth, frame.rgb, frame.intrinsics, TILT)
    if pieces is None or not pieces.things:
        raise InputError("--auto", "finds no thing on a level surface.", "give --masks", code="E-MASKS-EMPTY")
    floor = {} if pieces.floor is None else {pieces.floor: "floor"}
    return Labelled(pieces.values, dict.fromkeys(pieces.things, "object") | floor | dict.fromkeys(pieces.walls, WALL))
