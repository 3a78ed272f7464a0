"""Mask files of other tools: every shape is counted; it is used, or named with the reason, or the file is refused."""

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.perception.read.frame import Labelled
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.perception.write import make_annotations
from tests.refusals import refused

WIDTH, HEIGHT = 64, 48
BOX = np.zeros((HEIGHT, WIDTH), bool)
BOX[10:31, 20:41] = True  # x 20 to 40, y 10 to 30
CORNERS = [[20, 10], [40, 10], [40, 30], [20, 30]]
FLAT = [20, 10, 40, 10, 40, 30, 20, 30]
CUP = [[50, 5], [60, 5], [60, 15], [50, 15]]


def read(tmp_path: Path, data: object) -> Labelled:
    (tmp_path / "m.json").write_text(json.dumps(data))
    return read_labelled(tmp_path / "m.json", None, WIDTH, HEIGHT, "rgb.png")


def labelme(*shapes: dict[str, Any]) -> dict[str, Any]:
    return {"imageWidth": WIDTH, "imageHeight": HEIGHT, "imagePath": "rgb.png", "shapes": list(shapes)}


def shape(label: str, kind: str, points: list[list[float]], **more: Any) -> dict[str, Any]:
    return {"label": label, "shape_type": kind, "points": points, **more}


def png(mask: NDArray[np.bool_]) -> str:
    file = io.BytesIO()
    Image.fromarray(mask).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()


def coco(*annotations: dict[str, Any], **more: Any) -> dict[str, Any]:
    images = [{"id": 1, "file_name": "rgb.png", "width": WIDTH, "height": HEIGHT}]
    categories = [{"id": 1, "name": "box"}, {"id": 2, "name": "cup"}]
    told = [{"id": n, "image_id": 1, "category_id": 1, **item} for n, item in enumerate(annotations)]
    return {"images": images, "categories": categories, "annotations": told, **more}


def runs(mask: NDArray[np.bool_]) -> list[int]:
    """Run lengths column by column, as COCO counts them."""
    bits = np.concatenate([[0], mask.T.ravel().astype(int), [0]])
    edges = np.flatnonzero(np.diff(bits))
    return np.diff(np.concatenate([[0], edges, [mask.size]])).astype(int).tolist()


def area(found: Labelled, label: str) -> NDArray[np.bool_]:
    return np.isin(found.values, [value for value, name in found.labels.items() if name == label])


@pytest.mark.parametrize(
    "drawn",
    [
        shape("box", "polygon", CORNERS),
        shape("box", "", CORNERS),
        shape("box", "rectangle", [[20, 10], [40, 30]]),
        shape("box", "rectangle", [[40, 30], [20, 10]]),
        shape("box", "rectangle", CORNERS),
        shape("box", "rotation", CORNERS, direction=1.2),
        shape("box", "oriented_rectangle", CORNERS),
        shape("box", "mask", [[20, 10], [40, 30]], mask=png(BOX[10:31, 20:41])),
    ],
)
def test_shapes_of_labelme(tmp_path: Path, drawn: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    found = read(tmp_path, labelme(drawn))
    assert np.array_equal(area(found, "box"), BOX)
    assert capsys.readouterr().out == f"{tmp_path / 'm.json'}: 1 shapes, 1 used\n"


def test_a_circle_and_a_mask_that_leaves_the_picture(tmp_path: Path) -> None:
    cut = shape("cut", "mask", [[-3, 45], [4, 52]], mask=png(np.ones((8, 8), bool)))
    found = read(tmp_path, labelme(shape("plate", "circle", [[30, 20], [30, 30]]), cut))
    assert area(found, "plate").sum() == pytest.approx(np.pi * 10.5**2, rel=0.03)  # the border is in it
    assert area(found, "cut").sum() == 3 * 5 and area(found, "cut")[45:, :5].all()


def test_what_is_not_used_is_counted_and_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inner = shape("tray", "rectangle", [[22, 12], [38, 28]])
    shapes = [
        shape("box", "polygon", CORNERS),
        shape("edge", "line", [[0, 0], [9, 9]]),
        shape("edge", "linestrip", [[0, 0], [9, 9], [3, 2]]),
        shape("tip", "point", [[4, 4]]),
        shape("cup", "polygon", [[70, 50], [80, 50], [80, 60]]),  # beside the picture
        shape("lid", "mask", [[20, 10], [40, 30]]),
        inner,
        {**inner, "label": "cloth"},
    ]
    found = read(tmp_path, labelme(*shapes))
    assert sorted(found.labels.values()) == ["box", "cloth"]
    said = capsys.readouterr().out
    assert "8 shapes, 2 used: " in said
    for words in (
        "'edge' (2) is a line, no area", "'tip' is a point, no area", "'cup' has no pixels",
        "'lid' is a mask without its pixels", "'tray' is covered by others",
    ):  # fmt: skip
        assert words in said


def test_a_group_is_one_object_and_its_shapes_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parts = [shape("lamp", "polygon", corners, group_id=3) for corners in (CORNERS, CUP)]
    found = read(tmp_path, labelme(*parts, shape("lamp", "rectangle", [[2, 2], [8, 8]])))
    assert (
        list(found.labels.values()) == ["lamp", "lamp"] and area(found, "lamp")[12, 25] and area(found, "lamp")[8, 55]
    )
    assert "3 shapes, 3 used, as 2 objects" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("drawn", "says"),
    [
        (shape("cup", "ellipse", [[20, 10], [40, 30]]), "'ellipse' of 2 points"),
        (shape("cup", "cuboid", CORNERS * 2), "'cuboid' of 8 points"),
        (shape("cup", "rectangle", [[20, 10], [40, 30]], rotation=30), "turned"),
        (shape("cup", "polygon", [[0.2, 0.2], [0.8, 0.2], [0.5, 0.9]]), "shares of the picture"),
        (shape("cup", "polygon", [[20, 10], [40, 10], [90_000, 30]]), "far outside"),
        (shape("cup", "polygon", [[20, 10], [40, 10], [float("nan"), 30]]), "no pairs"),
        (shape("cup", "mask", [[20, 10], [40, 30]], mask=png(BOX)), "box of another size"),
        (shape("cup", "mask", [[20, 10], [40, 30]], mask="bm90IGEgcG5n"), "cannot be decoded"),
    ],
)
def test_a_shape_that_cannot_be_read_is_refused_by_its_name(tmp_path: Path, drawn: dict[str, Any], says: str) -> None:
    with refused("E-MASKS-SHAPE", "shape 2, 'cup', ", says):
        read(tmp_path, labelme(shape("box", "polygon", CORNERS), drawn))


def pack(counts: list[int]) -> str:
    """Run lengths as COCO's tools write them."""
    text = ""
    for number, count in enumerate(counts):
        value, more = count - (counts[number - 2] if number > 2 else 0), True
        while more:
            bits, value = value & 31, value >> 5
            more = not ((value == 0 and not bits & 16) or (value == -1 and bits & 16))
            text += chr((bits | 32 if more else bits) + 48)
    return text


@pytest.mark.parametrize(
    "segmentation",
    [
        [FLAT],
        FLAT,
        CORNERS,
        [CORNERS],
        {"size": [HEIGHT, WIDTH], "counts": runs(BOX)},
        [{"size": [HEIGHT, WIDTH], "counts": runs(BOX)}],
        {"counts": runs(BOX)},
        {"size": [HEIGHT, WIDTH], "counts": pack(runs(BOX))},
        [runs(BOX)],
        runs(BOX),
    ],
)
def test_outlines_of_coco_in_every_form(tmp_path: Path, segmentation: Any) -> None:
    found = read(tmp_path, coco({"segmentation": segmentation, "bbox": [20, 10, 21, 21]}))
    assert np.array_equal(area(found, "box"), BOX)


def test_annotations_of_coco_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cup = {"category_id": 2}
    found = read(
        tmp_path,
        coco(
            {"segmentation": [FLAT, [2, 2, 6, 2, 6, 6, 2, 6]]},
            {**cup, "segmentation": [], "bbox": [50, 5, 10, 10]},
            {**cup, "bbox": [0, 0, 0, 0]},
            {**cup, "segmentation": [[]]},
            {"segmentation": [[44, 2, 48, 2, 48, 6, 44, 6]], "iscrowd": 1},
            {"segmentation": [FLAT], "image_id": 2},
        ),
    )
    assert area(found, "box")[4, 4] and area(found, "box")[20, 30] and area(found, "cup")[10, 55]
    said = capsys.readouterr().out
    assert "5 annotations, 3 used: " in said
    for words in ("'cup' has no outline, so that all of its box", "'cup' has no outline,", "'cup' has no pixels",
                  "'box' is marked as a crowd"):  # fmt: skip
        assert words in said


@pytest.mark.parametrize(
    ("item", "code", "says"),
    [
        ({"segmentation": {"size": [WIDTH, HEIGHT], "counts": runs(BOX)}}, "SHAPE", f"{HEIGHT}x{WIDTH} pixels"),
        ({"segmentation": {"counts": [5, 5]}}, "SHAPE", "of 10 pixels"),
        ({"segmentation": {"counts": "eJwLy"}}, "SHAPE", "run lengths"),
        ({"segmentation": {"counts": "o" * 1000}}, "SHAPE", ""),  # they never end
        ({"segmentation": [[*FLAT, 1]]}, "SHAPE", "9 numbers"),
        ({"segmentation": [[0, *runs(BOX)[:-1], 7]]}, "SHAPE", ""),  # run lengths of something else
        ({"segmentation": [FLAT], "bbox": [1, 1, 5, 5]}, "SHAPE", "elsewhere than its bbox"),
        ({"segmentation": "eJx"}, "SHAPE", "neither polygons nor run lengths"),
        (
            {"segmentation": [], "bbox": [20, 10, 21, 21], "attributes": {"rotation": 30.0}},
            "SHAPE",
            "box that is turned",
        ),
        ({"segmentation": [FLAT], "category_id": 9}, "NAMES", "category 9"),
    ],
)
def test_an_annotation_that_cannot_be_read_is_refused(
    tmp_path: Path, item: dict[str, Any], code: str, says: str
) -> None:
    with refused(f"E-MASKS-{code}", "annotation 1", says):
        read(tmp_path, coco(item))


def test_which_of_several_pictures_is_meant_must_be_clear(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    item = {"segmentation": [FLAT]}
    twice = [{"id": n, "file_name": f"{n}/rgb.png"} for n in (1, 2)]
    for images in (twice, [{"id": 1, "file_name": "a.png"}, {"id": 2, "file_name": "b.png"}]):
        with refused("E-MASKS-PICTURE"):
            read(tmp_path, coco(item, images=images))
    with refused("E-MASKS-PICTURE"):
        read(tmp_path, coco(item, {**item, "image_id": 2}, images=[]))
    assert area(read(tmp_path, coco(item, images=[])), "box").any()
    read(tmp_path, coco(item, images=[{"id": 1, "file_name": "other.png"}]))
    assert "is of other.png" in capsys.readouterr().out


@pytest.mark.parametrize(
    "data",
    [
        {"annotations": [{"image_id": 1, "segments_info": []}], "categories": []},
        {"images": [], "annotations": []},
        {"what": 1},
    ],
)
def test_files_of_other_tools_are_refused(tmp_path: Path, data: object) -> None:
    with refused("E-MASKS-FORMAT", "neither COCO", "nor labelme"):
        read(tmp_path, data)


@pytest.mark.parametrize(
    ("name", "code"), [("m.xml", "E-IMAGE-UNREADABLE"), ("m.npz", "E-FILE-UNREADABLE"), ("", "E-MASKS-FORMAT")]
)
def test_what_is_no_file_of_masks_at_all(tmp_path: Path, name: str, code: str) -> None:
    if name:
        (tmp_path / name).write_text("<annotation/>")
    with refused(code):
        read_labelled(tmp_path / name, None, WIDTH, HEIGHT, "rgb.png")


def image(tmp_path: Path, picture: Image.Image, names: dict[str, str]) -> Labelled:
    picture.save(tmp_path / "m.png")
    (tmp_path / "names.json").write_text(json.dumps(names))
    return read_labelled(tmp_path / "m.png", tmp_path / "names.json", WIDTH, HEIGHT, "rgb.png")


def test_label_images_tell_what_has_no_name_and_what_no_pixels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = BOX.astype(np.uint8) * 3
    values[0, :5] = 7
    found = image(tmp_path, Image.fromarray(values), {"0": "_background_", "3": "box", "4": "cup"})
    assert found.labels == {3: "box"} and np.array_equal(found.values == 3, BOX)
    said = capsys.readouterr().out
    assert "left out: 7 (5 pixels)" in said and "2 names, 1 used: 'cup' has no pixels" in said


def test_of_many_values_without_a_name_the_first_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for last, more in ((8, ""), (10, " and 2 more")):
        values = BOX.astype(np.uint8)
        values[0, 1 : last + 1] = np.arange(last) + 2
        image(tmp_path, Image.fromarray(values), {"1": "box"})
        assert f"9 (1 pixels){more}\n" in capsys.readouterr().out
    with refused("E-MASKS-NAMES", "has 11 values without names"):
        read_labelled(tmp_path / "m.png", None, WIDTH, HEIGHT, "rgb.png")


def test_colors_of_a_palette_and_what_is_transparent(tmp_path: Path) -> None:
    indexed = Image.fromarray(BOX.astype(np.uint8) * 2, "P")
    indexed.putpalette([0, 0, 0, 9, 9, 9, 255, 0, 0])
    assert np.array_equal(area(image(tmp_path, indexed, {"#ff0000": "box"}), "box"), BOX)
    assert np.array_equal(area(image(tmp_path, indexed, {"2": "box"}), "box"), BOX)
    grey = Image.fromarray(np.dstack([BOX.astype(np.uint8) * 2] * 3))
    assert np.array_equal(area(image(tmp_path, grey, {"2": "box"}), "box"), BOX)
    red = np.zeros((HEIGHT, WIDTH, 4), np.uint8)
    red[...] = 255, 0, 0, 0
    red[BOX, 3] = 255
    assert np.array_equal(area(image(tmp_path, Image.fromarray(red), {"#ff0000": "box"}), "box"), BOX)


def test_value_0_is_nothing_and_cannot_be_an_object(tmp_path: Path) -> None:
    with refused("E-MASKS-NAMES", "the value 0 'mug'"):
        image(tmp_path, Image.fromarray(BOX.astype(np.uint8)), {"0": "mug", "1": "box"})


@pytest.mark.parametrize("label", ["x" * 300, "\x1b[31mred", "two\nlines"])
def test_labels_are_words(tmp_path: Path, label: str) -> None:
    found = read(tmp_path, labelme(shape(label, "polygon", CORNERS)))
    with refused("E-MASKS-NAMES") as caught:
        make_annotations(found)
    assert str(caught.value).isprintable()


def test_names_of_things_in_other_languages_are_ours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Others, and those of surfaces, stay as they were typed."""
    names = {1: "стол", 2: "椅子", 3: "Wand", 4: "office chair", 5: "стремянка"}
    Image.fromarray(np.repeat([[1, 2, 3, 4, 5] * 4], 16, axis=0).astype(np.uint8)).save(tmp_path / "m.png")
    (tmp_path / "l.json").write_text(json.dumps(names), encoding="utf-8")
    read = read_labelled(tmp_path / "m.png", tmp_path / "l.json", 20, 16, "")
    assert read.labels == {**names, 1: "table", 2: "chair"}
    assert "names read as ours: стол: table, 椅子: chair\n" in capsys.readouterr().out
