"""Rectify the front of an object, so that doors and drawers can be drawn on it."""

import base64
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

LONGEST = 400  # pixels of its longer side


def rectify_front(rgb: NDArray[np.uint8], pixels: NDArray[np.float64], width: float, height: float) -> dict[str, Any]:
    """A front as the page shows it: a picture of `width` x `height` pixels; null where it looks away from the camera.

    Args:
        rgb: the whole picture.
        pixels: the front's corners (4, 2), in the order of `front_corners`; NaN: behind the camera.
        width: of the front, in any unit.
        height: likewise.
    """
    longest = max(width, height)
    size = [max(1, round(LONGEST * side / longest)) for side in (width, height)]
    answer: dict[str, Any] = {"width": size[0], "height": size[1], "picture": None}
    if not faces_camera(pixels):
        return answer
    right, low = size[0] - 0.5, size[1] - 0.5
    target = np.array([(-0.5, low), (right, low), (right, -0.5), (-0.5, -0.5)], np.float32)
    turn = cv2.getPerspectiveTransform(pixels.astype(np.float32), target)
    front = np.asarray(cv2.warpPerspective(rgb, turn, size), np.uint8)
    return answer | {"picture": "data:image/jpeg;base64," + base64.b64encode(jpeg(front)).decode("ascii")}


def jpeg(rgb: NDArray[np.uint8]) -> bytes:
    """A picture (H, W, 3) as the bytes of a JPEG."""
    done, data = cv2.imencode(".jpg", rgb[..., ::-1])
    assert done
    return data.tobytes()


def faces_camera(pixels: NDArray[np.float64]) -> bool:
    """Whether a front with these corners (4, 2) faces the camera: their order in the picture tells."""
    if not np.isfinite(pixels).all():
        return False
    (ax, ay), (bx, by) = pixels[2] - pixels[0], pixels[3] - pixels[1]
    return bool(ax * by - ay * bx < -1.0)  # twice the area, square pixels; y points down
