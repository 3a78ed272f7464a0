"""A photograph as the page and the input folder use it: upright, 8-bit RGB, small enough for a screen."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.ExifTags import IFD, Base

from plugins.inputs.rgbd.frame import LONGEST_SIDE
from plugins.inputs.rgbd.lens import CALIBRATION, read_lens, straighten_picture
from stages.contracts.errors import InputError
from stages.contracts.images import check_shown, read_rgb, to_srgb
from stages.geometry.cameras import scale_intrinsics

WIDEST = 2.4  # of a picture's sides: a panorama has no single perspective
FILM = np.hypot(36, 24)  # millimetres: diagonal that "35 mm equivalent" focal lengths refer to
MILLIMETRES = {2: 25.4, 3: 10.0}  # of EXIF's units of resolution: inch, centimetre
HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1")


@dataclass(frozen=True)
class Photo:
    """rgb (H, W, 3) uint8; focal length in its pixels, if EXIF tells; how much smaller it is than the file (>= 1)."""

    rgb: NDArray[np.uint8]
    focal: float | None
    shrunk: float


def _is_heif(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(12)
    except OSError:
        return False
    return head[4:8] == b"ftyp" and head[8:12] in HEIF_BRANDS


def _from_heif(path: Path) -> tuple[NDArray[np.uint8], Image.Exif]:
    """A HEIC photograph, which needs a library of its own."""
    try:
        import pillow_heif
    except ImportError:
        mend = "pip install pillow-heif, or save it as JPEG"
        raise InputError(
            path, "is a HEIC photograph, which nothing installed here reads.", mend, code="E-LIBRARY-MISSING"
        ) from None
    try:
        image = pillow_heif.open_heif(path).to_pillow()  # upright already
        return np.array(to_srgb(image).convert("RGB")), image.getexif()
    except Exception as error:  # a decoder raises its own kinds for broken data
        raise InputError(
            path, f"is not a readable image ({error.__class__.__name__}).", "save it as JPEG", code="E-PICTURE-BROKEN"
        ) from None


def exif_focal(exif: Image.Exif, width: int, height: int) -> float | None:
    """Focal length in pixels of a picture of this size, from the EXIF data of an uncropped photograph; else None."""
    try:
        fine = exif.get_ifd(IFD.Exif)
        equivalent = float(fine.get(Base.FocalLengthIn35mmFilm) or 0)
        if equivalent > 0:
            found = equivalent / FILM * np.hypot(width, height)
        else:
            per_mm = (
                float(fine.get(Base.FocalPlaneXResolution) or 0)
                / MILLIMETRES[int(fine.get(Base.FocalPlaneResolutionUnit, 2))]
            )
            found = float(fine.get(Base.FocalLength) or 0) * per_mm
            found *= max(width, height) / float(fine.get(Base.ExifImageWidth) or max(width, height))
    except (ValueError, TypeError, ZeroDivisionError, ArithmeticError, SyntaxError, KeyError):
        return None
    return float(found) if 0.2 * max(width, height) < found < 20 * min(width, height) else None


def _exif(path: Path) -> tuple[Image.Exif, bool]:
    """EXIF data of a picture, and whether it says to be a panorama."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with Image.open(path) as image:
            xmp = image.info.get("xmp", b"")
            return image.getexif(), b"GPano:ProjectionType" in (xmp if isinstance(xmp, bytes) else str(xmp).encode())


def read_photo(path: Path, lens: Path | None = None) -> Photo:
    """Read a photograph.

    Args:
        lens: calibration of the camera, used to remove distortion.

    Raises:
        InputError: no picture, a panorama, or one that shows nothing.
    """
    if _is_heif(path):
        rgb, exif = _from_heif(path)
        panorama = False
    else:
        rgb = read_rgb(path)
        exif, panorama = _exif(path)
    height, width = rgb.shape[:2]
    if panorama or max(width, height) > WIDEST * min(width, height):
        mend = "cut out a part with an ordinary field of view"
        raise InputError(
            path, f"is a panorama ({width}x{height}), which has no single perspective.", mend, code="E-PICTURE-PANORAMA"
        )
    focal, shrunk = exif_focal(exif, width, height), max(1.0, max(width, height) / LONGEST_SIDE)
    if shrunk > 1:
        size = round(width / shrunk), round(height / shrunk)
        rgb = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    check_shown(path, rgb)
    focal = None if focal is None else focal / shrunk
    if lens is not None:
        known = read_lens(lens, width, height)
        if known.distortion is None:
            raise InputError(lens, "holds no distortion.", CALIBRATION, code="E-LENS-MISSING")
        scaled = scale_intrinsics(known.intrinsics, rgb.shape[1] / width, rgb.shape[0] / height)
        rgb, focal = straighten_picture(rgb, replace(known, intrinsics=scaled), lens)
    return Photo(rgb, focal, shrunk)
