"""One picture by pretrained networks: the real path with tiny random ones, and what is made of a known answer."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from roomkin.plugins.pretrained import networks
from roomkin.plugins.pretrained.depth_sources import depth_anything as depths
from roomkin.plugins.pretrained.networks import Detection, detect, segment
from roomkin.plugins.vlm.captioners import vlm
from roomkin.plugins.vlm.prompt import draw_box
from roomkin.plugins.vlm.tests.chat_server import KEY, ChatServer, says, serving
from roomkin.stages.config.perception import MeasureOptions, PerceptionSection, SeeOptions
from roomkin.stages.contracts import Camera, InputError, Objects, read_json
from roomkin.stages.contracts.images import color_of
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import back_project, transform_points
from roomkin.stages.geometry.room_planes import STRAY
from roomkin.stages.perception import measure, see
from roomkin.stages.perception.read import photo
from roomkin.stages.perception.read.frame import Frame
from roomkin.stages.perception.read.photo import Photo
from roomkin.stages.perception.see import state
from roomkin.stages.perception.write import draw_numbers
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, INTRINSICS, OBJECT, write_room
from tests.unit.tiny_networks import depth_anything, save_all


def run(image: Path, out: Path, options: str) -> None:
    """A photograph as the workflow takes it: its depth, then its things."""
    given = json.loads(options)
    read = {key: value for key, value in given.items() if key in MeasureOptions.model_fields}
    measure.run(image=image, out=out.with_name(f"{out.name}-view"), options=json.dumps(read))
    read = {key: value for key, value in given.items() if key in SeeOptions.model_fields} | {"proposers": ["grounding"]}
    see.run(picture=out.with_name(f"{out.name}-view"), out=out, options=json.dumps(read))


RGB = np.random.default_rng(0).integers(0, 255, (120, 160, 3), dtype=np.uint8)
BOXES = [UprightBox((3.6, -0.6, 0.45), (0.6, 0.9, 0.9), 0.0), UprightBox((2.6, 0.6, 0.3), (0.5, 0.5, 0.6), 0.3)]


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return save_all(tmp_path_factory.mktemp("weights"))


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_room(tmp_path_factory.mktemp("rooms") / "room", BOXES, ["cabinet", "box"])


def options(tiny: dict[str, Any], **keys: Any) -> PerceptionSection:
    return PerceptionSection.model_validate(tiny | keys)


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
    tokenizer = networks._tokenizer(options(tiny).detector)
    texts = list(networks._texts(tokenizer, ["coffee table", "mug", "cabinet", " "], 8))
    words = [tokenizer.convert_ids_to_tokens(ids) for ids, _ in texts]
    assert words == [["[CLS]", "coffee", "table", ".", "mug", ".", "[SEP]"], ["[CLS]", "cabinet", ".", "[SEP]"]]
    assert [spans for _, spans in texts] == [{"coffee table": (1, 3), "mug": (4, 5)}, {"cabinet": (1, 2)}]


def test_depth_is_in_metres(tiny: dict[str, Any], tmp_path: Path) -> None:
    depth = depths.measure_depth(RGB, options(tiny))
    assert depth.shape == (120, 160) and depth.dtype == np.float32 and 0 < depth.min() <= depth.max() <= 100
    depth_anything(tmp_path / "relative", "relative")
    with refused("E-WEIGHTS-KIND"):
        depths.measure_depth(RGB, options(tiny, depth_anything=str(tmp_path / "relative")))


def test_a_picture_becomes_an_input_folder_by_saved_weights(tiny: dict[str, Any], tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "kitchen.png"), RGB)
    given = json.dumps(tiny | {"labels": ["cabinet", "mug"]})
    files = []
    for name in ("one", "two"):
        run(image=tmp_path / "kitchen.png", out=tmp_path / name, options=given)
        read_scene_input(tmp_path / name)
        files.append({path.name: path.read_bytes() for path in (tmp_path / name).glob("[!c]*")})
    made = {"rgb.png", "depth.npz", "masks.png", "annotations.json", "things.json", "numbers.png"}
    assert files[0] == files[1] and made == set(files[0])
    assert "one" in (tmp_path / "one/config.yaml").read_text()


def test_weights_that_are_not_there_are_one_line(tiny: dict[str, Any], tmp_path: Path) -> None:
    with refused("E-WEIGHTS-MISSING"):
        detect(RGB, ["mug"], options(tiny, detector=str(tmp_path / "nowhere")))
    with refused("E-WEIGHTS-BROKEN"):
        segment(RGB, [], options(tiny, segmenter=tiny["detector"]))


@pytest.fixture
def known(room: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Detection]]:
    """Networks that see the synthetic room as it is: two objects, the first found twice."""
    scene = read_scene_input(room)
    values = {"cabinet": OBJECT, "box": OBJECT + 1, "shelf": OBJECT}
    found = []
    for number, (label, value) in enumerate(values.items()):
        rows, columns = np.nonzero(scene.masks == value)
        box = tuple(float(each) for each in (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1))
        found.append(Detection(label, 0.95 - 0.1 * number, box))  # type: ignore[arg-type]
    monkeypatch.setattr(networks, "detect", lambda *_: found)
    monkeypatch.setattr(networks, "segment", lambda *_: [scene.masks == value for value in values.values()])
    monkeypatch.setattr(depths, "measure_depth", lambda *_: scene.depth)
    focal = float(INTRINSICS[0][0])
    monkeypatch.setattr(photo, "read_photo", lambda *_: Photo(scene.rgb, focal, 1.0))
    yield found


BY_NETWORKS = '{"labels": ["cabinet", "box", "shelf"]}'


def test_what_the_networks_see_is_what_extraction_finds(room: Path, known: list[Detection], tmp_path: Path) -> None:
    known[1] = known[1]._replace(label="crate")  # as `cabinet`, no category: detected so, it is called so
    run(image=room / "rgb.png", out=tmp_path / "seen", options=BY_NETWORKS)
    truth, seen = read_scene_input(room), read_scene_input(tmp_path / "seen")
    assert [item.label for item in seen.annotations.objects] == ["cabinet", "crate"]
    assert len(seen.annotations.objects) == 2  # no shelf: it is the cabinet
    for item, value in zip(seen.annotations.objects, (OBJECT, OBJECT + 1), strict=True):
        both = (seen.masks == item.mask, truth.masks == value)
        assert (both[0] & both[1]).sum() > 0.85 * (both[0] | both[1]).sum()
    floor = (seen.masks == seen.annotations.floor, truth.masks == FLOOR)
    assert (floor[0] & floor[1]).sum() > 0.9 * (floor[0] | floor[1]).sum() and len(seen.annotations.walls) == 1
    np.testing.assert_allclose(seen.camera.intrinsics, INTRINSICS, rtol=1e-6)
    assert "by EXIF" in seen.camera.note and seen.camera.floor_from_camera is None
    extract(input=tmp_path / "seen", scene="seen", options="{}", seed=0, out=tmp_path / "found/objects.json")
    sizes = [item["box"]["size"] for item in json.loads((tmp_path / "found/objects.json").read_text())["objects"]]
    assert sizes[1][2] == pytest.approx(0.6, abs=0.06)


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
        run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path))
        assert len(server.requests) == 3
        schema = server.requests[1]["response_format"]["json_schema"]["schema"]
        assert schema["properties"]["label"]["enum"] == ["cabinet", "box", "stool", "none"]
    items = read_scene_input(tmp_path / "seen").annotations.objects
    assert [(item.label, item.articulated, item.doors, item.drawers) for item in items] == [
        ("cabinet", True, 2, 1), ("stool", False, 0, 0)]  # fmt: skip
    assert "object 2, box: is a stool, says toy" in capsys.readouterr().out
    again = asked(server, tmp_path, mode="replay")
    run(image=room / "rgb.png", out=tmp_path / "again", options=again)  # nobody is there to be asked
    assert (tmp_path / "again/annotations.json").read_bytes() == (tmp_path / "seen/annotations.json").read_bytes()


def test_a_language_model_that_is_no_help(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with serving(says(json.dumps({"labels": ["cabinet", "box"]})), look("none"), says("well"), key=KEY) as server:
        run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path))
    assert [item.label for item in read_scene_input(tmp_path / "seen").annotations.objects] == ["box"]
    said = capsys.readouterr().out
    assert "object 1, cabinet: is no whole object" in said and "object 2, box: no answer" in said
    with (
        serving(says("well"), key=KEY) as server,
        refused("E-VLM-ANSWER"),
    ):
        run(image=room / "rgb.png", out=tmp_path / "none", options=asked(server, tmp_path, ledger=str(tmp_path)))
    assert not (tmp_path / "none").exists()


def hold(how: str, *walls: int) -> Any:
    return says(json.dumps({"held": how, "walls": walls}))


def test_a_language_model_says_what_hangs_and_where(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    steps = [says(json.dumps({"labels": ["cabinet", "box"]})), look("cabinet"), look("box")]
    with serving(*steps, hold("hangs", 1), hold("stands_at_wall", 7), key=KEY) as server:
        run(image=room / "rgb.png", out=tmp_path / "seen", options=asked(server, tmp_path, "vlm"))
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
    said = {"label": "cabinet", "mounting": (3, [0, 1])}
    seen, half = (state(said, [2, 3, 4], shown) for shown in ([2, 3], [3, 4]))
    assert seen == {"mounting": Held(type=3, walls=[2, 3])} and half == {}


@pytest.mark.parametrize(("how", "walls"), [("stands", [1]), ("hangs", []), ("floats", [1]), ("hangs", [0])])
def test_mountings_that_cannot_be_are_no_answers(how: str, walls: list[int], tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with serving(hold(how, *walls), key=KEY) as server:
        captioner = vlm.Captioner(json.loads(asked(server, tmp_path))["vlm"])
        assert captioner.hold(RGB, (10, 10, 50, 50), [RGB[..., 0] > 100], "mug", 1) is None


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


def test_where_no_floor_is_seen_lines_tell_what_is_level(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = read_scene_input(room)
    measure.run(image=room / "rgb.png", out=tmp_path / "seen")
    assert read_json(Camera, tmp_path / "seen/camera.json").floor_from_camera is None  # extraction finds it
    flat = np.full_like(scene.depth, 3.0)  # as of a bad network: all at one distance
    monkeypatch.setattr(depths, "measure_depth", lambda *_: flat)
    monkeypatch.setattr(photo, "read_photo", lambda *_: Photo(np.full_like(scene.rgb, 90), None, 1.0))
    measure.run(image=room / "rgb.png", out=tmp_path / "flat")
    camera = read_json(Camera, tmp_path / "flat/camera.json")
    assert "level by lines" in camera.note and camera.floor_from_camera is not None
    pose, intrinsics = np.array(camera.floor_from_camera), np.array(camera.intrinsics)
    assert pose[2, 3] > 0.5 and pose[2, :3] @ [0, -1, 0] > 0.9  # up in the picture is about up
    heights = transform_points(pose, back_project(flat, intrinsics))[..., 2]
    assert np.quantile(heights, STRAY) == pytest.approx(0, abs=1e-3)
    frame = Frame(scene.rgb, flat, intrinsics)
    assert np.array_equal(see.look(replace(frame, pose=pose)).surfaces.frame, pose)
    with refused("E-FLOOR-MISSING"):
        see.look(frame)


def test_the_focal_length_is_the_best_that_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    grey = np.full((120, 160, 3), 90, np.uint8)
    grey[40:80] = 140
    cases: list[tuple[float | None, dict[str, Any], float, str]] = [
        (200.0, {"field_of_view": 90}, 80.0, "perception.field_of_view"),
        (200.0, {"lens": "lens.yaml"}, 200.0, "perception.lens"),
        (200.0, {}, 200.0, "EXIF"),
        (None, {}, 128.0, "a usual camera, as nothing tells it"),
    ]
    for told, keys, focal, source in cases:
        monkeypatch.setattr(photo, "read_photo", lambda *_, told=told: Photo(grey, told, 1.0))
        found, known, said = photo.read_known(Path("a.jpg"), PerceptionSection.model_validate(keys))
        intrinsics, line = measure.find_camera(found.rgb, known, said)
        assert intrinsics[0, 0] == pytest.approx(focal) and source in line and intrinsics[0, 2] == 79.5


def test_a_picture_of_nothing_that_is_known_is_one_line(
    room: Path, known: list[Detection], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(networks, "detect", lambda *_: [])
    monkeypatch.setattr(networks, "segment", lambda *_: [])
    with refused("E-MASKS-EMPTY"):
        run(image=room / "rgb.png", out=tmp_path / "seen", options=BY_NETWORKS)
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
        run(image=tmp_path / name, out=tmp_path / "out", options=json.dumps(tiny))
    assert name in str(raised.value) and "\n" not in str(raised.value) and not (tmp_path / "out").exists()


def test_a_tiny_picture_is_read(tiny: dict[str, Any], tmp_path: Path) -> None:
    coarse = np.random.default_rng(2).integers(0, 255, (9, 12, 3), dtype=np.uint8)
    cv2.imwrite(str(tmp_path / "a.jpg"), cv2.resize(coarse, (48, 36), interpolation=cv2.INTER_NEAREST))
    given = json.dumps(tiny | {"labels": ["cabinet"], "box_threshold": 0.01})
    run(image=tmp_path / "a.jpg", out=tmp_path / "out", options=given)
    assert read_scene_input(tmp_path / "out").rgb.shape == (36, 48, 3)
