"""Pictures and depth as stages are given them: upright 8-bit RGB; metres along the axis, millimetres recognised."""

import colorsys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageCms, ImageOps

from roomkin.stages.contracts.arrays import read_npz
from roomkin.stages.contracts.errors import InputError, explain, file_missing
from roomkin.stages.contracts.files import check_file
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.geometry.depth_forms import find_marks, is_inverse, is_zbuffer, remove_marks
from roomkin.stages.geometry.room_planes import is_upside_down

FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF")  # by content: a JPEG may be called rgb.png
MIN_SIDE, MAX_PIXELS = 16, 60_000_000  # pixels of a side, and in all
SAVE = "save it again as PNG"
FOLDER = "`roomkin annotator annotate PICTURE` makes an input folder, docs/scenes.md says what it holds"
MIN_CONTRAST = 2.0  # standard deviation of the brightness below which nothing is to be seen
COLUMNS, TILE, LETTERS = 6, 192, 16  # of a sheet of small pictures: in a row; pixels of a side, and of letters
GOLDEN = 0.618034  # golden ratio: steps of hue that keep neighbours apart
DEEP = ("I;16", "I;16B", "I;16L", "I;16N", "I")  # modes of one channel with more than 8 bits

Color = tuple[int, int, int]


@contextmanager
def open_picture(path: Path) -> Iterator[Image.Image]:
    """The picture, not decoded yet.

    Raises:
        InputError: no picture, several in one file, or one of absurd size.
    """
    check_file(path)
    if not path.is_file():
        raise file_missing(path, FOLDER)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a large picture is refused below, with words
            with Image.open(path, formats=FORMATS) as image:
                width, height = image.size
                size = f"is {width}x{height} pixels: too"
                if width * height > MAX_PIXELS:
                    share = (MAX_PIXELS / (width * height)) ** 0.5
                    fix = f"make it smaller, at most {int(share * width)}x{int(share * height)}, in any picture viewer"
                    raise InputError(path, f"{size} large.", fix, code="E-IMAGE-SIZE")
                if min(width, height) < MIN_SIDE:
                    raise InputError(path, f"{size} small.", f"at least {MIN_SIDE} each way", code="E-IMAGE-SIZE")
                if (count := getattr(image, "n_frames", 1)) > 1 and image.format != "MPO":  # a phone's: the first is it
                    what = f"holds {count} pictures: which of them is meant?"
                    raise InputError(path, what, "save the one alone, as PNG", code="E-IMAGE-MANY")
                yield image
    except Image.DecompressionBombError:
        what, fix = "has too many pixels.", f"make it smaller, at most {MAX_PIXELS:,} pixels, in any picture viewer"
        raise InputError(path, what, fix, code="E-IMAGE-SIZE") from None
    except InputError:
        raise
    except Exception as error:  # each decoder raises its own kinds for broken data
        what = f"is not a readable image ({explain(error)})."
        raise InputError(path, what, SAVE, code="E-IMAGE-UNREADABLE") from None


def read_upright(path: Path) -> Image.Image:
    """The picture, decoded and turned as its EXIF data say.

    Raises:
        InputError: as `open_picture`.
    """
    with open_picture(path) as image:
        image.load()
        turned = ImageOps.exif_transpose(image)
        turned.format = image.format
        return turned


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """A picture (H, W, 3) in sRGB: turned by its EXIF data, alpha laid on white, all else converted to 8 bits.

    Raises:
        InputError: no picture, of absurd size, or with float pixels.
    """
    image = to_srgb(read_upright(path))
    if image.mode in DEEP:
        grey = np.asarray(image).astype(np.int64)
        if grey.min() < 0 or grey.max() > 65535:
            raise InputError(path, "has 32-bit pixels.", "save it with 8 bits per channel", code="E-IMAGE-BITS")
        return np.repeat(np.rint(grey / 257).astype(np.uint8)[..., None], 3, axis=2)
    if image.mode == "F":
        raise InputError(path, "has float pixels.", "save it with 8 bits per channel", code="E-IMAGE-BITS")
    if image.mode in ("LA", "PA", "RGBA", "La", "RGBa") or "transparency" in image.info:
        rgba = np.asarray(image.convert("RGBA"))
        alpha = rgba[..., 3:] / 255.0
        return np.rint(rgba[..., :3] * alpha + 255.0 * (1 - alpha)).astype(np.uint8)
    return np.array(image.convert("RGB"))


def to_srgb(image: Image.Image) -> Image.Image:
    """The picture in the colors of its color profile; without one that is read, as it is, as a viewer shows it."""
    profile = image.info.get("icc_profile")
    if not profile:
        return image
    try:
        given = ImageCms.ImageCmsProfile(BytesIO(profile))
        if "srgb" in ImageCms.getProfileDescription(given).lower():  # all but rounding
            return image
        mode = "RGB" if image.mode == "CMYK" else image.mode
        found = ImageCms.profileToProfile(image, given, ImageCms.createProfile("sRGB"), outputMode=mode)
    except (ImageCms.PyCMSError, OSError):
        return image
    return found or image


def read_narrow(path: Path, width: int) -> Image.Image:
    """The picture upright as RGB (transparency on white), no wider than `width` pixels.

    Raises:
        InputError: the file is missing or no picture.
    """
    picture = Image.fromarray(read_rgb(path))
    picture.thumbnail((width, max(width, picture.height)), Image.Resampling.LANCZOS)
    return picture


def orientation_of(path: Path) -> int:
    """How EXIF data turn a picture: 1 (not at all, as one of another format) to 8."""
    with warnings.catch_warnings(), suppress(OSError):
        warnings.simplefilter("ignore")
        with Image.open(path, formats=FORMATS) as image:
            found = image.getexif().get(ExifTags.Base.Orientation, 1)
            return found if found in range(1, 9) else 1
    return 1


def check_shown(path: Path, rgb: NDArray[np.uint8]) -> None:
    """Refuse a picture (H, W, 3) that shows nothing: black, white, or transparent all over.

    Raises:
        InputError: it is all of one color.
    """
    if float(rgb.std(axis=(0, 1)).max()) < MIN_CONTRAST:
        what = "shows nothing: it is all of one color."
        raise InputError(path, what, "take another photograph", code="E-PICTURE-BLANK")


def read_masks(path: Path) -> NDArray[np.uint16]:
    """A label image (H, W) of one channel: 8 or 16 bits, or a palette, whose indices are the values.

    Raises:
        InputError: no picture, several channels, float pixels, or a format that changes values (JPEG).
    """
    image = read_upright(path)
    mend = "write one channel of 16 bits with a value per object, as PNG"
    if image.format in ("JPEG", "MPO"):
        raise InputError(path, "is a JPEG, which changes mask values.", mend, code="E-MASK-FORMAT")
    if image.mode not in (*DEEP, "L", "P", "1"):
        kind = "float pixels" if image.mode == "F" else f"{len(image.getbands())} channels ({image.mode})"
        raise InputError(path, f"has {kind}.", mend, code="E-MASK-FORMAT")
    values: NDArray[Any] = np.asarray(image)
    if values.dtype.kind != "b" and (values.min() < 0 or values.max() > 65535):
        raise InputError(path, f"holds the value {values.max()}.", mend, code="E-MASK-FORMAT")
    return values.astype(np.uint16)


def check_size(path: Path, array: NDArray[Any], width: int, height: int, source: str) -> None:
    """Refuse a picture (H, W, ...) of another size than `source` says."""
    found = array.shape[1], array.shape[0]
    if found != (width, height):
        turned = " It is turned by a quarter: all files are of the upright picture." if found == (height, width) else ""
        what = f"is {found[0]}x{found[1]} pixels, but {source} says {width}x{height}.{turned}"
        fix = "all files of an input folder have one size, that of the upright picture"
        raise InputError(path, what, fix, code="E-SIZE-MISMATCH")


def color_of(index: int) -> Color:
    """A bright color, different from that of the neighbouring indices."""
    red, green, blue = colorsys.hsv_to_rgb((0.02 + index * GOLDEN) % 1.0, 0.75, 1.0)
    return round(255 * red), round(255 * green), round(255 * blue)


NEAREST = 0.1  # metres: the median depth of a picture of a room is between this and `LARGEST`
DEPTH_UNITS = (100, 256, 512, 1000, 4000, 5000, 6553.5, 10000)  # numbers that stand for a metre in data sets
SKY = 100.0  # metres: farther away is no room
FORMAT, UNIT = "E-DEPTH-FORMAT", "E-DEPTH-UNIT"
DOWN, TURNED = "E-PICTURE-UPSIDE-DOWN", "it is upside down, or a ceiling without a floor."
TURN = (
    "turn picture, depth and masks by 180 degrees; flip them top to bottom instead if writing is then mirrored "
    "(renderers store the bottom row first)"
)
UNSTRETCH = (
    "store near * far / (far - value * (far - near)), with near and far of the renderer's camera in metres; of depth "
    "that was stretched to 0..1 for show, what it was before"
)
WRITE = "np.savez(path, depth=...) with an array (height, width) in metres"


def read_depth(path: Path) -> tuple[NDArray[np.float32], bool]:
    """The array `depth` (H, W) in metres, 0: unknown, and the flag `exact`.

    Values that are negative, not finite, beyond 100 m, or marks (`depth_marks`) count as unknown. Whole numbers, and
    floats with a median beyond a metre when read as millimetres, are millimetres and are converted, which is printed.

    Raises:
        InputError: no such array, no depth at all, or neither metres nor millimetres.
    """
    if not path.is_file() and path.with_suffix(".png").is_file():
        raise InputError(path, "no such file, but there is a depth.png.", f"store its array: {WRITE}", code=FORMAT)
    arrays = read_npz(path, FOLDER)
    if "depth" not in arrays:
        raise InputError(path, "has no array named 'depth'.", WRITE, code=FORMAT)
    depth, exact = arrays["depth"], arrays.get("exact", np.array(False))
    if depth.dtype.kind not in "fiu":
        raise InputError(path, f"depth: has type {depth.dtype}.", WRITE, code=FORMAT)
    if depth.ndim != 2 or 0 in depth.shape:
        raise InputError(path, f"depth: has shape {depth.shape}.", WRITE, code=FORMAT)
    if exact.shape != () or exact.dtype.kind not in "biu":
        what = f"exact: has type {exact.dtype} and shape {exact.shape}."
        raise InputError(path, what, "one bool, or leave it out", code=FORMAT)
    if depth.dtype.itemsize == 1:
        raise InputError(path, "depth: has 8 bits: a picture of depth, not depth.", WRITE, code=FORMAT)
    # A wall that a person drew is one distance all over, so that of floats only what is beyond a room is a mark.
    marks = [] if exact else [mark for mark in find_marks(depth) if depth.dtype.kind in "iu" or mark > LARGEST]
    if marks:
        print(f"{path}: depth {' and '.join(f'{mark:g}' for mark in marks)} is taken for unknown")
        depth = remove_marks(depth, marks)
    known = np.where(np.isfinite(depth) & (depth > 0), depth, 0)
    if not known.any():
        raise InputError(path, "depth: no value is known (finite and above 0).", WRITE, code="E-DEPTH-EMPTY")
    factor = _metres_per_unit(path, known)
    if factor != 1:
        print(f"{path}: depth is in millimetres (median {np.median(known[known > 0]):g}), converted to metres")
    metres = (known * factor).astype(np.float32)
    check_depth(path, metres)
    return np.where(metres > SKY, np.float32(0), metres), bool(exact)


def check_depth(path: Path, values: NDArray[np.floating]) -> None:
    """Refuse inverse depth and z-buffers (H, W): as depth they give things of no size and place.

    Raises:
        InputError: it is.
    """
    if is_inverse(values):
        what = "looks like inverse depth: it grows towards the lower border, and floors and walls are flat in it."
        fix = "store depth in metres: 1 / values for disparity, by the scale of its network"
        raise InputError(path, what, fix, code=UNIT)
    if is_zbuffer(values):
        what = f"is a z-buffer, not metres: all within 0..1, half of it above {np.median(values[values > 0]):.3f}."
        raise InputError(path, what, UNSTRETCH, code="E-DEPTH-ZBUFFER")


def check_turned(where: object, points: NDArray[np.float64], known: NDArray[np.bool_], max_tilt: float) -> None:
    """Refuse a picture of points (H, W, 3), camera frame, that is upside down with its depth.

    Whether it was turned by 180 degrees or mirrored top to bottom is not in depth: a person sees it.

    Raises:
        InputError: nothing level faces up, and much faces down.
    """
    if is_upside_down(points, known, max_tilt):
        what = f"shows no level surface that faces up, but one that faces down: {TURNED}"
        raise InputError(where, what, TURN, code=DOWN)


def _metres_per_unit(path: Path, depth: NDArray[Any]) -> float:
    median = float(np.median(depth[depth > 0]))
    whole = depth.dtype.kind in "iu"
    if not whole and NEAREST <= median <= LARGEST:
        return 1.0
    if whole and depth.max() <= np.iinfo(np.uint8).max:
        what = f"depth: has no value above {depth.max():g}: bytes of a picture, not millimetres."
        raise InputError(path, what, WRITE, code=UNIT)
    if (100 if whole else 1000) <= median <= 1000 * LARGEST:
        return 0.001
    what = f"depth: has the median {median:.3g}, which is neither metres nor millimetres of a room."
    raise InputError(path, what, "write metres as float32, or millimetres as uint16", code=UNIT)
