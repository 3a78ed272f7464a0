"""The direction of gravity by lines in the picture, where depth shows no floor."""

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.inputs.photo.perspective import fit_view
from plugins.inputs.photo.segments import propose, usual_focal
from plugins.inputs.rgbd.frame import Frame
from stages.config.extraction import ExtractionConfig
from stages.contracts.depth import NEAREST
from stages.geometry.cameras import back_project
from stages.geometry.gravity import find_up
from stages.geometry.levels import find_floor
from stages.geometry.room_planes import STRAY, Plane, fit_floor, make_floor_frame


def level_camera(frame: Frame, floor: int | None) -> NDArray[np.float64] | None:
    """`floor_from_camera` (4, 4), levelled by lines, its floor below all that is seen; None: extraction finds a floor.

    Args:
        frame: with masks.
        floor: mask value of the floor.
    """
    points = back_project(frame.depth, frame.intrinsics)
    seen = frame.depth > 0
    max_tilt = ExtractionConfig().max_tilt
    on_floor = seen & (frame.masks.values == floor) if frame.masks and floor else np.zeros_like(seen)
    fitted = fit_floor(points[on_floor], max_tilt, np.random.default_rng(0))
    up = find_up(points, seen, max_tilt)
    if fitted is not None or (up is not None and find_floor(points, seen, seen, [], up) is not None):
        return None
    height, width = frame.depth.shape
    grey = np.asarray(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY), np.uint8)
    up = fit_view(propose(grey, usual_focal(width, height, float(frame.intrinsics[0, 0]))), width, height).rotation[2]
    lowest = float(np.quantile(points[seen] @ up, STRAY))
    return make_floor_frame(Plane(up, min(lowest, -NEAREST), np.zeros(0, dtype=bool)))
