"""Any photograph, what is written of a drawing, and a server that answers nobody but its own page."""

import errno
import http.client
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, PngImagePlugin

from roomkin.plugins.annotator import annotate
from roomkin.plugins.annotator.server import PageServer
from roomkin.plugins.annotator.session import UNCOUNTED, Session, describe_room, find_carriers
from roomkin.plugins.annotator.tests.annotate_page import serve
from roomkin.stages.contracts import Annotations, Camera, InputError, Objects, read_json, write_json
from roomkin.stages.contracts.categories import sizes_of
from roomkin.stages.contracts.hand import PROJECT
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.geometry.boxes import UprightBox, corners, oriented_iou
from roomkin.stages.geometry.frames import transform_points
from roomkin.stages.perception.camera.perspective import Guide, Perspective, find_weak_lines, fit_view
from roomkin.stages.perception.drawing.outlined import support_at
from roomkin.stages.perception.drawing.paint import extend, paint
from roomkin.stages.perception.drawing.project import DrawnObject, DrawnWall, Project, Scale
from roomkin.stages.perception.drawing.solve import UNSURE, solve
from roomkin.stages.perception.drawing.write import Written, at_size, finish_drawing, write_folder
from roomkin.stages.perception.read.photo import LONGEST_SIDE, check_photo, read_photo
from tests.refusals import refused

WIDTH, HEIGHT = 320, 240
PERSPECTIVE = Perspective(likely_focal=260, focal=260)
VIEW = fit_view(PERSPECTIVE, WIDTH, HEIGHT)  # tilted down by 8 degrees
BOXES = {
    "cabinet": UprightBox([-0.5, 3.2, 0.45], [0.8, 0.6, 0.9], 0.0),
    "mug": UprightBox([-0.5, 3.1, 0.96], [0.12, 0.12, 0.12], 0.0),
    "shelf": UprightBox([0.7, 3.4, 1.5], [0.7, 0.2, 0.3], 0.0),
}


def _pixels(points: Any, above: float = 1.5) -> list[tuple[float, float]]:
    return [tuple(pixel) for pixel in VIEW.project(np.asarray(points) / above).tolist()]


def _drawing(**changes: Any) -> Project:
    """A cabinet at the back wall, a mug on it, a shelf on the wall."""
    seen = {name: _pixels(corners(box)) for name, box in BOXES.items()}
    left, right = _pixels([[-1, 3.5, 0], [1, 3.5, 0]])
    points = {
        name: [pixels[k] for k in ((0, 5, 7) if name == "shelf" else (0, 1, 4, 6))] for name, pixels in seen.items()
    }
    on = {"cabinet": "floor", "mug": "cabinet", "shelf": "back"}
    given = {
        "objects": [DrawnObject(id=name, label=name, on=on[name], points=points[name]) for name in BOXES],
        "walls": [DrawnWall(id="back", a=left, b=right)],
        "scale": Scale(metres=1.5),
    }
    return Project(picture="a.jpg", width=WIDTH, height=HEIGHT, perspective=PERSPECTIVE, **{**given, **changes})


def _write(folder: Path, rgb: Any, drawing: Project, depth: Any = None) -> Written:
    return write_folder(folder, rgb, *finish_drawing(drawing, depth), depth)


def _noise(width: int = WIDTH, height: int = HEIGHT) -> NDArray[np.uint8]:
    return np.random.default_rng(0).integers(0, 255, (height, width, 3)).astype(np.uint8)


# any picture


def test_exif_turns_the_picture_and_tells_the_focal_length(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned by a quarter
    exif.get_ifd(0x8769)[0xA405] = 26  # millimetres, as of 35 mm film
    Image.fromarray(_noise(400, 300)).save(tmp_path / "a.jpg", exif=exif)
    photo = read_photo(tmp_path / "a.jpg")
    assert photo.rgb.shape == (400, 300, 3) and photo.shrunk == 1
    assert photo.focal == pytest.approx(26 / np.hypot(36, 24) * 500, rel=1e-6)
    Image.fromarray(_noise(3200, 2400)).save(tmp_path / "b.jpg", exif=exif)
    large = read_photo(tmp_path / "b.jpg")
    assert large.rgb.shape == (LONGEST_SIDE, 1200, 3) and large.shrunk == 2
    assert large.focal == pytest.approx(26 / np.hypot(36, 24) * 2000, rel=1e-3)


def test_focal_length_from_the_sensor_and_nonsense_in_exif(tmp_path: Path) -> None:
    for number, (tags, focal) in enumerate(
        [
            ({0x920A: 5.0, 0xA20E: 2000.0, 0xA210: 2, 0xA002: 800}, 5.0 * 2000 / 25.4 / 2),
            ({0xA405: 0}, None),
            ({0xA405: 60000}, None),
            ({0x920A: 5.0, 0xA20E: 0.0}, None),
        ]
    ):
        exif = Image.Exif()
        exif.get_ifd(0x8769).update(tags)
        Image.fromarray(_noise(400, 300)).save(tmp_path / f"{number}.jpg", exif=exif)
        found = read_photo(tmp_path / f"{number}.jpg").focal
        assert found == (None if focal is None else pytest.approx(focal, rel=1e-3))


@pytest.mark.parametrize("mode", ["RGBA", "CMYK", "L", "P", "I;16", "LA"])
def test_modes_of_pictures(tmp_path: Path, mode: str) -> None:
    deep = Image.fromarray(_noise(64, 48)[..., 0].astype(np.uint16) * 257)
    path = tmp_path / ("a.tif" if mode == "CMYK" else "a.png")
    (deep if mode == "I;16" else Image.fromarray(_noise(64, 48)).convert(mode)).save(path)
    assert read_photo(path).rgb.shape == (48, 64, 3)


@pytest.mark.parametrize("what", ["panorama", "wide", "black", "heic", "tiny", "text", "cut", "none"])
def test_what_is_no_photograph_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    path = tmp_path / "a.png"
    if what == "panorama":
        info = PngImagePlugin.PngInfo()
        info.add_itxt("XML:com.adobe.xmp", '<x GPano:ProjectionType="equirectangular"/>')
        Image.fromarray(_noise(400, 200)).save(path, pnginfo=info)
    elif what == "heic":
        monkeypatch.setitem(sys.modules, "pillow_heif", None)
        path.write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
    elif what == "text":
        path.write_text("no picture")
    elif what == "cut":  # looked at by its header alone, and by what a PNG may have behind its pixels
        Image.fromarray(_noise()).save(path)
        path.write_bytes(path.read_bytes()[:20_000])
        with refused("E-IMAGE-UNREADABLE"):
            check_photo(path)
    elif what != "none":
        size = {"wide": (500, 200), "black": (64, 48), "tiny": (12, 12)}[what]
        Image.fromarray(_noise(*size) * (what != "black")).save(path)
    with pytest.raises(InputError) as caught:
        annotate.run(path, browser=False)
    says = {"wide": "panorama", "black": "one color", "heic": "pillow-heif", "tiny": "too small"}.get(what, what)
    expected = {"text": "not a readable image", "cut": "not a readable image", "none": "no such file"}.get(what, says)
    assert expected in str(caught.value) and "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == ([] if what == "none" else [path])  # no folder was begun


def test_a_pipe_is_no_photograph_and_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.jpg")
    pipe = os.open(tmp_path / "a.jpg", os.O_RDWR)
    os.write(pipe, bytes(100))  # whoever reads gets it, and does not hang
    for read in (read_photo, read_rgb):
        with refused("E-FILE-UNREADABLE", "a.jpg: is no file, but a folder, a pipe or a device"):
            read(tmp_path / "a.jpg")
    assert len(os.read(pipe, 1000)) == 100
    os.close(pipe)


def test_heic_is_read_where_its_library_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
    opened = SimpleNamespace(to_pillow=lambda: Image.fromarray(_noise(64, 48)))
    monkeypatch.setitem(sys.modules, "pillow_heif", SimpleNamespace(open_heif=lambda path: opened))
    assert read_photo(tmp_path / "a.heic").rgb.shape == (48, 64, 3)


# what is written


def test_a_drawing_becomes_an_input_folder(tmp_path: Path) -> None:
    folder = tmp_path / "my kitchen"
    written = _write(folder, _noise(), _drawing())
    assert written.ids == {"cabinet": "cabinet_1", "mug": "mug_1", "shelf": "shelf_1"} and written.notes == []
    assert (
        "my_kitchen-32bc6e: " in (folder / "config.yaml").read_text()
        and "door: null" in (folder / "config.yaml").read_text()
    )
    extract(input=folder, scene="kitchen", out=tmp_path / "out" / "objects.json")
    objects = read_json(Objects, tmp_path / "out" / "objects.json")
    floor_from_camera = np.array(read_json(Camera, folder / "camera.json").floor_from_camera)
    np.testing.assert_allclose(objects.floor_from_camera, floor_from_camera)
    assert floor_from_camera[2, 3] == pytest.approx(1.5)
    (wall,) = objects.walls
    assert abs(wall.offset) == pytest.approx(3.5, abs=0.02)
    for item, mounting in zip(objects.objects, (3, 2, 1), strict=True):
        true = BOXES[item.label]
        assert item.box is not None and item.mounting is not None and item.mounting.type == mounting, item.id
        turned = UprightBox([true.center[1], -true.center[0], true.center[2]], true.size, -np.pi / 2)  # type: ignore[index]
        assert oriented_iou(UprightBox(item.box.center, item.box.size, item.box.yaw), turned) > 0.9, item.id
        assert item.front == pytest.approx(np.pi)  # towards the camera: x of the floor frame runs along the view
        cloud = np.load(tmp_path / "out" / "clouds.npz")[item.id]
        np.testing.assert_allclose((cloud.max(axis=0) + cloud.min(axis=0)) / 2, item.box.center, atol=0.01)


def test_what_was_drawn_as_front_may_be_a_side(tmp_path: Path) -> None:
    drawing = _drawing()
    for item, side in zip(drawing.objects, ("left", "right", "rear"), strict=True):
        item.faces = side  # type: ignore[assignment]
    _write(tmp_path, _noise(), drawing)
    said = read_json(Annotations, tmp_path / "annotations.json").objects
    assert [item.front for item in said] == pytest.approx([np.pi / 2, -np.pi / 2, 0.0])
    drawing.objects[1].round = True
    drawing.objects[1].points.pop()
    _write(tmp_path, _noise(), drawing)
    assert read_json(Annotations, tmp_path / "annotations.json").objects[1].front is None


def test_depth_and_masks_show_the_nearest(tmp_path: Path) -> None:
    drawing = _drawing()
    painted = paint(drawing, solve(drawing))
    assert painted.values == {"cabinet": 1, "mug": 2, "shelf": 3, "floor": 4, "back": 5}
    for name, box in BOXES.items():
        (u, v), front = _pixels([np.asarray(box.center) * [1, 0, 1] + [0, box.center[1] - box.size[1] / 2, 0]])[0], box  # type: ignore[index]
        assert painted.masks[round(v), round(u)] == painted.values[name]
        point = np.append(VIEW.rays((round(u), round(v))), 1)[:3] * painted.depth[round(v), round(u)] + [0, 0, 1.5]
        assert point[1] == pytest.approx(front.center[1] - front.size[1] / 2, abs=0.03), name  # type: ignore[index]
    sparse = paint(drawing, solve(drawing), 3)
    np.testing.assert_array_equal(sparse.masks, painted.masks[::3, ::3])
    np.testing.assert_allclose(sparse.depth, painted.depth[::3, ::3])
    assert painted.masks[235, 160] == 4 and painted.masks[5, 160] == 5
    outline = _pixels([[-0.7, 2.9, 0.1], [-0.5, 2.9, 0.1], [-0.5, 2.9, 0.4], [-0.7, 2.9, 0.4]])
    drawing.objects[0].outline = outline
    masks = paint(drawing, solve(drawing)).masks
    u, v = np.mean(outline, axis=0).round().astype(int)
    assert masks[v, u] == 1 and 0 < (masks == 1).sum() < 0.4 * (painted.masks == 1).sum()
    assert (masks[v, : u - 40] != 1).all()
    whole = (masks == 1).sum()
    drawing.objects[0].pieces = [[(x + 20, y) for x, y in outline]]  # a leg stands before it
    masks = paint(drawing, solve(drawing)).masks
    assert masks[v, u] == masks[v, u + 20] == 1 and (masks == 1).sum() == pytest.approx(2 * whole, rel=0.05)


def test_an_outline_beside_its_box_shows_the_thing_all_the_same() -> None:
    drawing = _drawing(walls=[])
    plain = paint(drawing, solve(drawing))
    high = _pixels([[-0.9, 2.9, 0], [-0.1, 2.9, 0], [-0.1, 2.9, 1.1], [-0.9, 2.9, 1.1]])  # by a fifth too high
    drawing.objects = drawing.objects[:1]
    drawing.objects[0].outline = high
    painted = paint(drawing, solve(drawing))
    u, v = np.rint(_pixels([[-0.3, 2.9, 1.05]])[0]).astype(int)
    assert plain.masks[v, u] != 1 and painted.masks[v, u] == 1
    assert painted.depth[v, u] == pytest.approx(painted.depth[v + 20, u], rel=0.2)
    drawing.objects[0].outline = _pixels([[3, 4, 0], [3.2, 4, 0], [3.2, 4, 0.2]])  # far from it
    assert 1 not in paint(drawing, solve(drawing)).masks
    reach, outline = np.full((4, 4), np.inf), np.zeros((4, 4), bool)
    reach[2:, :2], outline[:2, 2:] = 2.0, True
    assert (extend(reach, outline) == reach).all(), "nor where its box lies in a corner of the picture"


@pytest.mark.parametrize(("cabinet", "mug"), [(0, 1), (-1, 0)])
def test_a_person_says_which_lies_in_front(cabinet: int, mug: int) -> None:
    drawing = _drawing()
    plain = paint(drawing, solve(drawing)).masks == 2
    drawing.objects[0].outline = _pixels([[-0.9, 2.9, 0], [-0.1, 2.9, 0], [-0.1, 2.9, 1.3], [-0.9, 2.9, 1.3]])
    assert 2 not in paint(drawing, solve(drawing)).masks, "an outline lies over every box"
    drawing.objects[0].layer, drawing.objects[1].layer = cabinet, mug
    assert ((paint(drawing, solve(drawing)).masks == 2) == plain).all()


def test_a_doubted_thing_may_be_put_on_what_its_foot_is_seen_on_unless_it_is() -> None:
    drawing = _drawing()
    cabinet, mug = drawing.objects[:2]
    assert mug.on == cabinet.id and find_carriers(drawing, solve(drawing), [mug.id]) == {}
    mug.on = "floor"
    assert find_carriers(drawing, solve(drawing), [mug.id]) == {mug.id: cabinet.id}
    assert find_carriers(drawing, solve(drawing), []) == {}


def test_round_things_are_round(tmp_path: Path) -> None:
    drawing = _drawing()
    mug = drawing.objects[1]
    mug.round, mug.points = True, _pixels([[-0.6, 3.1, 0.9], [-0.4, 3.1, 0.9], [-0.5, 3.1, 1.1]])
    masks = paint(drawing, solve(drawing)).masks == 2
    across = np.flatnonzero(masks.any(axis=0))
    assert np.ptp(across) + 1 == pytest.approx(mug.points[1][0] - mug.points[0][0], abs=2), "no wider than its foot"
    _write(tmp_path, _noise(), drawing)
    extract(input=tmp_path, scene="drawn", out=tmp_path / "out" / "objects.json")
    clouds, width = np.load(tmp_path / "out" / "clouds.npz"), solve(drawing).boxes["mug"].size[0]  # type: ignore[index]
    farthest = {}
    for item in read_json(Objects, tmp_path / "out" / "objects.json").objects:
        assert item.box is not None
        plan = clouds[item.id][:, :2] - item.box.center[:2]
        farthest[item.id] = np.linalg.norm(plan, axis=1).max() / (max(item.box.size[:2]) / 2)
    assert width == pytest.approx(0.2, abs=0.01)
    assert farthest["mug_1"] == pytest.approx(1, abs=0.01) and farthest["cabinet_1"] > 1.2, "the corners of a box"


def test_what_stands_at_the_rear_edge_of_a_top_is_on_it_not_on_the_wall(tmp_path: Path) -> None:
    drawing = _drawing()
    solved = solve(drawing)
    rear = _pixels([[-0.8, 3.5, 0.9]])[0]
    for beside in (-8, -3, 3):  # a worktop is 5 cm thick, 4 pixels here
        assert support_at(solved, (rear[0], rear[1] + beside)) == "cabinet"
    assert support_at(solved, (rear[0], rear[1] - 30)) == "back"
    assert support_at(solved, (rear[0], rear[1] - 11)) == "back"
    assert support_at(solved, (rear[0], rear[1] - 10), stands=True) == "cabinet", "a jar hangs nowhere"
    assert support_at(solved, (rear[0], rear[1] - 30), stands=True) == "floor"
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")
    asked = {"project": drawing.model_dump(mode="json"), "pixel": (rear[0], rear[1] - 30)}
    assert session.support(asked) == {"on": "back"} and session.support(asked | {"stands": True}) == {"on": "floor"}


@pytest.mark.parametrize("unsure", [False, True])
def test_what_a_person_hung_hangs_although_something_stands_right_below_it(tmp_path: Path, unsure: bool) -> None:
    drawing = _drawing()
    above = _pixels(corners(UprightBox([-0.5, 3.35, 1.05], [0.7, 0.3, 0.3], 0.0)))
    hung = drawing.objects[2]
    hung.points, hung.unsure, hung.label = [above[k] for k in (0, 5, 7)], unsure, "microwave"
    _write(tmp_path, _noise(), drawing)
    extract(input=tmp_path, scene="drawn", out=tmp_path / "out" / "objects.json")
    found = read_json(Objects, tmp_path / "out" / "objects.json").objects[2]
    assert found.mounting is not None and found.mounting.type == (3 if unsure else 1)


def test_what_stands_far_back_on_a_top_of_guessed_depth_is_put_onto_it() -> None:
    deep, oven = (
        UprightBox([-0.5, 3.5, 0.6], [1.2, 1.2, 1.2], 0.0),
        UprightBox([-0.5, 3.95, 1.35], [0.5, 0.3, 0.3], 0.0),
    )
    front = {name: [_pixels(corners(box))[k] for k in (0, 1, 4)] for name, box in (("deep", deep), ("oven", oven))}
    drawing = _drawing(walls=[], objects=[DrawnObject(id="deep", label="cabinet", points=front["deep"])])
    foot = front["oven"][0]
    solved = solve(drawing)
    assert solved.boxes["deep"].size[1] < 0.8 and support_at(solved, foot) == "deep"
    assert support_at(solved, (foot[0] - 60, foot[1])) == "floor", "beside it"
    assert support_at(solved, (foot[0], foot[1] - 20)) == "floor", "far behind it"
    drawing.objects.append(DrawnObject(id="oven", label="microwave", on="deep", points=front["oven"]))
    solved = solve(drawing)
    carrier, box = solved.boxes["deep"], solved.boxes["oven"]
    assert box.bottom == pytest.approx(carrier.top) and abs(box.center[1] - carrier.center[1]) < carrier.size[1] / 2
    assert 0.3 < box.size[0] < 0.5 and "nearer" in solved.notes["oven"]
    drawing.objects[0].points.append(_pixels(corners(deep))[6])  # a rear corner tells how deep it is
    assert solve(drawing).boxes["oven"].size[0] == pytest.approx(0.5, abs=0.02)


def test_sizes_that_cannot_be_are_doubted() -> None:
    drawing = _drawing()
    assert solve(drawing).notes == {}
    cabinet, mug, shelf = drawing.objects
    cabinet.depth, mug.label, shelf.label = 2.5, "gizmo", "gizmo"
    assert (
        "is 80 wide × 250 deep × 90 cm high; usual are 30 to 65 wide × 40 to 143 deep"
        in solve(drawing).notes["cabinet"]
    )
    shelf.points[1] = (shelf.points[1][0], shelf.points[0][1])
    assert "mm thin: draw it anew" in solve(drawing).notes["shelf"]
    assert "mug" not in solve(drawing).notes, "of no category of ours"


def test_what_networks_found_is_told_until_a_person_has_looked() -> None:
    drawing = _drawing()
    drawing.objects[0].unsure = True
    assert solve(drawing).notes == {"cabinet": UNSURE}
    assert Project.model_validate(drawing.model_dump(mode="json")).objects[0].unsure


def test_what_hangs_is_as_deep_as_things_of_its_name() -> None:
    drawing = _drawing()
    shelf = drawing.objects[2]
    flat = shelf.model_copy(update={"points": shelf.points[:2]})
    depths = {}
    for label in ("", "wall cabinet", "mirror"):
        named = flat.model_copy(update={"label": label})
        solved = solve(drawing.model_copy(update={"objects": [named]}))
        depths[label] = float(np.asarray(solved.boxes["shelf"].size)[1])
        assert "depth is guessed" in solved.notes["shelf"] and "shelf" in solved.guessed
    assert depths[""] == pytest.approx(0.03) and depths["mirror"] < 0.1 < 0.25 < depths["wall cabinet"]


def test_an_edge_in_the_place_of_two_opposite_corners_is_told() -> None:
    shelf = _drawing().objects[2]
    (u, v), (right, _) = shelf.points[:2]
    edge = shelf.model_copy(update={"points": [(u, v), (right, v + 0.5)]})
    solved = solve(_drawing(objects=[edge]))
    assert "two opposite corners" in solved.notes["shelf"] and solved.doubts["shelf"][0].cause == "size"
    assert "two opposite corners" not in solve(_drawing(objects=[shelf])).notes.get("shelf", "")


def test_a_guessed_depth_does_not_hide_an_unusual_size(tmp_path: Path) -> None:
    drawing = _drawing()
    cabinet = drawing.objects[0]
    bare = cabinet.model_copy(update={"points": cabinet.points[:3], "label": "mug"})
    note = solve(drawing.model_copy(update={"objects": [bare]})).notes["cabinet"]
    assert "depth is guessed" in note and "usual are" in note
    named = [item.model_copy(update={"label": ""}) if item.id == "mug" else item for item in drawing.objects]
    notes = _write(tmp_path / "a", _noise(), drawing.model_copy(update={"objects": named})).notes
    assert "object_1: has no name: cousins are sought by its looks alone" in notes


def test_walls_end_where_they_meet() -> None:
    """A corner that juts into the room: behind it the one wall goes on, beyond its end the other is not there."""
    left, corner = _pixels([[-2, 3, 0], [0.3, 3, 0]])
    front, rear = _pixels([[0.3, 3.02, 0], [0.3, 5, 0]])
    walls = [DrawnWall(id="near", a=left, b=corner), DrawnWall(id="side", a=front, b=rear)]
    drawing = _drawing(objects=[], walls=walls)
    solved = solve(drawing)
    low, high = solved.walls["near"].ends
    at = float(np.array([0.3, 3, 0]) @ solved.walls["near"].along)
    assert sorted(map(abs, (low, high))) == [pytest.approx(0.3, abs=0.02), np.inf] and at == pytest.approx(
        high if np.isfinite(high) else low, abs=0.02
    )
    beyond, on_it = _pixels([[0.8, 3, 1.5], [-0.5, 3, 1.5]])
    reach = [float(solved.walls["near"].reach(solved.view.rays(pixel))) for pixel in (beyond, on_it)]
    assert reach[0] == np.inf and np.isfinite(reach[1])
    painted = paint(drawing, solved)
    u, v = np.rint(beyond).astype(int)
    assert painted.masks[v, u] != painted.values["near"]
    crossed = DrawnWall(id="across", a=_pixels([[-1, 2, 0]])[0], b=_pixels([[-1, 5, 0]])[0])
    parted = solve(_drawing(objects=[], walls=[walls[0], crossed]))
    assert parted.walls["near"].ends == (-np.inf, np.inf)  # what crosses its middle ends nothing


def test_lines_that_do_not_run_as_the_camera_says_are_told() -> None:
    along = [_pixels([[x, 2, 0], [x, 4, 0]]) for x in (-1.0, -0.5, 0.5, 1.0)]
    guides = [Guide(axis="y", a=a, b=b) for a, b in [*along, _pixels([[1, 2, 0], [2, 4, 0]])]]
    drawing = _drawing().model_copy(update={"perspective": PERSPECTIVE.model_copy(update={"guides": guides})})
    assert find_weak_lines(VIEW, guides) == [False] * 4 + [True] and find_weak_lines(VIEW, []) == []
    assert describe_room(drawing, solve(drawing))["weak"] == [False] * 4 + [True]


def test_what_was_drawn_keeps_its_size_wherever_it_stands(tmp_path: Path) -> None:
    drawing = _drawing()
    aside = _pixels(corners(UprightBox([0.1, 3.1, 0.96], [0.12, 0.12, 0.12], 0.0)))
    drawing.objects[1].points = [aside[k] for k in (0, 1, 4, 6)]  # beside the cabinet, in the air
    drawing.objects[0].points.pop()
    drawing.objects[2].points.pop()
    _write(tmp_path, _noise(), drawing)
    extract(input=tmp_path, scene="drawn", out=tmp_path / "out" / "objects.json")
    found = {item.id: item for item in read_json(Objects, tmp_path / "out" / "objects.json").objects}
    assert found["mug_1"].box is not None
    assert found["mug_1"].box.size == pytest.approx(BOXES["mug"].size, abs=0.02), "not down to the floor"
    assert [item.whole for item in found.values()] == [False, True, False], "depths without a rear corner are guessed"
    assert [[one.cause for one in item.doubts] for item in found.values()] == [["size"], ["place"], ["size"]]
    assert "doubts" not in Annotation(mask=1, label="cup").model_dump(), "files without doubts stay the same bytes"
    drawing.objects[0].depth = 0.6
    _write(tmp_path, _noise(), drawing)
    assert not read_json(Annotations, tmp_path / "annotations.json").objects[0].guessed


def test_why_nothing_of_a_drawing_makes_a_scene_is_told(tmp_path: Path) -> None:
    (cabinet, *_) = _drawing().objects
    outside = cabinet.model_copy(update={"outline": [(-30.0, -30.0), (-20.0, -30.0), (-20.0, -20.0)]})
    in_the_sky = cabinet.model_copy(update={"points": [(10.0, 5.0), (40.0, 5.0), (25.0, 1.0)]})
    for item, why in ((outside, "no object can be seen"), (in_the_sky, "no object has a place yet")):
        with refused("E-SCENE-EMPTY", why):
            _write(tmp_path, _noise(), _drawing(objects=[item]))


def test_given_depth_is_kept_and_gives_the_scale(tmp_path: Path) -> None:
    true = paint(_drawing(), solve(_drawing())).depth
    drawing = _drawing(scale=Scale(kind="depth", metres=9.0))
    noisy = np.where(true > 0, true * np.random.default_rng(0).normal(1, 0.01, true.shape), 0).astype(np.float32)
    _write(tmp_path, _noise(), drawing, noisy)
    np.testing.assert_array_equal(np.load(tmp_path / "depth.npz")["depth"], noisy)
    assert np.array(read_json(Camera, tmp_path / "camera.json").floor_from_camera)[2, 3] == pytest.approx(1.5, rel=0.01)
    with refused("E-SCALE-UNKNOWN"):
        _write(tmp_path, _noise(), drawing, np.zeros_like(true))
    with refused("E-SCALE-UNKNOWN"):
        _write(tmp_path, _noise(), drawing)
    assert at_size(true[::2, ::2], WIDTH, HEIGHT).shape == true.shape
    with refused("E-DEPTH-SIZE"):
        at_size(true[:, ::2], WIDTH, HEIGHT)


def test_nothing_drawn_and_nothing_seen_write_nothing(tmp_path: Path) -> None:
    hidden = _drawing().objects[:1]
    hidden[0].points = [(u + 5000, v) for u, v in hidden[0].points]
    for objects in ([], hidden):
        with refused("E-SCENE-EMPTY"):
            _write(tmp_path / "out", _noise(), _drawing(objects=objects))
    assert not (tmp_path / "out").exists()


def test_a_box_needs_the_camera_over_the_floor(tmp_path: Path) -> None:
    _write(tmp_path, _noise(), _drawing())
    camera = json.loads((tmp_path / "camera.json").read_text())
    write_json(tmp_path / "camera.json", {**camera, "floor_from_camera": None})
    with pytest.raises(InputError, match="floor_from_camera"):
        extract(input=tmp_path, scene="x", out=tmp_path / "out.json")
    camera["floor_from_camera"][2][3] = -1.0
    write_json(tmp_path / "camera.json", camera)
    with pytest.raises(InputError, match="not above the floor"):
        extract(input=tmp_path, scene="x", out=tmp_path / "out.json")


def test_a_known_camera_alone_frames_a_picture_without_floor(tmp_path: Path) -> None:
    _write(tmp_path, _noise(), _drawing())
    said = json.loads((tmp_path / "annotations.json").read_text())
    for item in said["objects"]:
        del item["box"], item["front"]
    write_json(tmp_path / "annotations.json", {**said, "floor": None})
    extract(input=tmp_path, scene="x", out=tmp_path / "out" / "objects.json")
    objects = read_json(Objects, tmp_path / "out" / "objects.json")
    assert transform_points(objects.floor_from_camera, [0, 0, 0])[2] == pytest.approx(1.5)
    assert objects.objects[0].box is not None and objects.objects[0].box.size[2] == pytest.approx(0.9, abs=0.03)


def test_a_foot_marked_too_high_is_put_onto_what_carries_it() -> None:
    drawing = _drawing()
    mug = drawing.objects[1]
    mug.points = [(u, v - 9) for u, v in mug.points[:2]] + list(mug.points[2:3])  # far beyond the cabinet
    solved = solve(drawing)
    box, carrier = solved.boxes["mug"], solved.boxes["cabinet"]
    assert "its base lay beyond what it stands on" in solved.notes["mug"]
    assert box.bottom == pytest.approx(carrier.top) and box.top == pytest.approx(BOXES["mug"].top, abs=0.06)
    away = np.linalg.norm(BOXES["mug"].center)
    assert np.linalg.norm(np.subtract(box.center, BOXES["mug"].center)) < 0.12 * away
    mug.points = [(u + 150, v) for u, v in mug.points]  # beside it
    assert "is that deep enough" in solve(drawing).notes["mug"]


def test_a_rear_corner_beyond_what_carries_it_does_not_spoil_the_rest() -> None:
    """Just below the eye a pixel is many centimetres: the corner then lies metres behind."""
    cabinet = UprightBox([-0.5, 3.2, 0.7], [0.8, 0.6, 1.4], 0.0)
    box = UprightBox([-0.5, 3.15, 1.55], [0.5, 0.4, 0.3], 0.0)
    marks = {name: _pixels(corners(solid)) for name, solid in (("cabinet", cabinet), ("oven", box))}
    drawing = _drawing(
        objects=[
            DrawnObject(id=name, label=name, on=on, points=[marks[name][k] for k in (0, 1, 4, 6)])
            for name, on in (("cabinet", "floor"), ("oven", "cabinet"))
        ]
    )
    assert solve(drawing).boxes["oven"].size == pytest.approx(box.size, abs=0.02)
    oven = drawing.objects[1]
    (u, v), exact, usual = oven.points[3], oven.points[:3], np.median(sizes_of("oven")[:, 0])
    for corner in ((u - 20, v), (u + 10, v)):  # both would be more than a metre deep
        oven.points = [*exact, corner]
        solved = solve(drawing)
        assert solved.notes["oven"].startswith("its rear corner lay beyond what it stands on")
        assert "oven" in solved.guessed and solved.boxes["oven"].size == pytest.approx([0.5, usual, 0.3], abs=0.02)


def test_an_absurd_size_is_told_with_the_usual_one_which_can_be_taken() -> None:
    drawing = _drawing()
    cabinet = drawing.objects[0]
    cabinet.label, cabinet.points = "cabinet", cabinet.points[:3]
    assert solve(drawing).usual == {}
    cabinet.depth = 0.006
    solved = solve(drawing)
    assert "usual are" in solved.notes["cabinet"]
    width, depth, height = solved.usual["cabinet"]
    assert "worktop" not in solved.notes["cabinet"] and "hang" not in solved.notes["cabinet"]
    assert (width, height) == (None, None), "what is as usual stays as it was drawn"
    assert depth == pytest.approx(np.median(sizes_of("bottom cabinet")[:, 0]), abs=0.01)
    cabinet.depth = depth
    solved = solve(drawing)
    assert solved.usual == {} and "usual" not in solved.notes.get("cabinet", "")
    mug, shelf = drawing.objects[1:]
    mug.height, shelf.label = 0.7, "microwave"
    solved = solve(drawing)
    assert solved.notes["mug"].endswith("is what it stands on drawn up to its worktop?")
    assert solved.notes["shelf"].endswith("does it hang on that wall?") and {"mug", "shelf"} == set(solved.usual)
    shelf.label, mug.height = "shelf", None
    cabinet.label, cabinet.depth = "gearbox", 0.006
    assert solve(drawing).usual == {}, "nobody knows how large such things are"


@pytest.mark.parametrize("times", [1.0, 1.4, 0.6])
def test_a_camera_height_that_nobody_gave_is_doubted_if_most_things_are_wrong_by_one_factor(times: float) -> None:
    def room(scale: Scale) -> Project:
        drawing = _drawing(scale=scale)
        for name, size in (("table", [0.9, 0.9, 0.73]), ("chair", [0.5, 0.5, 0.93])):
            box = UprightBox([0.8 if name == "chair" else -0.6, 3, size[2] / 2], size, 0.0)
            points = [_pixels(corners(box), 1.5 / times)[k] for k in (0, 1, 4)]
            drawing.objects.append(DrawnObject(id=name, label=name, points=points))
        drawing.objects = drawing.objects[3:]
        return drawing

    solved = solve(room(Scale()))
    assert solved.boxes["table"].size[2] == pytest.approx(0.73 * times, rel=0.02)
    if times == 1:
        assert solved.factor is None
    else:
        assert solved.factor == pytest.approx(1 / times, rel=0.05)
        assert solved.usual == {} and not any("usual" in note for note in solved.notes.values()), "it is told once"
        taken = solve(room(Scale(metres=1.5 * solved.factor)))
        assert taken.factor is None and taken.boxes["table"].size[2] == pytest.approx(0.73, rel=0.05)
    assert solve(room(Scale(metres=1.5))).factor is None, "who gave a height is not asked"
    one = room(Scale())
    one.objects = one.objects[:1]
    assert solve(one).factor == (None if times == 1 else pytest.approx(1 / times, rel=0.05))
    (u, v), low = one.objects[0].points[2], one.objects[0].points[0]
    one.objects[0].points[2] = (u, v + 0.12 * (v - low[1]))
    assert times != 1 or solve(one).factor is None, "one thing may be drawn a little wrongly"


def test_a_guessed_depth_ends_at_the_wall_behind() -> None:
    """Walls are pixels, a guess is metres: a height of the camera that is taken later must not part them."""
    drawing = _drawing()
    cabinet = drawing.objects[0]
    cabinet.label, cabinet.points = "", cabinet.points[:3]
    for metres, depth in ((1.5, 0.6), (1.2, 0.48), (2.0, 0.6)):
        drawing.scale.metres = metres
        solved = solve(drawing)
        assert solved.boxes["cabinet"].size[1] == pytest.approx(depth, abs=0.01) and "cabinet" in solved.guessed
    cabinet.label = "cabinet"
    assert solve(drawing).boxes["cabinet"].size[1] == pytest.approx(np.median(sizes_of("cabinet")[:, 0]))
    cabinet.depth = 0.6
    drawing.scale.metres = 1.2
    assert solve(drawing).boxes["cabinet"].size[1] == 0.6, "what was typed stays"


def test_what_the_picture_does_not_show_is_told_at_once(tmp_path: Path) -> None:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")
    drawing = _drawing()
    assert not any("nothing of it" in note for note in session.solve(drawing.model_dump(mode="json"))["notes"].values())
    behind = UprightBox([-0.5, 4.2, 0.3], [0.3, 0.3, 0.3], 0.0)  # the wall is nearer
    points = [_pixels(corners(behind))[k] for k in (0, 1, 4, 6)]
    drawing.objects.append(DrawnObject(id="far", label="box", points=points))
    assert "nothing of it would be seen" in session.solve(drawing.model_dump(mode="json"))["notes"]["far"]


def test_how_many_doors_and_drawers_is_asked_of_what_opens(tmp_path: Path) -> None:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")
    drawing = _drawing()
    cabinet = drawing.objects[0]
    for cabinet.articulated, cabinet.doors in ((True, 0), (True, 2), (False, 0)):
        asked = cabinet.articulated and not cabinet.doors
        body = drawing.model_dump(mode="json")
        assert (UNCOUNTED in session.solve(body)["notes"].get("cabinet", "")) == asked
        assert (f"cabinet_1: {UNCOUNTED}" in session.write(body)["notes"]) == asked


# the server


@pytest.fixture
def served(tmp_path: Path) -> Iterator[tuple[PageServer, Session]]:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "out", ["mug"])
    server = serve(session)
    yield server, session
    server.shutdown()
    server.server_close()


def _ask(server: PageServer, method: str, path: str, body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
    link = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    link.putrequest(method, path, skip_host="Host" in headers)
    if body is not None:
        headers = {"Content_Type": "application/json", "Content_Length": str(len(body)), **headers}
    for name, value in headers.items():
        link.putheader(name.replace("_", "-"), value)
    link.endheaders(body)
    reply = link.getresponse()
    answer = reply.status, reply.read()
    link.close()
    return answer


def test_only_its_own_page_and_names_are_answered(served: tuple[PageServer, Session]) -> None:
    server, session = served
    base = f"/{server.token}/"
    assert server.server_address[0] == "127.0.0.1" and len(server.token) >= 32
    for name in ("", "page.js", "state.js", "canvas.js", "drawing.js", "tools.js", "page.css", "picture.jpg", "start"):
        assert _ask(server, "GET", base + name)[0] == 200, name
    strangers = ["/", "/start", "//start", f"/{server.token}", f"/{server.token[:-1]}/start", base + "../server.py"]
    strangers += [
        base + "server.py",
        base + "..%2fserver.py",
        base + "/etc/passwd",
        base + "project.json",
        base + "%00",
    ]
    for path in strangers:
        status, body = _ask(server, "GET", path)
        assert status == 404, path
        assert b"class" not in body and b"root" not in body
    assert _ask(server, "GET", base + "start", Host="evil.example")[0] == 404
    assert _ask(server, "POST", base + "close", b"{}", Origin="http://evil.example")[0] == 404
    assert _ask(server, "POST", base + "close", b"{}", Content_Type="text/plain")[0] == 415
    assert not session.finished
    assert _ask(server, "DELETE", base + "start")[0] == 501


def test_a_full_disk_is_told_to_the_page(
    served: tuple[PageServer, Session], capsys: pytest.CaptureFixture[str]
) -> None:
    server, session = served

    def full(_: Any = None) -> Any:
        raise OSError(errno.ENOSPC, "x", "project.json")

    session.save = session.start = full  # type: ignore[method-assign]
    for method, name, body in (("POST", "save", b"{}"), ("GET", "start", None)):
        status, answer = _ask(server, method, f"/{server.token}/{name}", body)
        assert status == 500 and b"project.json: No space left on device" in answer
    assert capsys.readouterr().err.count("error: project.json: No space left on device") == 2
    assert _ask(server, "GET", f"/{server.token}/")[0] == 200


def test_the_older_of_two_tabs_cannot_overwrite(served: tuple[PageServer, Session]) -> None:
    server, _ = served
    base = f"/{server.token}/"
    older, newer = (json.loads(_ask(server, "GET", base + "start")[1]) for _ in range(2))
    body = json.dumps(older["project"]).encode()
    for headers in ({"X_Page": str(older["page"])}, {}):
        for command in ("save", "write"):
            status, answer = _ask(server, "POST", base + command, body, **headers)
            assert status == 409 and "another tab" in json.loads(answer)["error"]
    assert _ask(server, "POST", base + "save", body, X_Page=str(newer["page"]))[0] == 200


def test_hostile_drawings_are_refused_in_a_line(served: tuple[PageServer, Session]) -> None:
    server, session = served
    base = f"/{server.token}/"
    good = json.loads(_ask(server, "GET", base + "start")[1])["project"]
    evil = [
        (b"no json", 400),
        (b"[" * 100_000, 400),
        (b'{"version": 1}', 400),
        (json.dumps({**good, "extra": 1}).encode(), 400),
        (json.dumps({**good, "width": 10}).encode(), 400),
        (json.dumps({**good, "objects": [{"id": "../../x", "points": [[0, 0], [1, 1]]}]}).encode(), 400),
        (json.dumps({**good, "objects": [{"id": "x", "points": [[1e300, 0], [1, 1]]}]}).encode(), 400),
        (json.dumps({**good, "scale": {"metres": -1}}).encode(), 400),
        (b'{"a": NaN}', 400),
    ]
    for command in ("solve", "save", "write", "support"):
        for body, status in evil:
            found, answer = _ask(server, "POST", base + command, body)
            assert found == status and "\n" not in json.loads(answer)["error"], (command, body[:40])
    assert (
        _ask(server, "POST", base + "save", None, Content_Length="99999999999", Content_Type="application/json")[0]
        == 413
    )
    for length in ("-5", "\xb2", "1" * 5000, "1_0", " 3 3", ""):
        told = {"Content_Length": length, "Content_Type": "application/json"}
        status, answer = _ask(server, "POST", base + "save", None, **told)
        assert status == 400 and "\n" not in json.loads(answer)["error"], length
    assert not session.folder.exists()
    assert _ask(server, "POST", base + "save", json.dumps(good).encode())[0] == 200
    assert [path.name for path in session.folder.iterdir()] == [PROJECT]


def test_no_drawing_breaks_the_answer(tmp_path: Path) -> None:
    """Pixels anywhere, lines of no length, walls through the camera: an answer in plain JSON all the same."""
    rng = np.random.default_rng(0)
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")

    def pixel() -> tuple[float, float]:
        scale = 10 ** rng.uniform(2, 6)
        return (160.0, 120.0) if rng.random() < 0.1 else tuple(rng.uniform(-scale, scale, 2).tolist())

    for _ in range(20):
        names = [f"object_{k}" for k in range(6)]
        drawing = _drawing(
            walls=[DrawnWall(id=name, a=pixel(), b=pixel(), free=rng.random() < 0.5) for name in ("back", "left")],
            objects=[
                DrawnObject(
                    id=name,
                    on=str(rng.choice(["floor", "back", "left", *names])),
                    points=[pixel() for _ in range(rng.integers(2, 5))],
                    round=bool(rng.random() < 0.3),
                )
                for name in names
            ],
            scale=Scale(kind="floor", metres=10 ** rng.uniform(-3, 1), points=(pixel(), pixel())),
        )
        json.dumps(session.solve(drawing.model_dump(mode="json")), allow_nan=False)


def test_a_saved_drawing_is_opened_again_or_refused(tmp_path: Path) -> None:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")
    session.save(_drawing().model_dump(mode="json"))
    drawn = _drawing().model_copy(update={"digest": session.photo.digest, "picture": "a.png"})
    assert Session(session.photo, "a.png", tmp_path / "a").open_drawing() == drawn
    (tmp_path / "a" / PROJECT).write_text("{")
    with pytest.raises(InputError, match=PROJECT):
        annotate.run(tmp_path / "a.png", browser=False)
    (tmp_path / "file").touch()
    with refused("E-OUTPUT-FOLDER"):
        annotate.run(tmp_path / "a.png", out=tmp_path / "file", browser=False)


def test_another_picture_of_the_same_name_gets_a_drawing_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also one of the same size; the first one comes back with its picture."""
    image, path = tmp_path / "a.png", tmp_path / "a" / PROJECT
    Image.fromarray(_noise()).save(image)
    first = Session(read_photo(image), "a.png", tmp_path / "a")
    first.save(_drawing().model_dump(mode="json"))
    kept, bytes_before = path.read_bytes(), image.read_bytes()
    Image.fromarray(_noise()[:, ::-1]).save(image)
    other = Session(read_photo(image), "a.png", tmp_path / "a")
    assert other.open_drawing() == other.start_drawing() and other.start()["project"]["objects"] == []
    other.save(other.start_drawing().model_dump(mode="json"))
    assert path.read_bytes() == kept and other.kept.path == path.with_suffix(f".{other.photo.digest[:8]}.json")
    made = Path("results/photo/a")  # where networks drew into it, beside what a person did to the first one
    monkeypatch.chdir(tmp_path)
    write_json(made / PROJECT, other.start_drawing().model_copy(update={"untouched": True, "walls": _drawing().walls}))
    write_json(Path("hand/a", PROJECT), json.loads(kept))
    there = Session(read_photo(image), "a.png", made)
    assert there.open_drawing().walls == _drawing().walls and there.kept.path == Path("hand/a", other.kept.path.name)
    monkeypatch.setattr(PageServer, "serve_forever", lambda *_, **__: None)
    annotate.run(image, browser=False)
    assert f"{path}: is of another picture: kept, not opened" in capsys.readouterr().out
    with refused("E-PROJECT-PICTURE"):
        other.save(json.loads(kept))
    image.write_bytes(bytes_before)
    assert Session(read_photo(image), "a.png", tmp_path / "a").open_drawing().objects == _drawing().objects


def test_a_folder_of_another_picture_is_not_opened(tmp_path: Path) -> None:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    camera = Camera(width=80, height=60, intrinsics=[[60, 0, 40], [0, 60, 30], [0, 0, 1]], digest="a" * 64)
    write_json(tmp_path / "a/camera.json", camera)
    with refused("E-PICTURE-OTHER", "give another --out"):
        Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "a")


def test_the_command_serves_until_the_page_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Image.fromarray(_noise()).save(tmp_path / "a.png")
    (tmp_path / "depth.npz").parent.mkdir(exist_ok=True)
    np.savez(tmp_path / "depth.npz", depth=paint(_drawing(), solve(_drawing())).depth)

    def visit(address: str) -> None:
        host, port, token = address.removeprefix("http://").replace(":", "/").split("/")[:3]
        link = http.client.HTTPConnection(host, int(port), timeout=10)

        def post(name: str, body: Any) -> None:
            link.request("POST", f"/{token}/{name}", json.dumps(body), {"Content-Type": "application/json"})
            assert link.getresponse().read() is not None

        from threading import Thread

        drawing = _drawing(scale=Scale(kind="depth")).model_dump(mode="json")
        Thread(target=lambda: (post("write", drawing), post("close", {})), daemon=True).start()

    monkeypatch.setattr("webbrowser.open", visit)
    annotate.run(tmp_path / "a.png", depth=tmp_path / "depth.npz")
    said = capsys.readouterr().out
    assert "Draw at http://127.0.0.1:" in said and "an input folder with 3 objects" in said
    assert len(read_json(Annotations, tmp_path / "a" / "annotations.json").objects) == 3


def test_outside_the_clone_the_command_goes_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(_noise()).save("a.png")
    session = Session(read_photo(tmp_path / "a.png"), "a.png", Path("shelf"))
    said = session.write(_drawing().model_dump(mode="json"))
    assert (
        said["command"].startswith("cd ") and f"--configfile {tmp_path}/shelf/config.yaml -- pages" in said["command"]
    )
    assert f"shelf: {tmp_path}/shelf" in Path("shelf/config.yaml").read_text(), "what is relative is so to the clone"
