"""Rectify the front of an object, so that doors and drawers can be drawn on it."""

import base64
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix

LONGEST = 400  # pixels of its longer side
# Corners of the faces +x, +y, -x, -y of a box (lower left, lower right, upper right, upper left), of its top and foot.
FACES = ((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (0, 1, 5, 4), (4, 5, 6, 7), (0, 1, 2, 3))


def front_corners(box: UprightBox, facing: float) -> NDArray[np.float64]:
    """Corners (4, 3) of the side that looks most along a direction about z: lower left, lower right, upper right and
    upper left as whoever faces it sees them."""
    ahead = yaw_matrix(box.yaw).T @ yaw_matrix(facing)[:, 0]
    side = int(np.argmax([ahead[0], ahead[1], -ahead[0], -ahead[1]]))
    return corners(box)[list(FACES[side])]


def extents(points: NDArray[np.float64]) -> tuple[float, float]:
    """Width and height between corners (4, D)."""
    return float(np.linalg.norm(points[1] - points[0])), float(np.linalg.norm(points[3] - points[0]))


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
