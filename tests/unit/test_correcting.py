"""What networks found, corrected by hand: without a browser what comes of it, in one what a person does."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from stages.contracts import InputError, Objects, read_json
from stages.contracts.scene_input import read_scene_input
from stages.extraction import annotate
from stages.extraction.by_hand.correcting import Correction
from stages.extraction.by_hand.corrections import CORRECTIONS, Corrections, Cutter, Region
from stages.extraction.extract import run as extract
from stages.geometry.boxes import UprightBox
from tests.unit.annotate_page import watched
from tests.unit.synthetic_room import FLOOR, HEIGHT, OBJECT, WALL, WIDTH, write_room
from tests.unit.test_annotate_browser import browser  # noqa: F401

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
def session(source: Path, tmp_path: Path) -> Correction:
    return Correction(source, tmp_path / "out", ["mug"])


def _body(drawing: Corrections) -> Any:
    return drawing.model_dump(mode="json")


def _changed(drawing: Corrections, **changes: dict[str, Any]) -> Corrections:
    """The drawing with regions changed by id; None in the place of changes: deleted."""
    kept = [item for item in drawing.objects if changes.get(item.id, {}) is not None]
    return drawing.model_copy(update={"objects": [item.model_copy(update=changes.get(item.id, {})) for item in kept]})


def test_what_is_right_is_written_as_it_was_found(session: Correction, source: Path) -> None:
    drawing = session.fresh()
    assert [item.id for item in drawing.objects] == ["cabinet_1", "box_1", "floor_1", "wall_1"]
    assert session.write(_body(drawing))["ids"] == ["cabinet_1", "box_1"]
    before, after = read_scene_input(source), read_scene_input(session.folder)
    np.testing.assert_array_equal(before.masks, after.masks)
    assert before.annotations == after.annotations and before.camera == after.camera
    np.testing.assert_array_equal(before.depth, after.depth)
    assert "out" in (session.folder / "config.yaml").read_text()


def test_names_deletions_and_boxes_count(session: Correction, source: Path) -> None:
    found = read_scene_input(source).masks
    rows, columns = np.nonzero(found == BOX)
    around = (columns.min() - 6.0, rows.min() - 6.0), (columns.max() + 7.0, rows.max() + 7.0)
    drawing = _changed(session.fresh(), box_1=None, cabinet_1={"label": "dresser", "doors": 0, "drawers": 3})
    drawing.objects.append(Region(id="drawn_1", label="stool", box=around))
    session.write(_body(drawing))
    given = read_scene_input(session.folder)
    dresser, stool = given.annotations.objects
    assert (dresser.label, dresser.doors, dresser.drawers, dresser.mask) == ("dresser", 0, 3, CABINET)
    assert dresser.mounting is not None and dresser.mounting.walls == [WALL]
    assert stool.label == "stool" and stool.mask not in (CABINET, BOX, FLOOR, WALL)
    cut, true = given.masks == stool.mask, found == BOX
    assert (cut & true).sum() > 0.9 * (cut | true).sum()  # cut out of the picture by a loose box
    extract(input=session.folder, scene="out", out=session.folder / "found/objects.json")
    made = read_json(Objects, session.folder / "found/objects.json").objects
    assert [item.id for item in made] == ["dresser_1", "stool_1"] and all(item.status == "ok" for item in made)


def test_a_wall_that_is_gone_holds_nothing(session: Correction) -> None:
    answer = session.write(_body(_changed(session.fresh(), wall_1={"label": "shelf"})))
    assert answer["notes"] == ["cabinet: its wall is gone, mounting by geometry"]
    given = read_scene_input(session.folder).annotations
    assert given.walls == [] and given.objects[0].mounting is None and given.objects[2].label == "shelf"


def test_an_outline_says_which_pixels_and_two_floors_are_one(session: Correction) -> None:
    square = [(10.0, 300.0), (60.0, 300.0), (60.0, 340.0), (10.0, 340.0)]
    drawing = session.fresh()
    drawing.objects.append(Region(id="drawn_1", label="floor", outline=[(0.0, 0.0), (40.0, 0.0), (40.0, 20.0)]))
    drawing.objects.append(Region(id="drawn_2", label="mug", outline=square))
    drawing.objects.append(Region(id="drawn_3", label="lost", box=((2000.0, 2000.0), (2100.0, 2100.0)), doors=1))
    answer = session.write(_body(_changed(drawing, drawn_3={"outline": [(900.0, 900.0)] * 3})))
    assert answer["notes"] == ["lost: no pixel shows it, left out"]
    given = read_scene_input(session.folder)
    mug = next(item for item in given.annotations.objects if item.label == "mug")
    assert (given.masks == mug.mask).sum() == 51 * 41 and given.masks[2, 30] == given.annotations.floor == FLOOR


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


def test_what_does_not_fit_is_refused(session: Correction, source: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no object is left"):
        session.write(_body(_changed(session.fresh(), cabinet_1=None, box_1=None)))
    session.save(_body(session.fresh()))
    said = json.loads((session.folder / CORRECTIONS).read_text())
    said["objects"][0]["found"] = 99
    (session.folder / CORRECTIONS).write_text(json.dumps(said))
    with pytest.raises(InputError, match=r"corrections\.json.*is not of what .* holds now"):
        session.opened()
    with pytest.raises(InputError, match="the folder that is corrected"):
        annotate.run(source, out=source, browser=False)
    with pytest.raises(InputError, match="--depth"):
        annotate.run(source, depth=source / "depth.npz", browser=False)
    (source / "masks.png").unlink()
    with pytest.raises(InputError, match=r"masks\.png"):
        annotate.run(source, out=tmp_path / "other", browser=False)


@pytest.fixture
def opened(browser: Any, session: Correction) -> Iterator[Any]:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        yield page


def test_a_person_corrects_in_the_browser(opened: Any, session: Correction, source: Path) -> None:
    page, found = opened, read_scene_input(source).masks
    a, d, e, f = page.locator("#view").evaluate("e => { const m = e.getScreenCTM(); return [m.a, m.d, m.e, m.f]; }")

    def saved() -> Corrections:
        page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
        return read_json(Corrections, session.folder / CORRECTIONS)

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
    page.locator("#mounting").select_option("3/wall_1")
    drag(middle(BOX), (u - 20, v - 5))  # moved by its body: its content is cut out anew
    moved = saved().objects[1]
    assert moved.mounting is not None and moved.mounting.type == 3 and moved.box is not None
    rows, columns = np.nonzero(found == BOX)
    assert moved.box[0] == pytest.approx((columns.min() - 20, rows.min() - 5), abs=2)
    page.keyboard.press("ArrowRight")
    assert saved().objects[1].box[0][0] == pytest.approx(moved.box[0][0] + 1, abs=0.1)  # type: ignore[index]
    page.keyboard.press("Control+z")
    drag(moved.box[1], (moved.box[1][0] + 15, moved.box[1][1] + 9))  # a corner
    grown = saved().objects[1].box
    assert grown is not None and grown[0] == moved.box[0] and grown[1][0] == pytest.approx(moved.box[1][0] + 15, abs=2)
    page.get_by_role("button", name="As it was found").click()
    assert saved().objects[1].box is None

    page.locator("#objects button", has_text="cabinet").click()
    page.locator("#view").focus()
    page.keyboard.press("Delete")
    assert [item.label for item in saved().objects] == ["stool", "floor", "wall"]
    page.keyboard.press("Control+z")
    assert len(saved().objects) == 4
    page.keyboard.press("b")
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
        ("rug", 0, 4),
    ]
    page.reload()
    page.wait_for_selector("#over polygon")
    assert page.locator("#objects button").count() == 6
    page.get_by_role("button", name="Write the folder").click()
    page.wait_for_selector("#written:not([hidden])")
    page.wait_for_function("() => document.getElementById('preview').naturalWidth > 100")
    if shots := os.environ.get("ACDC_SCREENSHOTS"):
        page.screenshot(path=f"{shots}/correct.png")
    given = read_scene_input(session.folder)
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
    page.wait_for_timeout(300)  # the next one is sent after a quarter of a second
    asked[1].continue_()
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    page.unroute("**/save")
