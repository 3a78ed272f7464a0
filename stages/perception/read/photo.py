"""A photograph as the page and the input folder use it: upright, 8-bit RGB, small enough for a screen."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.ExifTags import IFD, Base

from roomkin.stages.config.perception import CameraSection
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.files import check_file
from roomkin.stages.contracts.hand import digest_of_image
from roomkin.stages.contracts.images import check_shown, open_picture, read_rgb, to_srgb
from roomkin.stages.geometry.frames import scale_intrinsics
from roomkin.stages.perception.read.frame import LONGEST_SIDE, is_stretched
from roomkin.stages.perception.read.lens import CALIBRATION, read_lens, straighten_picture

WIDEST = 2.4  # of a picture's sides: a panorama has no single perspective
# Of pictures of all directions, made this wide, where noise is gone. None of 4690 crops of photographs is so; chosen.
SMALL = 512  # pixels
SEAM = 3.0  # times the change from column to column
ONE_POINT = 0.25  # of the picture's contrast
FILM = np.hypot(36, 24)  # millimetres: diagonal that "35 mm equivalent" focal lengths refer to
MILLIMETRES = {2: 25.4, 3: 10.0}  # of EXIF's units of resolution: inch, centimetre
HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1")


@dataclass(frozen=True)
class Photo:
    """rgb (H, W, 3) uint8; focal length in its pixels, if EXIF tells; how much smaller it is than the file (>= 1);
    SHA-256 of that file."""

    rgb: NDArray[np.uint8]
    focal: float | None
    shrunk: float
    digest: str = ""


def _is_heif(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(12)
    except OSError:
        return False
    return head[4:8] == b"ftyp" and head[8:12] in HEIF_BRANDS


@contextmanager
def _open_heif(path: Path) -> Iterator[Any]:
    """A HEIC photograph, not decoded yet, which needs a library of its own."""
    try:
        import pillow_heif
    except ImportError:
        mend = "pip install pillow-heif, or save it as JPEG"
        what = "is a HEIC photograph, which nothing installed here reads."
        raise InputError(path, what, mend, code="E-LIBRARY-MISSING") from None
    try:
        yield pillow_heif.open_heif(path)
    except Exception as error:  # a decoder raises its own kinds for broken data
        what = f"is not a readable image ({explain(error)})."
        raise InputError(path, what, "save it as JPEG", code="E-PICTURE-BROKEN") from None


def exif_focal(exif: Image.Exif, width: int, height: int) -> float | None:
    """Focal length in pixels of a picture of this size, from the EXIF data of an uncropped photograph; else None."""
    try:
        fine = exif.get_ifd(IFD.Exif)
        equivalent = float(fine.get(Base.FocalLengthIn35mmFilm) or 0)
        if equivalent > 0:
            found = equivalent / FILM * np.hypot(width, height)
        else:
            unit = MILLIMETRES[int(fine.get(Base.FocalPlaneResolutionUnit, 2))]
            per_mm = float(fine.get(Base.FocalPlaneXResolution) or 0) / unit
            found = float(fine.get(Base.FocalLength) or 0) * per_mm
            found *= max(width, height) / float(fine.get(Base.ExifImageWidth) or max(width, height))
    except (ValueError, TypeError, ZeroDivisionError, ArithmeticError, SyntaxError, KeyError):
        return None
    return float(found) if 0.2 * max(width, height) < found < 20 * min(width, height) else None


def _exif(path: Path) -> tuple[Image.Exif, bool]:
    """EXIF data of a picture, and whether it says to be a panorama."""
    with open_picture(path) as image:  # a PNG may have them at its end, which may be cut off
        xmp = image.info.get("xmp", b"")
        return image.getexif(), b"GPano:ProjectionType" in (xmp if isinstance(xmp, bytes) else str(xmp).encode())


def _check_perspective(path: Path, panorama: bool, width: int, height: int) -> None:
    if panorama or max(width, height) > WIDEST * min(width, height):
        mend = "cut out a part with an ordinary field of view"
        what = f"is a panorama ({width}x{height}), which has no single perspective."
        raise InputError(path, what, mend, code="E-PICTURE-PANORAMA")


def check_photo(path: Path) -> None:
    """Refuse what is no photograph, by its header alone.

    Raises:
        InputError: as `read_photo`, but for what only its pixels tell.
    """
    check_file(path)
    if _is_heif(path):
        with _open_heif(path):
            return
    with open_picture(path) as image:
        width, height = image.size
    _check_perspective(path, _exif(path)[1], width, height)


def shows_all_around(rgb: NDArray[np.uint8]) -> bool:
    """Whether a picture (H, W, 3) is of all directions (equirectangular): twice as wide as high, its left side goes on
    at its right one, and its first and last row are one point each. In no crop of a photograph all of this is so."""
    if is_stretched((rgb.shape[1], rgb.shape[0]), (2, 1)):
        return False
    small = cv2.resize(rgb, (SMALL, SMALL // 2), interpolation=cv2.INTER_AREA).astype(np.int16)
    step, seam = np.abs(np.diff(small, axis=1)).mean(), np.abs(small[:, 0] - small[:, -1]).mean()
    side, *poles = (line.std(axis=0).max() for line in (small[:, 0], small[0], small[-1]))
    least = ONE_POINT * small.std(axis=(0, 1)).max()
    return bool(seam < SEAM * step and max(poles) < least < side)  # a side of one color is a frame's


def read_photo(path: Path, lens: Path | None = None) -> Photo:
    """Read a photograph.

    Args:
        lens: calibration of the camera, used to remove distortion.

    Raises:
        InputError: no picture or no file, a panorama, or one that shows nothing.
    """
    check_file(path)
    if _is_heif(path):
        with _open_heif(path) as opened:
            image = opened.to_pillow()  # upright already
            rgb, exif, panorama = np.array(to_srgb(image).convert("RGB")), image.getexif(), False
    else:
        rgb, (exif, panorama) = read_rgb(path), _exif(path)
    height, width = rgb.shape[:2]
    _check_perspective(path, panorama or shows_all_around(rgb), width, height)
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
    return Photo(rgb, focal, shrunk, digest_of_image(path))


def read_known(path: Path, options: CameraSection) -> tuple[Photo, float | None, str]:
    """A photograph, its focal length, pixels, and who tells that; None: nobody.

    Raises:
        InputError: as `read_photo`.
    """
    photo = read_photo(path, Path(options.lens) if options.lens else None)
    if options.field_of_view is not None:
        focal = photo.rgb.shape[1] / 2 / np.tan(np.deg2rad(options.field_of_view) / 2)
        return photo, float(focal), "perception.field_of_view"
    return photo, photo.focal, "perception.lens" if options.lens else "EXIF"
