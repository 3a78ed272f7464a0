"""Words of others for floor and wall, depth of another view, values in two places, files paired by their numbers."""

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.read import mask_shapes
from roomkin.stages.perception.read.frame import Frame, Labelled, doubt_depth, surface_of
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.perception.read.mask_pieces import doubt_surfaces, split_values
from roomkin.stages.perception.read.views import find_view, list_frames
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, trace

LEFT = UprightBox([2.4, 0.7, 0.2], [0.3, 0.35, 0.4], 0.3)
RIGHT = UprightBox([2.2, -0.3, 0.3], [0.3, 0.4, 0.6], 0.1)
FRONT = UprightBox([1.9, 0.2, 0.5], [0.1, 1.2, 1.0], 0.0)


@pytest.mark.parametrize(
    ("label", "surface"),
    [
        *(
            (word, "floor")
            for word in ("floor, flooring", "floor-other-merged", "Fußboden", "wooden floor", "地板", "пол")
        ),
        *(
            (word, "wall")
            for word in ("wall-brick", "Wand links", "mur blanc", "left_wall_2", "wall behind the sofa", "壁")
        ),
        *((word, "nothing") for word in ("ceiling-tile", "_background_", "", "天花板")),
        *(
            (word, "")
            for word in ("floor lamp", "wall cabinet", "rug, carpet, carpeting", "picture on wall", "Wandschrank")
        ),
        *((word, "") for word in ("floor mat", "lampe de sol", "床", "2")),
    ],
)
def test_floor_and_wall_in_the_words_of_others(label: str, surface: str) -> None:
    assert surface_of(label) == surface


def make_frame(boxes: list[UprightBox], labels: dict[int, str], values: dict[int, int] | None = None) -> Frame:
    depth, masks = trace(boxes)
    for old, new in (values or {}).items():
        masks[masks == old] = new
    return Frame(np.zeros((HEIGHT, WIDTH, 3), np.uint8), depth, INTRINSICS, Labelled(masks, labels))


def test_a_surface_without_a_known_word_is_doubted_by_its_shape() -> None:
    labels = {FLOOR: "qwe", WALL: "asd", OBJECT: "box", OBJECT + 1: "crate"}
    doubted = doubt_surfaces(make_frame([LEFT, RIGHT], labels)).masks
    assert doubted is not None and set(doubted.doubts) == {FLOOR, WALL}
    assert doubted.doubts[WALL] == [DoubtKind.SURFACE.of()]


def test_what_lies_in_a_named_surface_is_a_thing() -> None:
    frame = make_frame([], {FLOOR: "floor", WALL: "wall", OBJECT: "picture"})
    assert frame.masks is not None
    frame.masks.values[40:120, 100:300] = OBJECT
    doubted = doubt_surfaces(frame).masks
    assert doubted is not None and not doubted.doubts


@pytest.mark.filterwarnings("error")
def test_a_named_surface_without_pixels_has_no_thing_in_it() -> None:
    doubted = doubt_surfaces(make_frame([LEFT, RIGHT], {FLOOR: "qwe", WALL: "wall"}, {WALL: 0})).masks
    assert doubted is not None and set(doubted.doubts) == {FLOOR}


def paint(masks: NDArray[np.uint16], seed: int = 0) -> NDArray[np.uint8]:
    """A picture (H, W, 3) of masks, each in a color of its own, with a camera's noise."""
    rng = np.random.default_rng(seed)
    colors = rng.integers(40, 215, (OBJECT + 9, 3))
    return np.clip(colors[masks] + rng.normal(0, 4, (*masks.shape, 3)), 0, 255).astype(np.uint8)


def show(depth: NDArray[np.float32], times: float, right: int = 0) -> NDArray[np.float32]:
    """Depth so many times larger around the center, and moved; unknown where nothing is left."""
    center = (np.array(depth.shape[::-1]) - 1) / 2 * (1 - times)
    matrix = np.array([[times, 0, center[0] + right], [0, times, center[1]]])
    return np.asarray(cv2.warpAffine(depth, matrix, depth.shape[::-1], flags=cv2.INTER_NEAREST))


@pytest.mark.parametrize("boxes", [[LEFT, RIGHT], [LEFT, RIGHT, FRONT], [FRONT]])
def test_depth_that_lies_on_its_picture_is_not_doubted(boxes: list[UprightBox]) -> None:
    depth, masks = trace(boxes)
    noise = np.random.default_rng(1).normal(0, 0.003, depth.shape) * depth**2
    worn = np.where(np.random.default_rng(2).random(depth.shape) < 0.1, 0, depth + noise).astype(np.float32)
    for one in (depth, worn, show(depth, 1.0, 3)):
        assert doubt_depth(one, paint(masks)) == "" and doubt_depth(one, paint(masks), masks) == ""


@pytest.mark.parametrize(("axes", "how"), [((1,), "left to right"), ((0,), "upside down"), ((0, 1), "180 degrees")])
def test_mirrored_depth_is_refused(axes: tuple[int, ...], how: str) -> None:
    depth, masks = trace([LEFT, RIGHT], wall=False)
    with refused("E-DEPTH-MIRRORED", how):
        doubt_depth(np.flip(depth, axes).copy(), paint(masks))


@pytest.mark.parametrize("masked", [True, False])
@pytest.mark.parametrize(
    ("times", "says"), [(0.72, "1.3"), (0.85, "1.1"), (0.93, "1.0"), (1.2, "1.2"), (1.36, "1.3"), (1.45, "1.4")]
)
def test_depth_of_another_lens_is_refused_and_how_large_it_should_be_is_said(
    times: float, says: str, masked: bool
) -> None:
    depth, masks = trace([LEFT, RIGHT])
    with refused("E-DEPTH-UNALIGNED", f"shown {says}", "larger" if times < 1 else "smaller", "align depth"):
        doubt_depth(show(depth, times, 6), paint(masks), masks if masked else None)


def test_outlines_tell_where_the_picture_shows_nothing() -> None:
    depth, masks = trace([LEFT, RIGHT])
    blank = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    assert doubt_depth(show(depth, 0.72), blank) == ""
    assert "depth in doubt: it fits if it is shown 1.38 times larger" in doubt_depth(show(depth, 0.72), blank, masks)


def test_outlines_that_are_off_on_a_picture_of_nothing_say_nothing() -> None:
    depth, masks = trace([LEFT, RIGHT])
    things = cv2.dilate(np.where(masks >= OBJECT, masks, 0).astype(np.uint16), np.ones((25, 25)))
    assert doubt_depth(depth, np.full((HEIGHT, WIDTH, 3), 90, np.uint8), things) == ""


def test_depth_without_steps_says_nothing() -> None:
    _, masks = trace([LEFT, RIGHT])
    assert doubt_depth(np.full((HEIGHT, WIDTH), 2, np.float32), paint(masks), masks) == ""
    assert doubt_depth(np.zeros((HEIGHT, WIDTH), np.float32), paint(masks), masks) == ""


def test_depth_of_another_place_or_picture_is_doubted() -> None:
    depth, masks = trace([LEFT, RIGHT])
    moved = doubt_depth(show(depth, 1.0, 36), paint(masks))
    assert "moved by -" in moved and "not aligned" in moved
    other, _ = trace([UprightBox([3.0, 0.1, 0.1], [0.3, 0.3, 0.2], 0.0)])
    with refused("E-DEPTH-UNALIGNED", "or place"):
        doubt_depth(other, paint(masks), masks)


def test_two_things_of_one_value_become_two(capsys: pytest.CaptureFixture[str]) -> None:
    frame = make_frame([LEFT, RIGHT], {FLOOR: "floor", WALL: "wall", OBJECT: "box"}, {OBJECT + 1: OBJECT})
    split = split_values(frame).masks
    assert split is not None and list(split.labels.values()) == ["floor", "wall", "box", "box"]
    _, alone = trace([LEFT, RIGHT])
    sizes = {int((split.values == value).sum()) for value, label in split.labels.items() if label == "box"}
    assert sizes == {int((alone == OBJECT).sum()), int((alone == OBJECT + 1).sum())}
    assert "2 places" in capsys.readouterr().out


def test_masks_that_tell_things_of_a_name_apart_are_not_split_but_doubted(capsys: pytest.CaptureFixture[str]) -> None:
    names = {FLOOR: "floor", WALL: "wall", OBJECT: "box", OBJECT + 2: "box"}
    boxes = [UprightBox([2.4, side, 0.1], [0.2, 0.2, 0.2], 0.0) for side in (0.7, -0.4, 0.1)]
    frame = make_frame(boxes, names, {OBJECT + 1: OBJECT})
    split = split_values(frame).masks
    assert split is not None and split.labels == names
    assert list(split.doubts) == [OBJECT] and "one thing or two" in split.doubts[OBJECT][0].what
    assert "2 places: taken for one thing" in capsys.readouterr().out


def test_a_thing_that_another_hides_in_the_middle_stays_one() -> None:
    board = UprightBox([3.0, 0.1, 0.5], [0.3, 2.0, 1.0], 0.0)
    pole = UprightBox([1.8, 0.1, 0.7], [0.2, 0.2, 1.4], 0.0)
    frame = make_frame([board, pole], {FLOOR: "floor", WALL: "wall", OBJECT: "sideboard", OBJECT + 1: "pole"})
    split = split_values(frame).masks
    assert split is not None and len(split.labels) == 4 and not split.doubts


def make_recording(folder: Path, colors: list[str], depths: list[str], files: dict[str, str]) -> Path:
    for name in (*(f"color/{one}.jpg" for one in colors), *(f"depth/{one}.png" for one in depths), *files):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(files.get(name, ""))
    return folder


def test_pictures_and_depth_are_paired_by_their_numbers(tmp_path: Path) -> None:
    recording = make_recording(tmp_path, ["1-90", "3-91", "4-92"], ["1-70", "2-71", "4-72"], {"intrinsics.json": "{}"})
    assert [(a.stem, b.stem) for a, b in list_frames(recording)] == [("1-90", "1-70"), ("4-92", "4-72")]
    assert "2 files have no partner" in find_view(recording, 1, None).notes[0]
    with refused("E-RECORDING-LAYOUT", "0 have the same number"):
        list_frames(make_recording(tmp_path / "times", ["100", "200"], ["117", "217"], {}))


def test_intrinsics_are_those_of_the_color_camera(tmp_path: Path) -> None:
    files = {"depth_intrinsics.json": "1", "rgb_intrinsics.json": "2"}
    assert (
        find_view(make_recording(tmp_path, ["1"], ["1"], files), 0, None).notes[1]
        == "intrinsics of rgb_intrinsics.json"
    )
    unclear = make_recording(tmp_path / "b", ["1"], ["1"], {"intrinsics_a.json": "1", "intrinsics_b.json": "2"})
    with refused("E-CAMERA-SEVERAL", "intrinsics_a.json, intrinsics_b.json"):
        find_view(unclear, 0, None)


def test_annotations_that_name_themselves_are_read(tmp_path: Path) -> None:
    runs = {"size": [4, 6], "counts": [4, 8, 12]}
    items = [{"class_name": "mug .", "bbox": [1, 0, 3, 4], "segmentation": runs, "score": [0.9]}]
    (tmp_path / "results.json").write_text(
        json.dumps({"image_path": "a.jpg", "annotations": items, "box_format": "xyxy", "img_width": 6, "img_height": 4})
    )
    found = read_labelled(tmp_path / "results.json", None, 6, 4, "a.jpg")
    assert found.labels == {1: "mug"} and int(found.values.sum()) == 8
    with refused("E-MASKS-SIZE"):
        read_labelled(tmp_path / "results.json", None, 12, 4, "a.jpg")


def test_so_many_annotations_as_fill_the_memory_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mask_shapes, "MAX_BYTES", 3 * 24)
    items = [{"id": k, "image_id": 0, "category_id": 1, "bbox": [1, 1, 2, 2]} for k in range(9)]
    data = {"annotations": items, "categories": [{"id": 1, "name": "cup"}]}
    (tmp_path / "m.json").write_text(json.dumps(data))
    with refused("E-FILE-LARGE", "has 4 masks of this picture or more"):
        read_labelled(tmp_path / "m.json", None, 6, 4, "a.jpg")


def test_text_of_another_encoding_is_told(tmp_path: Path) -> None:
    (tmp_path / "m.json").write_bytes('{"shapes": [{"label": "Tür"}]}'.encode("cp1252"))
    with refused("E-FILE-ENCODING", "UTF-8"):
        read_labelled(tmp_path / "m.json", None, 6, 4, "a.jpg")


def test_a_pipe_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "m.json")
    with refused("E-FILE-UNREADABLE", "pipe"):
        read_labelled(tmp_path / "m.json", None, 6, 4, "a.jpg")
