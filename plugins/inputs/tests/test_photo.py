"""One picture by pretrained networks: the real path with tiny random ones, and what is made of a known answer."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from plugins.inputs import estimate
from plugins.inputs.config import PhotoConfig
from plugins.inputs.numbered import draw_numbers
from plugins.inputs.photo import captions, networks
from plugins.inputs.photo.level import level_camera
from plugins.inputs.photo.networks import Detection, depth_of, detect, segment
from plugins.inputs.photo.picture import Photo
from plugins.inputs.rgbd.frame import Frame, Labelled
from plugins.vlm.ask import Asker, NoAnswerError
from plugins.vlm.config import VlmConfig
from plugins.vlm.prompt import draw_box
from plugins.vlm.tests.chat_server import KEY, ChatServer, says, serving
from stages.contracts import InputError, Objects, read_json
from stages.contracts.images import color_of
from stages.contracts.objects import Mounting
from stages.contracts.scene_input import read_scene_input
from stages.contracts.scenes import Annotation, Held
from stages.extraction.extract import run as extract
from stages.geometry.boxes import UprightBox
from stages.geometry.cameras import back_project
from stages.geometry.frames import transform_points
from stages.geometry.room_planes import STRAY
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, INTRINSICS, OBJECT, WALL, write_room
from tests.unit.tiny_networks import depth_anything, save_all

RGB = np.random.default_rng(0).integers(0, 255, (120, 160, 3), dtype=np.uint8)
BOXES = [UprightBox((3.6, -0.6, 0.45), (0.6, 0.9, 0.9), 0.0), UprightBox((2.6, 0.6, 0.3), (0.5, 0.5, 0.6), 0.3)]


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return save_all(tmp_path_factory.mktemp("weights"))


@pytest.fixture
def _all_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Masks of random networks overlap, and some are tiny."""
    monkeypatch.setattr(PhotoConfig, "overlap", 1.0)
    monkeypatch.setattr(PhotoConfig, "min_share", 0.0)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_room(tmp_path_factory.mktemp("rooms") / "room", BOXES, ["cabinet", "box"])


def options(tiny: dict[str, Any], **keys: Any) -> PhotoConfig:
    return PhotoConfig.model_validate(tiny | keys)


def test_boxes_are_of_given_labels_and_masks_of_the_picture(tiny: dict[str, Any]) -> None:
    found = detect(RGB, ["cabinet", "Coffee Table.", "mug", "mug"], options(tiny))
    assert found and {item.label for item in found} <= {"cabinet", "coffee table", "mug"}
    assert [item.score for item in found] == sorted((item.score for item in found), reverse=True)
    boxes = np.array([item.box for item in found])
    assert (boxes >= 0).all() and (boxes[:, 2] <= 160).all() and (boxes[:, 3] <= 120).all()
    masks = segment(RGB, found, options(tiny))
    assert len(masks) == len(found) and all(mask.shape == (120, 160) and mask.dtype == bool for mask in masks)
    again = detect(RGB, ["cabinet", "coffee table", "mug"], options(tiny))
    assert found == again


def test_many_labels_are_asked_for_in_several_texts(tiny: dict[str, Any]) -> None:
    tokenizer = networks._tokenizer(options(tiny).detector, "photo.detector")
    texts = list(networks._texts(tokenizer, ["coffee table", "mug", "cabinet", " "], 8))
    words = [tokenizer.convert_ids_to_tokens(ids) for ids, _ in texts]
    assert words == [["[CLS]", "coffee", "table", ".", "mug", ".", "[SEP]"], ["[CLS]", "cabinet", ".", "[SEP]"]]
    assert [spans for _, spans in texts] == [{"coffee table": (1, 3), "mug": (4, 5)}, {"cabinet": (1, 2)}]


def test_depth_is_in_metres(tiny: dict[str, Any], tmp_path: Path) -> None:
    depth = depth_of(RGB, options(tiny))
    assert depth.shape == (120, 160) and depth.dtype == np.float32 and 0 < depth.min() <= depth.max() <= 100
    depth_anything(tmp_path / "relative", "relative")
    with refused("E-WEIGHTS-KIND"):
        depth_of(RGB, options(tiny, depth_anything=str(tmp_path / "relative")))


@pytest.mark.usefixtures("_all_kept")
def test_a_picture_becomes_an_input_folder_by_saved_weights(tiny: dict[str, Any], tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "kitchen.png"), RGB)
    given = json.dumps(tiny | {"labels": ["cabinet", "mug"]})
    files = []
    for name in ("one", "two"):
        estimate.run(image=tmp_path / "kitchen.png", out=tmp_path / name, options=given)
        read_scene_input(tmp_path / name)
        files.append({path.name: path.read_bytes() for path in (tmp_path / name).glob("[!c]*")})
    assert files[0] == files[1] and {"rgb.png", "depth.npz", "masks.png", "annotations.json"} == set(files[0])
    assert "one" in (tmp_path / "one/config.yaml").read_text()


def test_weights_that_are_not_there_are_one_line(tiny: dict[str, Any], tmp_path: Path) -> None:
    with refused("E-WEIGHTS-MISSING"):
        detect(RGB, ["mug"], options(tiny, detector=str(tmp_path / "nowhere")))
    with refused("E-WEIGHTS-BROKEN"):
        segment(RGB, [], options(tiny, segmenter=tiny["detector"]))


@pytest.fixture
def known(room: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Detection]]:
    """Networks that see the synthetic room as it is: two objects, the first found twice, floor and wall."""
    scene = read_scene_input(room)
    values = {"cabinet": OBJECT, "box": OBJECT + 1, "shelf": OBJECT, "floor": FLOOR, "wall": WALL}
    found = []
    for number, (label, value) in enumerate(values.items()):
        rows, columns = np.nonzero(scene.masks == value)
        box = tuple(float(each) for each in (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1))
        found.append(Detection(label, 0.9 - 0.1 * number, box))  # type: ignore[arg-type]
    monkeypatch.setattr(estimate, "detect", lambda *_: found)
    monkeypatch.setattr(estimate, "segment", lambda *_: [scene.masks == values[item.label] for item in found])
    monkeypatch.setattr(estimate, "depth_of", lambda *_: scene.depth)
    focal = float(INTRINSICS[0][0])
    monkeypatch.setattr(estimate, "read_photo", lambda *_: Photo(scene.rgb, focal, 1.0))
    yield found


def test_what_the_networks_see_is_what_extraction_finds(room: Path, known: list[Detection], tmp_path: Path) -> None:
    estimate.run(image=room / "rgb.png", out=tmp_path / "seen")
    truth, seen = read_scene_input(room), read_scene_input(tmp_path / "seen")
    assert [item.label for item in seen.annotations.objects] == ["cabinet", "box"]  # no shelf: it is the cabinet
    assert [item.articulated for item in seen.annotations.objects] == [True, False]
    for item, value in zip(seen.annotations.objects, (OBJECT, OBJECT + 1), strict=True):
        np.testing.assert_array_equal(seen.masks == item.mask, truth.masks == value)
    np.testing.assert_array_equal(seen.masks == seen.annotations.floor, truth.masks == FLOOR)
    assert len(seen.annotations.walls) == 1
    np.testing.assert_allclose(seen.camera.intrinsics, INTRINSICS, rtol=1e-6)
    assert "by EXIF" in seen.camera.note and seen.camera.floor_from_camera is None
    extract(input=tmp_path / "seen", scene="seen", options="{}", seed=0, out=tmp_path / "found/objects.json")
    sizes = [item["box"]["size"] for item in json.loads((tmp_path / "found/objects.json").read_text())["objects"]]
    assert sizes[1][2] == pytest.approx(0.6, abs=0.06)


def test_of_masks_that_overlap_the_smaller_lies_on_top(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is more certain: a box before a cabinet is in the mask of both."""
    truth = read_scene_input(room)
    box, both = truth.masks == OBJECT + 1, truth.masks >= OBJECT
    assert 2 * box.sum() < both.sum()
    monkeypatch.setattr(estimate, "detect", lambda *_: known[:2])
    for masks in ([both, box], [box, both]):
        monkeypatch.setattr(estimate, "segment", lambda *_, masks=masks: masks)
        estimate.run(image=room / "rgb.png", out=tmp_path / "seen")
        seen = read_scene_input(tmp_path / "seen")
        small, large = sorted((seen.masks == item.mask for item in seen.annotations.objects), key=np.sum)
        np.testing.assert_array_equal(small, box)
        np.testing.assert_array_equal(large, both & ~box)


def asked(server: ChatServer, tmp_path: Path, mounting: str = "geometry", **keys: Any) -> str:
    vlm = {"url": server.url, "model": "toy", "ledger": str(tmp_path / "ledger")} | keys
    return json.dumps({"captions": "vlm", "mounting": mounting, "vlm": vlm})


def look(label: str, articulated: bool = False, doors: int = 0, drawers: int = 0) -> Any:
    return says(json.dumps({"label": label, "articulated": articulated, "doors": doors, "drawers": drawers}))


def test_a_language_model_names_and_counts(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    first = says(json.dumps({"labels": ["Cabinet", "box", "stool", "cabinet"]}))
    with serving(first, look("cabinet", doors=2, drawers=1), look("stool"), key=KEY) as server:
        estimate.run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path))
        assert len(server.requests) == 3
        schema = server.requests[1]["response_format"]["json_schema"]["schema"]
        assert schema["properties"]["label"]["enum"] == ["cabinet", "box", "stool", "none"]
    items = read_scene_input(tmp_path / "seen").annotations.objects
    assert [(item.label, item.articulated, item.doors, item.drawers) for item in items] == [
        ("cabinet", True, 2, 1), ("stool", False, 0, 0)]  # fmt: skip
    assert "object 2, box: is a stool, says toy" in capsys.readouterr().out
    again = asked(server, tmp_path, mode="replay")
    estimate.run(image=room / "rgb.png", out=tmp_path / "again", options=again)  # nobody is there to be asked
    assert (tmp_path / "again/annotations.json").read_bytes() == (tmp_path / "seen/annotations.json").read_bytes()


def test_a_language_model_that_is_no_help(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with serving(says(json.dumps({"labels": ["cabinet", "box"]})), look("none"), says("well"), key=KEY) as server:
        estimate.run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path))
    assert [item.label for item in read_scene_input(tmp_path / "seen").annotations.objects] == ["box"]
    said = capsys.readouterr().out
    assert "object 1, cabinet: is no whole object" in said and "object 2, box: no answer" in said
    with (
        serving(says("well"), key=KEY) as server,
        refused("E-VLM-ANSWER"),
    ):
        estimate.run(
            image=room / "rgb.png", out=tmp_path / "none", options=asked(server, tmp_path, ledger=str(tmp_path))
        )
    assert not (tmp_path / "none").exists()


def hold(how: str, *walls: int) -> Any:
    return says(json.dumps({"held": how, "walls": walls}))


def test_a_language_model_says_what_hangs_and_where(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    steps = [says(json.dumps({"labels": ["cabinet", "box"]})), look("cabinet"), look("box")]
    with serving(*steps, hold("hangs", 1), hold("stands_at_wall", 7), key=KEY) as server:
        estimate.run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path, "vlm"))
        question = server.requests[3]
    assert len([part for part in question["messages"][1]["content"] if part["type"] == "image_url"]) == 2
    items = question["response_format"]["json_schema"]["schema"]["properties"]["walls"]["items"]
    assert items.get("enum", [items.get("const")]) == [1]  # there is one wall
    assert "object 2, box: mounting by geometry, no answer" in capsys.readouterr().out  # it named a seventh wall
    given = read_scene_input(tmp_path / "seen").annotations
    assert given.objects[0].mounting == Held(type=1, walls=given.walls) and given.objects[1].mounting is None
    extract(input=tmp_path / "seen", scene="seen", out=tmp_path / "found/objects.json")
    cabinet, box = read_json(Objects, tmp_path / "found/objects.json").objects
    assert cabinet.mounting == Mounting(type=1, walls=["wall_1"])
    assert cabinet.measured_mounting == Mounting(type=3, walls=["wall_1"]) and box.measured_mounting is None


def test_a_mounting_counts_if_all_of_its_walls_are_seen() -> None:
    thing = estimate.Thing(Detection("cabinet", 0.9, (0, 0, 1, 1)), np.ones((1, 1), bool), mounting=(3, [0, 1]))
    item = Annotation(mask=OBJECT, label="cabinet")
    seen, half = (estimate._state(item, thing, [2, 3, 4], shown) for shown in ([2, 3], [3, 4]))
    assert seen.mounting == Held(type=3, walls=[2, 3]) and half.mounting is None


@pytest.mark.parametrize(("how", "walls"), [("stands", [1]), ("hangs", []), ("floats", [1]), ("hangs", [0])])
def test_mountings_that_cannot_be_are_no_answers(how: str, walls: list[int], tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with serving(hold(how, *walls), key=KEY) as server:
        asker = Asker(VlmConfig.model_validate(PhotoConfig.model_validate_json(asked(server, tmp_path)).vlm))
        with pytest.raises(NoAnswerError):
            captions.ask_mounting(asker, RGB, (10, 10, 50, 50), [RGB[..., 0] > 100], "mug", "a mug")


def test_walls_are_numbered_where_they_are_wide() -> None:
    masks = [np.zeros((120, 160), bool), np.zeros((120, 160), bool)]
    masks[0][:, :40], masks[1][40:, 60:] = True, True
    shown = draw_numbers(np.zeros((120, 160, 3), np.uint8), masks)
    assert all((shown[mask].max(axis=-1) == 255).sum() > 3 for mask in masks)
    assert not shown[:, 45:55].any() and (shown[2, 2] == np.array(color_of(0)) // 2).all()
    hidden = draw_numbers(np.zeros((120, 160, 3), np.uint8), [masks[0], np.zeros_like(masks[0])])
    assert not hidden[~masks[0]].any(), "what lies behind others has no number"


def test_boxes_leave_what_is_in_them_and_end_with_the_picture() -> None:
    shown = draw_box(np.zeros((120, 160, 3), np.uint8), (-9.0, 30.4, 80.0, 500.0))
    red = shown[..., 0] == 255
    assert red[30, :80].all() and red[119, :80].all() and red[30:, 0].all() and red[30:, 80].all()
    assert not red[34:115, 4:76].any() and not red[:28].any() and not red[:, 83:].any()


def test_where_no_floor_is_seen_lines_tell_what_is_level(room: Path) -> None:
    scene = read_scene_input(room)
    frame = Frame(scene.rgb, scene.depth, np.asarray(INTRINSICS), Labelled(scene.masks, {FLOOR: "floor"}))
    assert level_camera(frame, FLOOR) is None  # extraction finds it
    flat = np.full_like(scene.depth, 3.0)  # as of a bad network: all at one distance
    pose = level_camera(Frame(np.full_like(scene.rgb, 90), flat, np.asarray(INTRINSICS)), None)
    assert pose is not None and pose[2, 3] > 0.5
    assert pose[2, :3] @ [0, -1, 0] > 0.9  # up in the picture is about up
    heights = transform_points(pose, back_project(flat, np.asarray(INTRINSICS)))[..., 2]
    assert np.quantile(heights, STRAY) == pytest.approx(0, abs=1e-3)


def test_the_focal_length_is_the_best_that_is_known() -> None:
    grey = np.full((120, 160, 3), 90, np.uint8)
    grey[40:80] = 140
    known, unknown = Photo(grey, 200.0, 1.0), Photo(grey, None, 1.0)
    cases = [
        (known, {"field_of_view": 90}, 80.0, "photo.field_of_view"),
        (known, {"lens": "lens.yaml"}, 200.0, "photo.lens"),
        (known, {}, 200.0, "EXIF"),
        (unknown, {}, 128.0, "a usual camera, as nothing tells it"),
    ]
    for photo, keys, focal, source in cases:
        intrinsics, line = estimate.camera_of(photo, PhotoConfig.model_validate(keys))
        assert intrinsics[0, 0] == pytest.approx(focal) and source in line and intrinsics[0, 2] == 79.5


def test_a_picture_of_nothing_that_is_known_is_one_line(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimate, "detect", lambda *_: known[3:])
    with refused("E-SCENE-EMPTY"):
        estimate.run(image=room / "rgb.png", out=tmp_path / "seen")
    assert not (tmp_path / "seen").exists()


def _pictures() -> dict[str, bytes]:
    noise = np.random.default_rng(1).integers(0, 255, (300, 900, 3), dtype=np.uint8)
    made = {"black.png": np.zeros((90, 120, 3), np.uint8), "panorama.jpg": noise, "tiny.png": noise[:9, :12]}
    files = {name: cv2.imencode(name[-4:], pixels)[1].tobytes() for name, pixels in made.items()}
    return files | {"cut.jpg": files["panorama.jpg"][:300], "text.png": b"no picture", "empty.jpg": b""}


@pytest.mark.parametrize("name", ["black.png", "panorama.jpg", "tiny.png", "cut.jpg", "text.png", "empty.jpg"])
def test_pictures_that_cannot_be_read_so_are_one_line(tiny: dict[str, Any], tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(_pictures()[name])
    with pytest.raises(InputError) as raised:
        estimate.run(image=tmp_path / name, out=tmp_path / "out", options=json.dumps(tiny))
    assert name in str(raised.value) and "\n" not in str(raised.value) and not (tmp_path / "out").exists()


@pytest.mark.usefixtures("_all_kept")
def test_a_tiny_picture_is_read(tiny: dict[str, Any], tmp_path: Path) -> None:
    coarse = np.random.default_rng(2).integers(0, 255, (9, 12, 3), dtype=np.uint8)
    cv2.imwrite(str(tmp_path / "a.jpg"), cv2.resize(coarse, (48, 36), interpolation=cv2.INTER_NEAREST))
    given = json.dumps(tiny | {"labels": ["cabinet"], "box_threshold": 0.01})
    estimate.run(image=tmp_path / "a.jpg", out=tmp_path / "out", options=given)
    assert read_scene_input(tmp_path / "out").rgb.shape == (36, 48, 3)
