"""Masks whose numbers have names in another file: YOLO's text, segment-anything's outlines, arrays; their faults."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.perception.read.frame import Labelled
from roomkin.stages.perception.read.mask_files import read_labelled
from tests.refusals import refused

WIDTH, HEIGHT = 64, 48
BOX, INNER = np.zeros((2, HEIGHT, WIDTH), bool)
BOX[10:31, 20:41] = True
INNER[15:21, 24:31] = True
CORNERS = [[20, 10], [40, 10], [40, 30], [20, 30]]
INSIDE = [[24, 15], [30, 15], [30, 20], [24, 20]]
NAMES = {0: "table", 1: "mug"}


def share(corners: list[list[int]]) -> str:
    return " ".join(f"{x / WIDTH:.6f} {y / HEIGHT:.6f}" for x, y in corners)


def read(path: Path, names: object = NAMES) -> Labelled:
    labels = None
    if names is not None:
        labels = path.with_name("names.json")
        labels.write_text(json.dumps(names))
    return read_labelled(path, labels, WIDTH, HEIGHT, "rgb.png")


def of(found: Labelled, label: str) -> NDArray[np.bool_]:
    return np.isin(found.values, [value for value, name in found.labels.items() if name == label])


def runs(mask: NDArray[np.bool_]) -> dict[str, Any]:
    bits = np.concatenate([[0], mask.T.ravel().astype(int), [0]])
    counts = np.diff(np.concatenate([[0], np.flatnonzero(np.diff(bits)), [mask.size]]))
    return {"size": [HEIGHT, WIDTH], "counts": counts.astype(int).tolist()}


def yolo(path: Path) -> Path:
    file = path / "rgb.txt"
    file.write_text(f"0 {share(CORNERS)}\n1 {share(INSIDE)}\n")
    return file


def folder(path: Path) -> Path:
    (path / "masks").mkdir()
    for number, mask in enumerate((BOX, INNER)):
        Image.fromarray(mask.astype(np.uint8) * 255).save(path / f"masks/{number}.png")
    (path / "masks/metadata.csv").write_text("id,area\n0,441\n1,42\n")
    return path / "masks"


def listed(path: Path) -> Path:
    about = {"predicted_iou": 0.9, "stability_score": 1.0}
    found = [{"segmentation": runs(mask), "area": int(mask.sum()), **about} for mask in (BOX, INNER)]
    (path / "rgb.json").write_text(json.dumps(found))
    return path / "rgb.json"


def sa1b(path: Path) -> Path:
    items = json.loads(listed(path).read_text())
    image = {"image_id": 7, "width": WIDTH, "height": HEIGHT, "file_name": "rgb.png"}
    (path / "rgb.json").write_text(json.dumps({"image": image, "annotations": items}))
    return path / "rgb.json"


def written_out(path: Path) -> Path:
    (path / "rgb.json").write_text(json.dumps([{"segmentation": mask.tolist()} for mask in (BOX, INNER)]))
    return path / "rgb.json"


KINDS = [yolo, folder, listed, sa1b, written_out]


@pytest.mark.parametrize("kind", KINDS)
def test_each_outline_has_the_name_of_its_number(tmp_path: Path, kind: Callable[[Path], Path]) -> None:
    found = read(kind(tmp_path))
    assert np.array_equal(of(found, "mug"), INNER), "the smaller one lies on top"
    assert np.array_equal(of(found, "table"), BOX & ~INNER)


@pytest.mark.parametrize("kind", KINDS)
def test_outlines_without_a_name(
    tmp_path: Path, kind: Callable[[Path], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path = kind(tmp_path)
    with refused("E-MASKS-NAMES", f"{path}: has 2 ", " without names. Fix: --labels with "):
        read(path, None)
    with refused("E-MASKS-NAMES", "names.json: names none of the ", str(path)):
        read(path, {7: "mug"})
    assert read(path, {1: "mug"}).labels == {1: "mug"}
    assert f"{path}: without a name, left out: " in capsys.readouterr().out


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: -len(path.read_bytes()) // 3])


def replace(old: str, new: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return change


def change_one(picture: NDArray[Any]) -> Callable[[Path], None]:
    return lambda path: Image.fromarray(picture.astype(np.uint8)).save(path / "1.png")


def empty(path: Path) -> None:
    for file in path.iterdir() if path.is_dir() else [path]:
        file.unlink() if path.is_dir() else file.write_text("")


FAULTS = [
    (yolo, replace(share(INSIDE), share(INSIDE)[:20]), "E-MASKS-FORMAT", "rgb.txt:2: is no line of YOLO's"),
    (yolo, replace(share(INSIDE), share(INSIDE)[:-9]), "E-MASKS-SHAPE", "line 2, 'mug', has 7 numbers"),
    (yolo, replace(share(INSIDE), "24 15 30 15 30 20"), "E-MASKS-SHAPE", "line 2, 'mug', has a corner at 30"),
    (yolo, replace("1 0", "mug 0"), "E-MASKS-FORMAT", "rgb.txt:2: is no line of YOLO's: 'mug 0"),
    (yolo, replace("1 0", "-1 0"), "E-MASKS-FORMAT", "rgb.txt:2: is no line of YOLO's"),
    (yolo, replace("1 0", "nan 0"), "E-MASKS-FORMAT", "rgb.txt:2: is no line of YOLO's"),
    (yolo, empty, "E-MASKS-EMPTY", "it has no lines"),
    (yolo, lambda path: path.write_bytes(b"\xe9"), "E-FILE-ENCODING", "UTF-8"),
    (folder, change_one(INNER[:30]), "E-MASKS-SIZE", "1.png: is of 64x30 pixels, but the picture has 64x48"),
    (folder, change_one(np.arange(HEIGHT * WIDTH).reshape(INNER.shape) % 9), "E-MASKS-FORMAT", "1.png: has 9 diff"),
    (folder, change_one(np.dstack([INNER] * 3)), "E-MASK-FORMAT", "1.png: has 3 channels"),
    (folder, lambda path: cut(path / "1.png"), "E-IMAGE-UNREADABLE", "1.png"),
    (folder, lambda path: (path / "1.png").rename(path / "mug.png"), "E-MASKS-FORMAT", "1 of which have a number"),
    (folder, lambda path: (path / "1.png").rename(path / "00.png"), "E-MASKS-FORMAT", "1 of which have a number"),
    (folder, empty, "E-MASKS-FORMAT", "has 0 pictures"),
    (listed, cut, "E-FILE-UNREADABLE", "is no JSON in line 1"),
    (listed, replace("[48, 64]", "[64, 48]"), "E-MASKS-SHAPE", "run lengths of 48x64 pixels"),
    (listed, empty, "E-FILE-UNREADABLE", "is no JSON"),
    (listed, lambda path: path.write_text("[]"), "E-MASKS-FORMAT", "neither COCO"),
    (sa1b, replace('"width": 64', '"width": 65'), "E-MASKS-SIZE", "is of 65x48 pixels"),
    (written_out, replace("[[", "[[true, true], ["), "E-MASKS-SHAPE", "has a mask of 2x49 pixels"),
]


@pytest.mark.parametrize(("kind", "fault", "code", "says"), FAULTS)
def test_faults(
    tmp_path: Path, kind: Callable[[Path], Path], fault: Callable[[Path], Any], code: str, says: str
) -> None:
    path = kind(tmp_path)
    fault(path)
    with refused(code, says) as caught:
        read(path)
    assert ". Fix: " in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", [yolo, folder, listed])
def test_so_many_outlines_as_fill_the_memory_are_refused(
    tmp_path: Path, kind: Callable[[Path], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("roomkin.stages.perception.read.mask_shapes.MAX_BYTES", WIDTH * HEIGHT)
    with refused("E-FILE-LARGE", "has 2 masks of this picture"):
        read(kind(tmp_path))


def test_boxes_of_yolo_are_taken_whole_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "rgb.txt").write_text(f"0 {30 / WIDTH} {20 / HEIGHT} {20 / WIDTH} {20 / HEIGHT}\n")
    assert np.array_equal(of(read(tmp_path / "rgb.txt"), "table"), BOX)
    assert "'table' has no outline, so that all of its box is taken" in capsys.readouterr().out


def test_what_a_network_says_last_is_how_sure_it_is(tmp_path: Path) -> None:
    (tmp_path / "rgb.txt").write_text(f"0 {share(CORNERS)} 0.91\n\n1 {share(INSIDE)} 0.5\n")
    assert np.array_equal(of(read(tmp_path / "rgb.txt"), "mug"), INNER)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("data.yaml", "train: images\nnc: 2\nnames: [table, mug]\n"),
        ("data.yml", "names:\n  0: table\n  1: mug\n"),
        ("classes.txt", "table\nmug\n\n"),
        ("notes.json", '{"categories": [{"id": 0, "name": "table"}, {"id": 1, "name": "mug"}]}'),
        ("mask.json", '[{"value": 0, "label": "table"}, {"value": 1, "label": "mug .", "box": [0, 0, 1, 1]}]'),
        ("mask.json", '{"tags": "mug", "mask": [{"value": 0, "label": "table"}, {"value": 1, "label": "mug"}]}'),
        ("names.json", '["table", "mug"]'),
    ],
)
def test_files_of_names(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    assert read_labelled(yolo(tmp_path), tmp_path / name, WIDTH, HEIGHT, "rgb.png").labels == {1: "table", 2: "mug"}


@pytest.mark.parametrize(
    ("name", "text", "code", "says"),
    [
        ("data.yaml", "names: [table", "E-FILE-UNREADABLE", "no readable file of names"),
        ("data.yaml", "a: &a [1, 1]\nnames: [*a, *a]\n", "E-FILE-UNREADABLE", "aliases"),
        ("data.yaml", f"names: [{'x' * 1_000_001}]", "E-FILE-LARGE", "characters of YAML"),
        ("data.yaml", "", "E-MASKS-NAMES", "holds no names"),
        ("data.yaml", "path: images\n", "E-MASKS-NAMES", "names 'path', which is no value"),
        ("names.json", '{"mug": 1}', "E-MASKS-NAMES", "names 'mug', which is no value"),
        ("names.json", '{"1": "mug"', "E-FILE-UNREADABLE", "is no JSON in line 1"),
        ("names.json", '{"1": 3}', "E-MASKS-NAMES", "has values that are no names"),
        ("names.json", '"mug"', "E-MASKS-NAMES", "holds no names"),
        ("classes.txt", "", "E-MASKS-NAMES", "holds no names"),
        ("names.json", '[{"box": [0, 0, 1, 1]}]', "E-MASKS-NAMES", "names None, which is no value"),
    ],
)
def test_broken_files_of_names(tmp_path: Path, name: str, text: str, code: str, says: str) -> None:
    (tmp_path / name).write_text(text)
    with refused(code, f"{name}: ", says, ". Fix: "):
        read_labelled(yolo(tmp_path), tmp_path / name, WIDTH, HEIGHT, "rgb.png")


VALUES = np.where(INNER, 12, np.where(BOX, 11, 0)).astype(np.int16)
OF_VALUES = {11: "table", 12: "mug"}


@pytest.mark.parametrize(
    ("array", "names"),
    [
        (VALUES, OF_VALUES),
        (VALUES[..., None], OF_VALUES),
        (VALUES[None, ..., None], OF_VALUES),
        (VALUES.astype(np.float32), OF_VALUES),
        (np.where(VALUES == 0, -1, VALUES), OF_VALUES),
        (np.where(VALUES > 0, VALUES.astype(np.int64) + 10**6, 0), {11 + 10**6: "table", 12 + 10**6: "mug"}),
    ],
)
def test_arrays_of_values(tmp_path: Path, array: NDArray[Any], names: dict[int, str]) -> None:
    np.save(tmp_path / "m.npy", array)
    np.savez(tmp_path / "m.npz", masks=array, rgb=np.zeros(3))
    for path in (tmp_path / "m.npy", tmp_path / "m.npz"):
        found = read(path, names)
        assert np.array_equal(of(found, "mug"), INNER) and np.array_equal(of(found, "table"), BOX & ~INNER)


@pytest.mark.parametrize(
    ("array", "code", "says"),
    [
        (VALUES[:, :40], "E-MASKS-SIZE", "is of 40x48 pixels"),
        (np.stack([VALUES, VALUES]), "E-MASKS-FORMAT", "has shape (2, 48, 64)"),
        (VALUES + 0.5, "E-MASKS-FORMAT", "type float64: it is no label image"),
        (np.where(VALUES == 0, np.nan, VALUES), "E-MASKS-FORMAT", "type float64"),
        (np.full(VALUES.shape, "mug"), "E-MASKS-FORMAT", "type <U3"),
        (np.zeros_like(VALUES), "E-MASKS-NAMES", "names none of the values"),
        (np.array([{}]), "E-FILE-UNREADABLE", "m.npy: is no readable array"),  # pickled: it could run code
    ],
)
def test_arrays_that_are_no_masks(tmp_path: Path, array: NDArray[Any], code: str, says: str) -> None:
    np.save(tmp_path / "m.npy", array)
    with refused(code, says):
        read(tmp_path / "m.npy", OF_VALUES)


def test_one_of_several_arrays_is_not_guessed(tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", a=VALUES, b=VALUES)
    with refused("E-ARRAY-MISSING", "holds a, b, and none of them is called masks"):
        read(tmp_path / "m.npz", OF_VALUES)


GROUNDED = [
    {"value": 0, "label": "background"},
    {"value": 1, "label": "table", "logit": 0.5, "box": [20, 10, 40, 30]},
    {"value": 2, "label": "mug", "logit": 0.4, "box": [24, 15, 30, 20]},
]


@pytest.mark.parametrize("data", [GROUNDED, {"tags": "table, mug", "mask": GROUNDED}])
def test_names_of_values_are_read_with_the_picture_beside_them(tmp_path: Path, data: object) -> None:
    (tmp_path / "mask.json").write_text(json.dumps(data))
    Image.new("RGB", (900, 700)).save(tmp_path / "mask.jpg")
    with refused("E-MASKS-FORMAT", "no mask.png beside it has the outlines; a mask.jpg is a drawing", "cv2.imwrite"):
        read(tmp_path / "mask.json", None)
    with refused("E-MASKS-FORMAT", "is a JPEG"):
        read_labelled(tmp_path / "mask.jpg", tmp_path / "mask.json", WIDTH, HEIGHT, "rgb.png")
    Image.fromarray((VALUES - 10).clip(0).astype(np.uint8)).save(tmp_path / "mask.png")
    found = read(tmp_path / "mask.json", None)
    assert np.array_equal(of(found, "mug"), INNER) and np.array_equal(of(found, "table"), BOX & ~INNER)


def roboflow(path: Path, *names: str, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Path:
    """Its COCO file; the box is in the last of the pictures, a mug in the others."""
    images = [{"id": k, "file_name": name, "width": size[0], "height": size[1]} for k, name in enumerate(names)]
    items = [
        {"id": k, "image_id": k, "category_id": 1 + (k == len(names) - 1), "segmentation": [np.ravel(CORNERS).tolist()]}
        for k in range(len(names))
    ]
    kinds = [{"id": 0, "name": "furniture"}, {"id": 1, "name": "mug"}, {"id": 2, "name": "box"}]
    (path / "_annotations.coco.json").write_text(
        json.dumps({"images": images, "annotations": items, "categories": kinds})
    )
    return path / "_annotations.coco.json"


@pytest.mark.parametrize(
    ("exported", "picture"),
    [
        ("rgb_png.rf.a1b2c3d4.jpg", "rgb.png"),
        ("rgb_jpeg.rf.a1b2c3d4.jpg", "rgb.jpeg"),
        ("train/rgb.rf.a1b2c3d4.png", "rgb.png"),
        ("K-che-2_png.rf.a1b2c3d4.jpg", "Küche 2.png"),
        ("rgb_png.rf.a1b2c3d4.jpg", "rgb_png.rf.a1b2c3d4.jpg"),
    ],
)
def test_pictures_that_roboflow_gave_another_name(tmp_path: Path, exported: str, picture: str) -> None:
    path = roboflow(tmp_path, "other_png.rf.0f1e2d3c.jpg", "rgb2_png.rf.0f1e2d3c.jpg", exported)
    assert read_labelled(path, None, WIDTH, HEIGHT, picture).labels == {1: "box"}


def test_what_roboflow_changed_is_told(tmp_path: Path) -> None:
    twice = roboflow(tmp_path, "rgb_png.rf.a1.jpg", "rgb_png.rf.b2.jpg")
    with refused("E-MASKS-PICTURE", "has 2 pictures called rgb.png"):
        read_labelled(twice, None, WIDTH, HEIGHT, "rgb.png")
    with refused("E-MASKS-PICTURE", "has no picture called cup.png"):
        read_labelled(twice, None, WIDTH, HEIGHT, "cup.png")
    stretched = roboflow(tmp_path, "rgb_png.rf.a1.jpg", size=(640, 640))
    with refused("E-MASKS-SIZE", "is of 640x640 pixels, but the picture has 64x48", "without Resize"):
        read_labelled(stretched, None, WIDTH, HEIGHT, "rgb.png")
