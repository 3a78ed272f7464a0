"""Read the pictures that a stage is given, in one way everywhere: upright as a viewer shows them, 8-bit RGB."""

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

from roomkin.stages.contracts.errors import InputError, explain, file_missing
from roomkin.stages.contracts.files import check_file

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
        raise InputError(
            path, f"is not a readable image ({explain(error)}).", SAVE, code="E-IMAGE-UNREADABLE"
        ) from None


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
        raise InputError(
            path, "shows nothing: it is all of one color.", "take another photograph", code="E-PICTURE-BLANK"
        )


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
        raise InputError(
            path,
            what,
            "all files of an input folder have one size, that of the upright picture",
            code="E-SIZE-MISMATCH",
        )


def color_of(index: int) -> Color:
    """A bright color, different from that of the neighbouring indices."""
    red, green, blue = colorsys.hsv_to_rgb((0.02 + index * GOLDEN) % 1.0, 0.75, 1.0)
    return round(255 * red), round(255 * green), round(255 * blue)
