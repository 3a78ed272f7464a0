"""Lens distortion: read it from a calibration file, and remove it from pictures."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.geometry.frames import make_intrinsics
from roomkin.stages.perception.read.camera_files import contents, find_first, has_camera, simplify_name
from roomkin.stages.perception.read.cameras import Matrix, find_intrinsics
from roomkin.stages.perception.read.frame import Frame

COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")  # in OpenCV's order
LISTS = ("distortioncoefficients", "distortioncoeffs", "distcoeffs", "distcoeff", "distcoefs", "distcoef",
         "distortionparameters", "distortionparams", "distortion", "coeffs", "dist", "d")  # fmt: skip
OF_LENS = ("distort", "distcoef", "radial", "tangential", "thinprism")  # parts of other names for coefficients
MODELS = {"plumb_bob", "rational_polynomial", "brown_conrady", "radtan", "opencv", "full_opencv", "radial",
          "simple_radial", "pinhole", "perspective", ""}  # fmt: skip
COUNTS = (5, 8, 12, 14)  # of OpenCV's coefficients
INVERSE = "inverse_brown_conrady"  # RealSense: from bent to straight
FISHEYE = ("fisheye", "equidistant", "kannala", "kb4")  # names of Kannala and Brandt's model, which is not read
LEAST_LEFT = 1 / 3  # of the pixels of a picture made straight: an action camera leaves nine tenths; chosen
CALIBRATION = "K and k1, k2, p1, p2, k3 as OpenCV, ROS and Kalibr write them"


@dataclass(frozen=True)
class Lens:
    """K and OpenCV's coefficients (5 to 14); none where nobody states them."""

    intrinsics: Matrix
    distortion: NDArray[np.float64] | None = None

    @property
    def bends(self) -> bool:
        """Whether it is no pinhole."""
        return self.distortion is not None and bool(self.distortion.any())


def read_lens(path: Path, width: int, height: int, picture: str = "") -> Lens:
    """The camera of a picture of this size; `picture`: its file name, for files of many cameras.

    Raises:
        InputError: no intrinsics, or a lens of a model that is not read.
    """
    stated = contents(path, picture)
    intrinsics = find_intrinsics(path, stated, width, height)
    return Lens(intrinsics, find_distortion(path, stated, intrinsics, width, height))


def find_distortion(
    path: Path, known: list[float] | dict[str, Any], intrinsics: Matrix, width: int, height: int
) -> NDArray[np.float64] | None:
    """OpenCV's coefficients (5, 8, 12 or 14) in what a file states; None if it names none.

    Raises:
        InputError: they are of a model that is not read, or broken.
    """
    if not isinstance(known, dict):
        return None
    model = known.get("distortionmodel") or (known.get("model") if "coeffs" in known else "")
    model = re.sub(r"\W+", "_", str(model or "").lower()).removeprefix("rs2_").removeprefix("distortion_")
    camera = f"{model} {find_first(known, 'cameramodel', 'cameratype')}".lower()
    if any(word in camera for word in FISHEYE) or known.get("isfisheye"):
        mend = "straighten the picture with cv2.fisheye, and give the K of what it becomes"
        raise InputError(path, "is of a fisheye lens, which is not read.", mend, code="E-LENS-MODEL")
    if model == "none" or all(known.get(name) in (None, []) for name in ("k1", *LISTS)):
        others = [name for name, value in known.items() if _is_of_lens(name, value)]
        if others and model != "none":
            raise InputError(path, f"has '{others[0]}', which is not read.", CALIBRATION, code="E-LENS-MODEL")
        return None
    found = _read_coefficients(path, known)
    if "flx" in known and float(known.get("k4") or 0):
        model = "with k4 of nerfstudio"
    if found.any() and model not in MODELS | {INVERSE}:
        what = f"has the distortion model '{model}', which is not read."
        raise InputError(path, what, CALIBRATION, code="E-LENS-MODEL")
    return _invert_distortion(found, intrinsics, width, height) if model == INVERSE else found


def _is_of_lens(name: str, value: Any) -> bool:
    """Whether the value under a name is of the lens: by the name, or as a list of its coefficients."""
    inner = {simplify_name(str(key)) for key in value} if isinstance(value, dict) else set()
    is_list = bool(inner & {*COEFFICIENTS, *LISTS}) and not has_camera(dict.fromkeys(inner))
    return (is_list or any(word in name for word in OF_LENS)) and _holds_number(value)


def _holds_number(value: Any) -> bool:
    """Whether a value holds a number other than 0."""
    if isinstance(value, (list, dict)):
        return any(_holds_number(one) for one in (value.values() if isinstance(value, dict) else value))
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value != 0


def _invert_distortion(
    inverse: NDArray[np.float64], intrinsics: Matrix, width: int, height: int
) -> NDArray[np.float64]:
    """OpenCV's coefficients (undistorted to distorted) of the inverse ones that RealSense writes, by least squares."""
    u, v = np.meshgrid(np.linspace(0, width - 1, 20), np.linspace(0, height - 1, 20))
    bent = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(intrinsics).T
    x, y = cv2.projectPoints(bent, np.zeros(3), np.zeros(3), np.eye(3), inverse)[0][:, 0].T
    r2 = x**2 + y**2
    across = np.stack([x * r2, x * r2**2, 2 * x * y, r2 + 2 * x**2, x * r2**3], axis=1)
    down = np.stack([y * r2, y * r2**2, r2 + 2 * y**2, 2 * x * y, y * r2**3], axis=1)
    missing = np.concatenate([bent[:, 0] - x, bent[:, 1] - y])
    return np.asarray(np.linalg.lstsq(np.concatenate([across, down]), missing)[0])


def _read_coefficients(path: Path, known: dict[str, Any]) -> NDArray[np.float64]:
    """OpenCV's coefficients, padded with zeros to one of its counts; further zeros are dropped."""
    found = _read_numbers(known)
    used = len(found) if np.isnan(found).any() else len(np.trim_zeros(found, "b"))
    count = next((count for count in COUNTS if count >= used), 0)
    if not count or not np.isfinite(found).all() or (used and len(found) < 4):
        raise InputError(path, "holds no distortion.", CALIBRATION, code="E-LENS-MISSING")
    return np.pad(found[:count], (0, max(0, count - len(found))))


def _read_numbers(known: dict[str, Any]) -> NDArray[np.float64]:
    """Coefficients from a list, or by their names; NaN: none."""
    values = next((known[name] for name in LISTS if name in known), None)
    values = values.get("data") if isinstance(values, dict) and "data" in values else values
    values = values.replace(",", " ").split() if isinstance(values, str) else values
    named = values if isinstance(values, dict) else known
    if not isinstance(values, list):
        values = [named.get(name, 0) for name in COEFFICIENTS] if "k1" in named else None
    try:
        return np.asarray(values, dtype=float).ravel()
    except (ValueError, TypeError):
        return np.array([np.nan])


def straighten_picture(rgb: NDArray[np.uint8], lens: Lens, where: object) -> tuple[NDArray[np.uint8], float]:
    """The picture (H, W, 3) as a pinhole camera of the same size would see it, and its focal length in pixels.

    Its axis is in the middle, and every pixel is seen: what lies beyond at the borders is lost.

    Raises:
        InputError: the distortion leaves nothing of the picture.
    """
    target = _choose_pinhole(lens, rgb.shape[1], rgb.shape[0], where)
    return _remap(target, rgb, lens, cv2.INTER_LINEAR), float(target[0, 0])


def straighten_frame(frame: Frame, distortion: NDArray[np.float64] | None) -> Frame:
    """A frame of one size as a pinhole camera would see it; depth and masks by the nearest pixel, unmixed.

    Raises:
        InputError: the distortion leaves nothing of the picture.
    """
    lens = Lens(frame.intrinsics, distortion)
    if not lens.bends:
        return frame
    target = _choose_pinhole(lens, frame.rgb.shape[1], frame.rgb.shape[0], "intrinsics")
    masks = frame.masks and replace(frame.masks, values=_remap(target, frame.masks.values, lens, cv2.INTER_NEAREST))
    rgb, depth = _remap(target, frame.rgb, lens, cv2.INTER_LINEAR), _remap(target, frame.depth, lens, cv2.INTER_NEAREST)
    notes = [*frame.notes, "the lens's distortion is taken out"]
    return replace(frame, rgb=rgb, depth=depth, intrinsics=target, masks=masks, notes=notes)


def _choose_pinhole(lens: Lens, width: int, height: int, where: object) -> Matrix:
    """K of the pinhole camera all of whose pixels are in the picture."""
    size, bent = (width, height), (lens.intrinsics, lens.distortion)
    whole, _ = cv2.getOptimalNewCameraMatrix(*bent, size, 0, size, centerPrincipalPoint=True)
    focal = float(max(whole[0, 0], whole[1, 1]))
    target = make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2)
    pixels = np.arange(width * height, dtype=np.float32).reshape(height, width)
    share = len(np.unique(_remap(target, pixels, lens, cv2.INTER_NEAREST))) / pixels.size
    if not 0.2 * width < focal < 20 * width or share < LEAST_LEFT:
        what = f"bends the picture so much that {100 * share:.0f} % of its pixels are left."
        raise InputError(where, what, CALIBRATION, code="E-LENS-WIDE")
    return target


def _remap(target: Matrix, image: NDArray[Any], lens: Lens, interpolation: int) -> NDArray[Any]:
    """An image (H, W, ...) as a camera with this K sees it."""
    size = image.shape[1::-1]
    maps = cv2.initUndistortRectifyMap(lens.intrinsics, lens.distortion, np.eye(3), target, size, cv2.CV_32FC1)
    return np.asarray(cv2.remap(image, *maps, interpolation), dtype=image.dtype)
