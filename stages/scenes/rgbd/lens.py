"""A lens that bends straight lines, from a calibration file, and pictures without that."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.contracts.arrays import readable
from stages.scenes.rgbd.cameras import Matrix, matrix, read_intrinsics

NAMES = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")  # in OpenCV's order
LISTS = ("distortion_coefficients", "distortion_coeffs", "dist_coeffs", "distortion", "coeffs", "dist", "d")
MODELS = {"plumb_bob", "rational_polynomial", "brown_conrady", "radtan", "opencv", "pinhole", ""}
CALIBRATION = "K and k1, k2, p1, p2, k3 as OpenCV, ROS and Kalibr write them (JSON, YAML)"


@dataclass(frozen=True)
class Lens:
    """K and OpenCV's coefficients (5 or 8)."""

    intrinsics: Matrix
    distortion: NDArray[np.float64]


def read_lens(path: Path, width: int, height: int) -> Lens:
    """The lens of a picture of this size.

    Raises:
        InputError: no calibration, or one of another model.
    """
    intrinsics = read_intrinsics(path, width, height)
    with readable(path, "calibration", CALIBRATION):
        text = path.read_text(encoding="utf-8-sig")
        data = json.loads(text) if text.lstrip().startswith("{") else yaml.safe_load(text.replace("%YAML:1.0", ""))
    if not isinstance(data, dict):
        raise InputError(path, "holds no distortion.", CALIBRATION)
    known: dict[str, Any] = {str(key).lower(): value for key, value in data.items()}
    for key in ("color", "rgb", "intrinsics", "camera"):
        if isinstance(known.get(key), dict):
            known = {str(name).lower(): value for name, value in known[key].items()} | known
    model = str(known.get("distortion_model", ""))
    if model.lower().replace(" ", "_").removeprefix("distortion.") not in MODELS:
        raise InputError(path, f"has the distortion model '{model}', which is not read.", CALIBRATION)
    return Lens(intrinsics, _coefficients(path, known))


def _coefficients(path: Path, known: dict[str, Any]) -> NDArray[np.float64]:
    values = next((known[name] for name in LISTS if name in known), None)
    values = values.get("data") if isinstance(values, dict) and "data" in values else values
    named = values if isinstance(values, dict) else known
    if not isinstance(values, list):
        values = [named.get(name, 0) for name in NAMES] if "k1" in named else None
    try:
        found = np.asarray(values, dtype=float).ravel()
    except (ValueError, TypeError):
        found = np.array([np.nan])
    if len(found) not in (4, 5, 8) or not np.isfinite(found).all():
        raise InputError(path, "holds no distortion.", CALIBRATION)
    return np.pad(found, (0, 1)) if len(found) == 4 else found


def straightened(rgb: NDArray[np.uint8], lens: Lens, where: object) -> tuple[NDArray[np.uint8], float]:
    """The picture (H, W, 3) as a pinhole camera of the same size would see it, and its focal length in pixels.

    Its axis is in the middle, and every pixel is seen: what lies beyond at the borders is lost.

    Raises:
        InputError: the distortion leaves nothing of the picture.
    """
    height, width = rgb.shape[:2]
    whole, _ = cv2.getOptimalNewCameraMatrix(
        lens.intrinsics, lens.distortion, (width, height), 0, (width, height), centerPrincipalPoint=True
    )
    focal = float(max(whole[0, 0], whole[1, 1]))
    if not 0.2 * width < focal < 20 * width:
        raise InputError(where, "bends the picture so much that nothing of it is left.", CALIBRATION)
    target = matrix(focal, focal, (width - 1) / 2, (height - 1) / 2)
    maps = cv2.initUndistortRectifyMap(
        lens.intrinsics, lens.distortion, np.eye(3), target, (width, height), cv2.CV_32FC1
    )
    return np.asarray(cv2.remap(rgb, *maps, cv2.INTER_LINEAR), dtype=np.uint8), focal
