"""What networks found, corrected by hand: without a browser what comes of it, in one what a person does."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image
from pydantic import ValidationError

from roomkin.plugins.annotator import annotate
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.said import ShownPicture, ShownThing
from roomkin.plugins.annotator.tests.annotate_page import wait_for, watched
from roomkin.plugins.annotator.tests.corrected_scene import read_told_to
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.stages.contracts import Camera, InputError, Objects, read_json, write_json, write_text
from roomkin.stages.contracts.extracted import check_extracted
from roomkin.stages.contracts.hand import CORRECTIONS, Correction, Corrections
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject, Wall, distance_between
from roomkin.stages.contracts.parts import Panel
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.extraction.corrected_masks import Cutter
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.extraction.noise import read_folder
from roomkin.stages.extraction.reconstruct import ExtractedScene, correct_image, correct_scene
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.drawing.project import DrawnObject
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, OBJECT, WALL, WIDTH, write_room

BOXES = [UprightBox((3.7, -0.8, 0.4), (0.6, 0.8, 0.8), 0.0), UprightBox((2.5, 0.6, 0.3), (0.5, 0.5, 0.6), 0.3)]
CABINET, BOX = OBJECT, OBJECT + 1


@pytest.fixture
def source(tmp_path: Path) -> Path:
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "box"])
    said = json.loads((folder / "annotations.json").read_text())
    said["objects"][0] |= {"mounting": {"type": 3, "walls": [WALL]}, "articulated": True, "doors": 2}
    (folder / "annotations.json").write_text(json.dumps(said))
    return folder


@pytest.fixture
def session(source: Path) -> Correcting:
    return Correcting(source, ["mug"], source.parent / "results", "kitchen")


def _told(session: Correcting, drawing: ShownPicture) -> list[dict[str, Any]]:
    """What is kept of a drawing."""
    session.save(drawing.model_dump(mode="json"))
    path = session.folder / CORRECTIONS
    return json.loads(path.read_text()).get("objects", []) if path.is_file() else []


def _changed(drawing: ShownPicture, **changes: dict[str, Any] | None) -> ShownPicture:
    """The drawing with things changed by id; None in the place of changes: deleted."""
    kept = [item for item in drawing.objects if changes.get(item.id, {}) is not None]
    return ShownPicture(objects=[item.model_copy(update=changes.get(item.id) or {}) for item in kept])


def _objects(folder: Path, *told: Correction) -> Objects:
    """What extraction finds with some corrections."""
    write_json(folder / CORRECTIONS, Corrections(objects=list(told)))
    out = folder.parent / "found/objects.json"
    extract(input=folder, scene="kitchen", out=out, corrections=(folder / CORRECTIONS,))
    return read_json(Objects, out)


def _corrected(item: SceneObject, told: Correction, cloud: Any = ((0.0, 0.0, 0.0),), wall: float = -3.3) -> Any:
    """The only object of a scene, corrected, and its cloud; the camera looks along x, +y is on the left."""
    walls = [Wall(id="wall_1", normal=(-1, 0, 0), offset=wall, points=9)]
    frame = [[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1]]
    camera = {"width": 640, "height": 480, "intrinsics": [[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]]}
    objects = Objects(scene="t", floor_from_camera=frame, walls=walls, objects=[item], **camera)
    blank = np.zeros((480, 640))
    clouds = {item.id: np.array(cloud, np.float32)}
    scene = ExtractedScene(objects, blank.astype(np.uint16), blank.astype(np.float32), clouds)
    made = correct_scene(scene, {item.mask: told})
    return made.objects.objects[0], made.clouds[item.id]


def test_what_is_right_leaves_no_file_and_what_is_taken_back_its_age(session: Correcting) -> None:
    drawing = session.open_drawing()
    assert [item.id for item in drawing.objects] == ["cabinet_1", "box_1", "floor_1", "wall_1"]
    assert _told(session, drawing) == [] and not (session.folder / CORRECTIONS).exists()
    assert _told(session, _changed(drawing, cabinet_1={"doors": 1})) != []
    assert _told(session, drawing) == [] and (session.folder / CORRECTIONS).exists()


def test_only_what_differs_is_kept_and_read_by_whom_it_concerns(session: Correcting) -> None:
    told = {"label": "dresser", "doors": 0, "drawers": 3, "mounting": None, "model": "cabinet_7", "nudge": (0.1, 0.0)}
    kept = _told(session, _changed(session.open_drawing(), box_1=None, cabinet_1=told))
    assert kept == [
        {"mask": BOX, "gone": True},
        {"mask": CABINET, **told, "mounting": "measured", "nudge": [0.1, 0.0]},
    ]
    path = session.folder / CORRECTIONS
    assert set(read_told_to(path, "extraction")) == {CABINET, BOX}
    (placed,) = read_told_to(path, "generation").values()
    assert (placed.model, placed.nudge, placed.label, placed.doors) == ("cabinet_7", (0.1, 0.0), None, None)
    (again,) = [item for item in session.open_drawing().objects if item.id == "cabinet_1"]
    assert (again.label, again.doors, again.drawers, again.mounting) == ("dresser", 0, 3, None)


def test_names_deletions_and_boxes_count(session: Correcting, source: Path) -> None:
    found = read_scene_input(source)
    rows, columns = np.nonzero(found.masks == BOX)
    around = (columns.min() - 6.0, rows.min() - 6.0), (columns.max() + 7.0, rows.max() + 7.0)
    made = _objects(
        source,
        Correction(mask=BOX, gone=True),
        Correction(mask=CABINET, label="dresser", doors=0, drawers=3),
        Correction(mask=90, label="stool", around=around),
    ).objects
    assert [item.id for item in made] == ["dresser_1", "stool_1"] and all(item.status == "ok" for item in made)
    dresser, stool = made
    assert (dresser.doors, dresser.drawers, dresser.mask) == (0, 3, CABINET)
    assert dresser.mounting is not None and dresser.mounting.type == 3
    with Image.open(source.parent / "found/masks.png") as picture:
        cut, true = np.array(picture) == stool.mask, found.masks == BOX
    assert (cut & true).sum() > 0.85 * (cut | true).sum()  # cut out of the picture by a loose box
    after = read_scene_input(source)
    assert after.annotations == found.annotations  # what was found stays as it is


def test_the_page_is_called_as_the_picture_that_went_in(session: Correcting, source: Path) -> None:
    assert session.start()["project"]["picture"] == "kitchen"
    path = source / "camera.json"
    write_json(path, read_json(Camera, path).model_copy(update={"picture": "Küche"}))
    assert Correcting(source, [], source.parent / "results", "kitchen").start()["project"]["picture"] == "Küche"


def test_a_wall_that_is_gone_holds_nothing(session: Correcting, source: Path) -> None:
    answer = session.write(_changed(session.open_drawing(), wall_1={"label": "shelf"}).model_dump(mode="json"))
    assert answer["notes"] == ["cabinet: its wall is gone, mounting by geometry"]
    assert answer["ids"] == ["shelf_1", "cabinet_1", "box_1"]  # in the order of their values, as extraction has them


def test_parts_are_joined_and_nothing_else_is_gone(session: Correcting, source: Path) -> None:
    drawing = session.open_drawing()
    drawing = drawing.model_copy(update={"objects": [item for item in drawing.objects if item.mask != BOX]})
    joined = _changed(drawing, cabinet_1={"joins": [BOX]})
    session.save(joined.model_dump(mode="json"))
    told = read_told_to(source / CORRECTIONS, "extraction")
    assert told == {CABINET: Correction(mask=CABINET, joins=[BOX])}  # said once, not that the box is gone besides
    before, (seen, _) = read_folder(source), correct_image(read_folder(source), told)
    assert ((seen.masks == CABINET) == np.isin(before.masks, [CABINET, BOX])).all()
    assert [item.label for item in seen.annotations.objects] == ["cabinet"]
    again = session.open_drawing()
    assert {item.mask for item in again.objects} == {item.mask for item in joined.objects}
    with pytest.raises(ValueError, match="joined"):
        Corrections(objects=[Correction(mask=1, joins=[3]), Correction(mask=2, joins=[3])])


def test_what_the_input_doubts_is_shown_before_the_first_run(session: Correcting, source: Path) -> None:
    assert session.start()["made"] == {}
    said = json.loads((source / "annotations.json").read_text())
    doubt = {"cause": "name", "what": "called cabinet, 34 % sure", "chance": 0.66}
    said["objects"][1]["doubts"] = [doubt, {"cause": "size", "what": "is large"}]
    (source / "annotations.json").write_text(json.dumps(said))
    ((mask, shown),) = Correcting(source, [], source.parent / "results", "kitchen").start()["made"].items()
    assert mask == str(BOX) and [one["cause"] for one in shown["doubts"]] == ["name", "size"]
    assert shown["doubts"][0]["text"].startswith(doubt["what"]) and [one["harm"] for one in shown["doubts"]] == [
        0.66,
        0.5,
    ]


@pytest.mark.parametrize(
    ("told", "opens"),
    [
        ({}, True),
        ({"label": "stool"}, False),
        ({"label": "Dresser"}, True),
        ({"label": "stool", "drawers": 1}, True),
        ({"label": "dresser", "articulated": False}, False),
    ],
)
def test_another_name_than_the_proposed_one_says_anew_whether_it_opens(
    source: Path, told: dict[str, Any], opens: bool
) -> None:
    said = json.loads((source / "annotations.json").read_text())
    said["objects"][0] |= {"doors": 0, "proposals": ["cabinet", "stool", "chair"]}
    (source / "annotations.json").write_text(json.dumps(said))
    image, _ = correct_image(read_folder(source), {CABINET: Correction(mask=CABINET, **told)})
    assert image.annotations.objects[0].articulated is opens
    said["objects"][0].pop("proposals")  # what a person or a network has said stays
    (source / "annotations.json").write_text(json.dumps(said))
    stays = told.get("articulated", True)
    image, _ = correct_image(read_folder(source), {CABINET: Correction(mask=CABINET, **told)})
    assert image.annotations.objects[0].articulated is stays


def test_an_outline_says_which_pixels_and_two_floors_are_one(session: Correcting, source: Path) -> None:
    square = [(10.0, 300.0), (60.0, 300.0), (60.0, 340.0), (10.0, 340.0)]
    drawing = session.open_drawing()
    drawing.objects.append(ShownThing(id="a", mask=91, label="floor", outline=[(0.0, 0.0), (40.0, 0.0), (40.0, 20.0)]))
    drawing.objects.append(ShownThing(id="b", mask=92, label="mug", outline=square))
    drawing.objects.append(ShownThing(id="c", mask=93, label="lost", outline=[(900.0, 900.0)] * 3))
    session.save(drawing.model_dump(mode="json"))
    answer = session.write(drawing.model_dump(mode="json"))
    assert answer["notes"] == ["lost: no pixel shows it, left out"] and "mug_1" in answer["ids"]
    told = read_told_to(source / CORRECTIONS, "extraction")
    seen, _ = correct_image(read_folder(source), told)
    assert (seen.masks == 92).sum() == 51 * 41 and seen.masks[2, 30] == seen.annotations.floor == FLOOR


def test_a_person_says_size_support_front_and_mounting(source: Path) -> None:
    before = {item.mask: item for item in _objects(source).objects}
    assert before[BOX].box is not None and before[BOX].support is None
    said = Correction(mask=BOX, on=CABINET, size=(0.3, 0.2, 0.4), front=1.5)
    objects = _objects(source, said, Correction(mask=CABINET, mounting=Held(type=2)))
    cabinet, box = objects.objects
    assert cabinet.box is not None and box.box is not None and box.mounting is not None
    assert cabinet.mounting is not None and cabinet.mounting.type == 2
    assert (box.support, box.front, box.whole) == (cabinet.id, 1.5, True)
    assert (box.told, cabinet.told) == (["size"], ["mounting"])
    assert box.box.center[2] - 0.2 == pytest.approx(cabinet.box.center[2] + cabinet.box.size[2] / 2, abs=1e-5)
    assert sorted(box.box.size) == pytest.approx([0.2, 0.3, 0.4])
    turned = (before[BOX].box.yaw - 1.5) % np.pi  # its front is along its own y axis, and so is its depth
    assert box.box.size[1 if abs(turned - np.pi / 2) < np.pi / 4 else 0] == pytest.approx(0.2)
    nearest = np.linalg.norm(np.array(box.box.center)[:2]) - np.linalg.norm(np.array(before[BOX].box.center)[:2])
    assert -0.2 < nearest < 0.02  # the side that faces the camera stays
    check_extracted(source.parent / "found/objects.json")


def test_drawers_that_were_drawn_are_found_and_counts_undo_them(source: Path) -> None:
    drawers = [Panel(kind="drawer", left=0, right=1, bottom=k / 2, top=(k + 1) / 2) for k in range(2)]
    cabinet = _objects(source, Correction(mask=CABINET, panels=drawers)).objects[0]
    assert (cabinet.panels, cabinet.doors, cabinet.drawers) == (drawers, 0, 2)  # the input says two doors
    said = json.loads((source / "annotations.json").read_text())
    said["objects"][0] |= {"doors": 0, "drawers": 2, "panels": [panel.model_dump() for panel in drawers]}
    (source / "annotations.json").write_text(json.dumps(said))
    assert _objects(source, Correction(mask=BOX, label="stool")).objects[0].panels == drawers
    counted = _objects(source, Correction(mask=CABINET, drawers=3)).objects[0]
    assert (counted.panels, counted.doors, counted.drawers) == ([], 0, 3)


def test_a_front_is_shown_straight_on_before_and_after_a_run(session: Correcting, source: Path) -> None:
    drawing = {**session.open_drawing().model_dump(mode="json"), "mask": CABINET}
    before = session.front(drawing)
    assert before["picture"] and before["height"] > before["width"] / 2  # no box is known: what shows it
    results = source.parent / "results"
    extract(input=source, scene="kitchen", out=results / "extraction/kitchen/objects.json")
    ran = Correcting(source, [], results, "kitchen")
    seen = ran.front(drawing)  # 80 x 80 cm, towards the camera
    assert seen["picture"] and seen["width"] / seen["height"] == pytest.approx(1, abs=0.05)
    drawing["objects"][0]["front"] = 0.0  # away from the camera
    assert ran.front(drawing)["picture"] is None
    with pytest.raises(KeyError):
        ran.front({**drawing, "mask": 77})


@pytest.mark.parametrize(("bottom", "height"), [(0.25, 0.75), (0.9, 0.5), (-0.05, 0.45)])
def test_what_is_said_to_stand_on_the_floor_reaches_it_or_is_put_there(bottom: float, height: float) -> None:
    """A sofa whose mask is short at its foot; a thing that is seen far above; one that noise puts into the floor."""
    box = Box(center=(3.0, 0.0, bottom + 0.25), size=(0.5, 0.6, 0.5), yaw=0.0)
    item = SceneObject(id="box_1", label="box", mask=1, box=box, mounting=Mounting(type=1, walls=["wall_1"]))
    seen = [[2.8, 0, bottom], [2.8, 0, bottom + 0.5]]
    stood, cloud = _corrected(item, Correction(mask=1, on="floor"), seen)
    assert stood.mounting == Mounting(type=3, walls=["wall_1"])
    assert stood.box.size == pytest.approx((0.5, 0.6, height)) and stood.box.center[2] == pytest.approx(height / 2)
    assert cloud[:, 2].min() >= -1e-6 and cloud[:, 2].max() == pytest.approx(height)


def test_what_is_at_a_wall_keeps_its_rear_there(source: Path) -> None:
    objects = _objects(source, Correction(mask=CABINET, size=(0.9, 0.3, 0.7)))
    cabinet, wall = objects.objects[0], objects.walls[0]
    assert cabinet.box is not None and cabinet.mounting is not None and cabinet.mounting.walls == [wall.id]
    assert distance_between(cabinet.box, wall) == pytest.approx(0, abs=1e-4)
    assert cabinet.box.size[2] == pytest.approx(0.7) and cabinet.box.center[2] == pytest.approx(0.35, abs=0.02)


@pytest.mark.parametrize(
    ("found", "told", "front", "made"),
    [
        ((1.1, 0.5), (1.3, 0.4, 0.5), None, (1.3, 0.4)),  # longest along the view, as it was found
        ((1.1, 0.5), (0.4, 1.3, 0.5), None, (1.3, 0.4)),
        ((0.6, 0.55), (1.3, 0.4, 0.5), None, (0.4, 1.3)),  # nobody knows: depth is along the view
        ((1.1, 0.5), (1.3, 0.4, 0.5), np.pi, (0.4, 1.3)),  # it faces the camera
    ],
)
def test_the_longer_side_stays_the_longer_one(
    found: tuple[float, float], told: tuple[float, float, float], front: float | None, made: tuple[float, float]
) -> None:
    box = Box(center=(3.0, 0.0, 0.25), size=(*found, 0.5), yaw=0.1)
    item = SceneObject(id="table_1", label="table", mask=1, box=box, mounting=Mounting(type=2), front=front)
    sized, _ = _corrected(item, Correction(mask=1, size=told))
    assert sized.box.size == pytest.approx((*made, 0.5))


@pytest.mark.parametrize(
    ("pixels", "walls", "shift"),
    [
        ((100, 100, 640, 400), [], (0.0, -0.5, 0.1)),  # cut at the right: its left end stays
        ((0, 100, 300, 400), [], (0.0, 0.5, 0.1)),
        ((100, 100, 300, 400), [], (0.0, 0.0, 0.1)),
        ((0, 100, 640, 400), [], (0.0, 0.0, 0.1)),
        ((100, 0, 640, 400), ["wall_1"], (0.0, -0.5, 0.1)),  # it hangs, and its lower edge is seen
        ((100, 100, 300, 480), ["wall_1"], (0.0, 0.0, -0.1)),
    ],
)
def test_what_the_border_cuts_off_grows_beyond_it(
    pixels: tuple[int, int, int, int], walls: list[str], shift: tuple[float, float, float]
) -> None:
    box = Box(center=(3.0, 0.0, 1.0), size=(0.5, 1.0, 0.6), yaw=0.0)
    held = Mounting(type=1, walls=walls) if walls else Mounting(type=2)
    item = SceneObject(id="sofa_1", label="sofa", mask=1, box=box, mounting=held, pixels=pixels)
    sized, _ = _corrected(item, Correction(mask=1, size=(2.0, 0.5, 0.8)), wall=-3.25)
    assert sized.box.size == (0.5, 2.0, 0.8)
    assert np.subtract(sized.box.center, box.center) == pytest.approx(shift, abs=1e-6)


@pytest.mark.parametrize(
    ("size", "told"),
    [((30.0, 30.0, 30.0), True), ((0.01, 0.02, 0.01), True), ((2.9, 0.5, 0.8), False), ((0.5, 0.5, 0.001), False)],
)
def test_a_size_that_is_far_from_what_is_seen_is_taken_and_told(
    size: tuple[float, float, float], told: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    box = Box(center=(3.0, 0.0, 0.3), size=(0.5, 0.6, 0.6), yaw=0.0)
    item = SceneObject(id="sofa_1", label="sofa", mask=1, box=box, mounting=Mounting(type=2))
    sized, _ = _corrected(item, Correction(mask=1, size=size))
    assert sorted(sized.box.size) == sorted(size)
    stated = " x ".join(f"{side:g}" for side in size)
    line = f"sofa_1: {stated} m are stated of it, and 0.6 m of it are seen: were metres meant?\n"
    assert capsys.readouterr().out == (line if told else "")


@pytest.mark.parametrize("side", [1e-5, 0.0, -1.0, 31.0, 600.0])
def test_no_thing_is_said_to_be_thinner_than_a_millimetre_or_larger_than_any(side: float) -> None:
    """In a correction as in a drawing."""
    with pytest.raises(ValidationError, match=r"0\.001 to 30"):
        Correction(mask=1, size=(0.5, side, 0.5))
    with pytest.raises(ValidationError, match=r"0\.001 to 30"):
        DrawnObject(id="box_1", points=[(0, 0), (1, 1)], depth=side)


def test_a_thing_is_cut_out_of_what_surrounds_it() -> None:
    rng = np.random.default_rng(0)
    disk = np.zeros((200, 300), np.uint8)
    cv2.circle(disk, (150, 100), 40, 1, -1)
    rgb = (np.where(disk[..., None] > 0, (180, 60, 40), (60, 120, 90)) + rng.normal(0, 12, (200, 300, 3))).astype(
        np.uint8
    )
    mask = Cutter(rgb)((100, 52, 200, 148))
    assert ((disk > 0) & mask).sum() > 0.95 * ((disk > 0) | mask).sum()
    np.testing.assert_array_equal(mask, Cutter(rgb)((100, 52, 200, 148)))
    everything = Cutter(rgb)((0, 0, 300, 200))
    assert everything.all()  # nothing is around it
    flat = np.full((50, 50, 3), 90, np.uint8)
    assert Cutter(flat)((10, 10, 30, 30))[10:30, 10:30].any()


def test_what_does_not_fit_is_refused(session: Correcting, source: Path, tmp_path: Path) -> None:
    with refused("E-SCENE-EMPTY"):
        session.write(_changed(session.open_drawing(), cabinet_1=None, box_1=None).model_dump(mode="json"))
    with refused("E-SCENE-EMPTY"):
        _objects(source, Correction(mask=CABINET, gone=True), Correction(mask=BOX, gone=True))
    with pytest.raises(ValidationError, match="carried by itself"):
        Corrections(objects=[Correction(mask=1, on=2), Correction(mask=2, on=1)])
    with pytest.raises(ValidationError, match="is banned"):
        Correction(mask=1, model="a", banned=["a"])
    (source / CORRECTIONS).write_text('{"version": 1, "objects": [{"mask": 1, "hight": 2}]}')
    with pytest.raises(InputError, match=r"corrections\.json.*hight"):
        session.open_drawing()
    (source / CORRECTIONS).unlink()
    with refused("E-OPTION-CONFLICT"):
        annotate.run(source, out=tmp_path / "other", browser=False)
    with refused("E-OPTION-CONFLICT"):
        annotate.run(source, depth=source / "depth.npz", browser=False)
    (source / "masks.png").unlink()
    with pytest.raises(InputError, match=r"masks\.png"):
        annotate.run(source, browser=False)


@pytest.fixture
def opened(browser: Any, session: Correcting) -> Iterator[Any]:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        yield page


def test_a_person_corrects_in_the_browser(opened: Any, session: Correcting, source: Path) -> None:
    page, found = opened, read_scene_input(source).masks
    a, d, e, f = page.locator("#view").evaluate("e => { const m = e.getScreenCTM(); return [m.a, m.d, m.e, m.f]; }")

    def saved() -> ShownPicture:
        page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
        return session.open_drawing()

    def drag(*pixels: tuple[float, float]) -> None:
        for k, (u, v) in enumerate(pixels):
            page.mouse.move(u * a + e, v * d + f, steps=3)
            if k == 0:
                page.mouse.down()
        page.mouse.up()

    def middle(value: int) -> tuple[float, float]:
        rows, columns = np.nonzero(found == value)
        return float(columns.mean()), float(rows.mean())

    assert page.locator("#objects button").all_text_contents() == ["cabinet", "box", "floor", "wall"]
    u, v = middle(BOX)
    page.mouse.click(u * a + e, v * d + f)  # chosen by a click into the picture, then named
    page.get_by_label("What it is", exact=True).fill("stool")
    page.keyboard.press("Enter")
    assert [item.label for item in saved().objects] == ["cabinet", "stool", "floor", "wall"]
    page.locator("#mounting").select_option(f"3/{WALL}")
    drag(middle(BOX), (u - 20, v - 5))  # moved by its body: its content is cut out anew
    moved = saved().objects[1]
    assert moved.mounting is not None and moved.mounting.type == 3 and moved.around is not None
    rows, columns = np.nonzero(found == BOX)
    assert moved.around[0] == pytest.approx((columns.min() - 20, rows.min() - 5), abs=2)
    page.keyboard.press("ArrowRight")
    assert saved().objects[1].around[0][0] == pytest.approx(moved.around[0][0] + 1, abs=0.1)  # type: ignore[index]
    page.keyboard.press("Control+z")
    drag(moved.around[1], (moved.around[1][0] + 15, moved.around[1][1] + 9))  # a corner
    grown = saved().objects[1].around
    assert (
        grown is not None
        and grown[0] == moved.around[0]
        and grown[1][0] == pytest.approx(moved.around[1][0] + 15, abs=2)
    )
    page.get_by_role("button", name="As it was found").click()
    assert saved().objects[1].around is None

    page.locator("#objects button", has_text="cabinet").click()
    page.locator("#view").focus()
    page.keyboard.press("Delete")
    assert [item.label for item in saved().objects] == ["stool", "floor", "wall"]
    page.keyboard.press("Control+z")
    assert len(saved().objects) == 4
    page.keyboard.press("f")
    drag((330, 150), (380, 200))
    page.wait_for_function("() => document.activeElement.id === 'label'")
    page.keyboard.type("clock")
    page.keyboard.press("Enter")
    page.get_by_label("Doors").fill("1")
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    page.keyboard.press("o")
    for u, v in ((20, 300), (70, 300), (70, 340), (20, 340)):
        page.mouse.click(u * a + e, v * d + f)
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.activeElement.id === 'label'")
    page.keyboard.type("rug")
    page.keyboard.press("Enter")
    drawn = saved()
    assert [(item.label, item.doors, len(item.outline)) for item in drawn.objects[-2:]] == [
        ("clock", 1, 0),
        ("rug", None, 4),
    ]
    page.reload()
    page.wait_for_selector("#over polygon")
    assert page.locator("#objects button").count() == 6
    page.get_by_role("button", name="Check it").click()
    page.wait_for_selector("#written:not([hidden])")
    page.wait_for_function("() => document.getElementById('preview').naturalWidth > 100")
    given, _ = correct_image(read_folder(source), read_told_to(source / CORRECTIONS, "extraction"))
    assert [item.label for item in given.annotations.objects] == ["cabinet", "stool", "clock", "rug"]
    assert given.annotations.objects[2].articulated and given.masks.shape[::-1] == (WIDTH, HEIGHT)
    page.get_by_role("button", name="Done").click()
    page.wait_for_function("() => document.getElementById('hint').textContent.startsWith('Done')")
    assert session.finished


def test_what_changes_while_it_is_saved_is_not_called_saved(opened: Any) -> None:
    page, asked = opened, []
    page.route("**/save", lambda route: asked.append(route))
    page.locator("#objects button", has_text="box").click()
    with page.expect_request("**/save"):
        page.get_by_label("What it is", exact=True).fill("stool")
        page.keyboard.press("Enter")
    page.get_by_label("What it is", exact=True).fill("chair")
    page.keyboard.press("Enter")
    with page.expect_response("**/save") as answer:
        asked[0].continue_()
    answer.value.finished()
    page.wait_for_timeout(100)
    assert page.locator("#saved").text_content() == "…"
    wait_for(lambda: len(asked) > 1, page)  # the next one is sent after a quarter of a second
    asked[1].continue_()
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    page.unroute("**/save")


def test_a_scene_or_an_object_that_is_not_there_is_refused(source: Path) -> None:
    results = source.parent / "results"
    with refused("E-OBJECT-MISSING", "did you mean 'cabinet_1'?"):
        annotate.run(source, results=results, choose="cabinet_9", browser=False)
    write_text(results / "extraction/kitchen/objects.json", "")
    with refused("E-OBJECT-MISSING", "did you mean 'kitchen'?"):
        annotate.run(source, results=results, scene="kitchn", browser=False)
