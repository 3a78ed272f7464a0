"""Pictures, depth and masks of an input folder: read alike everywhere, or refused in one line."""

import io
import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.images import read_masks, read_rgb
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.matching.snapshots import SceneObjects
from tests.unit.contract_files import HEIGHT, WIDTH, Bench, contents, masks, write_files

ORIENTATION = 0x0112


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_files(tmp_path_factory.mktemp("valid"))


@pytest.fixture
def bench(valid: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Bench:
    for name in ("input", "extraction"):
        shutil.copytree(valid / name, tmp_path / "run" / name)
    return Bench(tmp_path / "run", capsys)


def gradient() -> np.ndarray:
    """A picture that looks different from every side."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    return np.stack([u * 5, v * 7, (u + v) * 2], axis=-1).astype(np.uint8)


def exif(orientation: int) -> bytes:
    data = Image.Exif()
    data[ORIENTATION] = orientation
    return data.tobytes()


# what can be read


@pytest.mark.parametrize(
    ("orientation", "turned"),
    [(1, lambda p: p), (2, np.fliplr), (3, lambda p: np.rot90(p, 2)), (4, np.flipud), (6, lambda p: np.rot90(p, 1)),
     (8, lambda p: np.rot90(p, -1))],
)  # fmt: skip
@pytest.mark.parametrize("form", ["PNG", "JPEG"])
def test_exif_rotation_shows_the_picture_upright(
    tmp_path: Path, orientation: int, turned: Callable[[np.ndarray], np.ndarray], form: str
) -> None:
    stored = turned(gradient())  # as the sensor saw it; a viewer turns it back
    Image.fromarray(np.ascontiguousarray(stored)).save(tmp_path / "rgb.png", form, exif=exif(orientation), quality=98)
    picture = read_rgb(tmp_path / "rgb.png")
    assert picture.shape == gradient().shape
    assert np.abs(picture.astype(int) - gradient()).mean() < (1 if form == "PNG" else 6)


def test_every_stage_sees_a_turned_photo_alike(bench: Bench) -> None:
    upside_down = np.ascontiguousarray(np.rot90(gradient(), 2))
    for folder in ("input", "extraction"):
        Image.fromarray(upside_down).save(bench.root / folder / "rgb.png", "JPEG", exif=exif(3), quality=98)
    given = read_scene_input(bench.root / "input").rgb
    matched = SceneObjects(bench.root / "extraction/objects.json", bench.root / "extraction/rgb.png")
    assert np.abs(given.astype(int) - gradient()).mean() < 6
    np.testing.assert_array_equal(matched.view(matched.objects.objects[0]).rgb, given)


def picture_of(mode: str) -> tuple[Image.Image, np.ndarray]:
    """A picture in a mode of PIL, and what it looks like on white as RGB."""
    rgb = gradient()
    image = Image.fromarray(rgb)
    grey = np.asarray(image.convert("L"))
    if mode == "I;16":
        return Image.fromarray(grey.astype(np.uint16) * 257), np.repeat(grey[..., None], 3, axis=2)
    if mode == "RGBA":
        alpha = np.full(rgb.shape[:2], 51, np.uint8)
        return Image.fromarray(np.dstack([rgb, alpha])), np.rint(rgb * 0.2 + 255 * 0.8)
    if mode == "LA":
        alpha = np.full(rgb.shape[:2], 0, np.uint8)
        return Image.fromarray(np.dstack([grey, alpha]), "LA"), np.full(rgb.shape, 255)
    converted = image.convert(mode)
    return converted, np.asarray(converted.convert("RGB"))


@pytest.mark.parametrize("mode", ["RGB", "L", "1", "P", "I;16", "RGBA", "LA", "CMYK"])
def test_colors_of_every_kind_become_rgb(tmp_path: Path, mode: str) -> None:
    image, seen = picture_of(mode)
    image.save(tmp_path / "rgb.png", "TIFF" if mode == "CMYK" else "PNG")
    picture = read_rgb(tmp_path / "rgb.png")
    assert picture.dtype == np.uint8 and picture.shape == (HEIGHT, WIDTH, 3)
    assert np.abs(picture.astype(int) - seen).max() <= 1


def deep_png(values: np.ndarray) -> bytes:
    """A PNG (H, W, 3) with 16 bits per color, which PIL does not write."""
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in values)

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", values.shape[1], values.shape[0], 16, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def test_colors_of_16_bits(tmp_path: Path) -> None:
    (tmp_path / "rgb.png").write_bytes(deep_png(gradient().astype(np.uint16) * 257))
    np.testing.assert_array_equal(read_rgb(tmp_path / "rgb.png"), gradient())


def test_grey_of_16_bits_is_rounded_from_black_to_white(tmp_path: Path) -> None:
    Image.fromarray(np.tile(np.array([0, 128, 129, 65535], np.uint16), (HEIGHT, WIDTH // 4))).save(tmp_path / "rgb.png")
    np.testing.assert_array_equal(read_rgb(tmp_path / "rgb.png")[0, :4, 0], [0, 0, 1, 255])


@pytest.mark.parametrize("mode", ["8 bits", "16 bits", "palette", "8-bit TIFF"])
def test_masks_keep_their_values(tmp_path: Path, mode: str) -> None:
    image = Image.fromarray(masks() if mode == "16 bits" else masks().astype(np.uint8))
    if mode == "palette":
        image.putpalette(list(range(255, -1, -1)) * 3)
    image.save(tmp_path / "masks.png", "TIFF" if "TIFF" in mode else "PNG")
    np.testing.assert_array_equal(read_masks(tmp_path / "masks.png"), masks())


@pytest.mark.parametrize(
    ("depth", "said"),
    [
        (np.full((HEIGHT, WIDTH), 2.5, np.float32), False),
        (np.full((HEIGHT, WIDTH), 2.5), False),
        (np.full((HEIGHT, WIDTH), 2.5, np.float16), False),
        (np.full((HEIGHT, WIDTH), 2500, np.uint16), True),
        (np.full((HEIGHT, WIDTH), 2500, np.int64), True),
        (np.full((HEIGHT, WIDTH), 2500.0, np.float32), True),
    ],
    ids=["float32", "float64", "float16", "uint16 mm", "int64 mm", "float mm"],
)
def test_depth_is_metres_or_millimetres(
    bench: Bench, depth: np.ndarray, said: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    depth = depth.copy()
    depth[0, 0] = 0
    np.savez(bench.root / "input/depth.npz", depth=depth)
    read = read_scene_input(bench.root / "input").depth
    assert read.dtype == np.float32 and read[0, 0] == 0 and np.allclose(read[1:], 2.5)
    lines = capsys.readouterr().out.splitlines()
    assert ["depth.npz: depth is in millimetres" in line for line in lines] == ([True] if said else [])


def test_unknown_depth_is_zero(bench: Bench) -> None:
    depth = np.full((HEIGHT, WIDTH), 2.5, np.float32)
    depth[0, :4] = np.nan, np.inf, -1, 5000
    np.savez(bench.root / "input/depth.npz", depth=depth)
    assert read_scene_input(bench.root / "input").depth[0, :5].tolist() == [0, 0, 0, 0, 2.5]


def test_values_without_a_name_are_said(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    values = masks()
    values[0, 0] = 77
    Image.fromarray(values).save(bench.root / "input/masks.png")
    read_scene_input(bench.root / "input")
    assert capsys.readouterr().out.endswith("annotations.json does not name the mask values 77: they are not used\n")


# what cannot


def png(array: np.ndarray, form: str = "PNG", **options: object) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(array).save(buffer, form, **options)
    return buffer.getvalue()


def huge_header(width: int, height: int) -> bytes:
    """A PNG of a few bytes that says it is enormous."""
    data = png(gradient())
    header = struct.pack(">II", width, height) + data[24:29]
    return data[:16] + header + struct.pack(">I", zlib.crc32(b"IHDR" + header)) + data[33:]


RGB = {
    "empty": (b"", "not a readable image"),
    "text": (b"a picture", "not a readable image"),
    "cut": (png(gradient())[:80], "not a readable image"),
    "cut in the header": (png(gradient())[:20], "not a readable image"),
    "cut JPEG": (png(gradient(), "JPEG")[:300], "not a readable image"),
    "flipped bytes": (png(gradient())[:50] + bytes(20) + png(gradient())[70:], "not a readable image"),
    "PostScript": (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 48 36\n", "not a readable image"),
    "bomb": (huge_header(60_000, 60_000), "too many pixels"),
    "large": (huge_header(9000, 9000), "too large. Fix: make it smaller, at most 7745x7745"),
    "no side": (huge_header(0, 36), "rgb.png"),
    "tiny": (png(gradient()[:4, :4]), "too small"),
    "float": (png(np.ones((HEIGHT, WIDTH), np.float32), "TIFF"), "float pixels"),
    "32 bits": (png(np.full((HEIGHT, WIDTH), 10**6, np.int32), "TIFF"), "32-bit pixels"),
    "other size": (png(gradient()[:30]), "is 48x30 pixels, but camera.json says 48x36"),
    "turned": (png(np.rot90(gradient()).copy()), "is 36x48 pixels, but camera.json says 48x36. It is turned"),
    "turned by EXIF": (png(gradient(), "JPEG", exif=exif(6)), "It is turned by a quarter"),
    "broken EXIF": (png(gradient(), "JPEG", exif=b"Exif\0\0MM\0*\xff\xff\xff\xff"), None),
}


@pytest.mark.parametrize("case", list(RGB))
def test_a_picture_that_is_none(bench: Bench, case: str) -> None:
    data, words = RGB[case]
    (bench.root / "input/rgb.png").write_bytes(data)
    if words is None:  # EXIF data that say nothing turn nothing
        assert main(["camera", str(bench.path("camera"))]) == 0
        return
    bench.refused("camera", "rgb.png", words)
    (bench.root / "extraction/rgb.png").write_bytes(data)
    with pytest.raises(InputError, match=r"rgb\.png"):
        SceneObjects(bench.root / "extraction/objects.json", bench.root / "extraction/rgb.png")


MASKS = {
    "empty": (b"", "not a readable image"),
    "cut": (png(masks())[:90], "not a readable image"),
    "color": (png(np.dstack([masks()] * 3).astype(np.uint8)), "3 channels"),
    "alpha": (png(np.dstack([masks()] * 4).astype(np.uint8)), "4 channels"),
    "float": (png(masks().astype(np.float32), "TIFF"), "float pixels"),
    "JPEG": (png(masks().astype(np.uint8), "JPEG"), "is a JPEG"),
    "32 bits": (png(masks().astype(np.int32) + 10**6, "TIFF"), "holds the value"),
    "other size": (png(masks()[:30]), "48x30"),
    "nothing": (png(np.zeros_like(masks())), "shows no object"),
    "other values": (png(masks() + 100), "shows no object"),
}


@pytest.mark.parametrize("case", list(MASKS))
def test_masks_that_are_none(bench: Bench, case: str) -> None:
    data, words = MASKS[case]
    (bench.root / "input/masks.png").write_bytes(data)
    with pytest.raises(InputError, match=r"masks\.png") as error:
        read_scene_input(bench.root / "input")
    assert words in str(error.value)
    if case != "other size":  # annotations.json alone does not know the size
        bench.refused("annotations", "masks.png", words)


def npz(**arrays: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


SHAPE = (HEIGHT, WIDTH)
DEPTH = {
    "empty": (b"", "no readable npz"),
    "text": (b"depth", "no readable npz"),
    "cut": (npz(depth=np.ones(SHAPE))[:300], "no readable npz"),
    "cut in the middle": (npz(depth=np.ones(SHAPE))[:-900], "no readable npz"),
    "npy": (b"\x93NUMPY\x01\x00", "no readable npz"),
    "no depth": (npz(z=np.ones(SHAPE)), "no array named 'depth'"),
    "pickled": (npz(depth=np.array([{}], dtype=object)), "no readable npz"),
    "text inside": (npz(depth=np.full(SHAPE, "far")), "depth: has type"),
    "complex": (npz(depth=np.ones(SHAPE, complex)), "depth: has type"),
    "bool": (npz(depth=np.ones(SHAPE, bool)), "depth: has type"),
    "three axes": (npz(depth=np.ones((*SHAPE, 1))), "depth: has shape"),
    "no pixels": (npz(depth=np.ones((0, 0))), "depth: has shape"),
    "other size": (npz(depth=np.ones((30, WIDTH))), "is 48x30 pixels"),
    "turned": (npz(depth=np.ones((WIDTH, HEIGHT))), "It is turned"),
    "all NaN": (npz(depth=np.full(SHAPE, np.nan)), "no value is known"),
    "all zero": (npz(depth=np.zeros(SHAPE)), "no value is known"),
    "all infinite": (npz(depth=np.full(SHAPE, np.inf)), "no value is known"),
    "centimetres": (npz(depth=np.full(SHAPE, 250.0)), "median 250, which is neither"),
    "whole metres": (npz(depth=np.full(SHAPE, 3, np.uint16)), "no value above 3"),
    "8 bits": (npz(depth=np.full(SHAPE, 200, np.uint8)), "has 8 bits"),
    "bytes": (npz(depth=np.full(SHAPE, 200, np.uint16)), "no value above 200: bytes"),
    "micrometres": (npz(depth=np.full(SHAPE, 2.5e6)), "which is neither"),
    "share of one": (npz(depth=np.full(SHAPE, 0.02)), "which is neither"),
    "exact of many": (npz(depth=np.ones(SHAPE), exact=np.ones(3, bool)), "exact: has type"),
    "exact as text": (npz(depth=np.ones(SHAPE), exact=np.array("yes")), "exact: has type"),
}


@pytest.mark.parametrize("case", list(DEPTH))
def test_depth_that_is_none(bench: Bench, case: str) -> None:
    data, words = DEPTH[case]
    (bench.root / "input/depth.npz").write_bytes(data)
    bench.refused("camera", "depth.npz", words)


@pytest.mark.parametrize("name", ["rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json"])
@pytest.mark.parametrize("how", ["missing", "a folder"])
def test_a_file_that_is_not_there(bench: Bench, name: str, how: str) -> None:
    (bench.root / "input" / name).unlink()
    if how == "a folder":
        (bench.root / "input" / name).mkdir()
    before = contents(bench.root)
    with pytest.raises(InputError, match=name):
        read_scene_input(bench.root / "input")
    assert contents(bench.root) == before


def test_depth_as_a_picture_gets_the_mend(bench: Bench) -> None:
    (bench.root / "input/depth.npz").unlink()
    Image.fromarray(np.full(SHAPE, 2500, np.uint16)).save(bench.root / "input/depth.png")
    bench.refused("camera", "there is a depth.png", "np.savez")
