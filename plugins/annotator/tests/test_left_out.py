"""What networks found and left out of the scene: a dashed outline with its guess, of which a click makes an object."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.annotator.annotate import _check_named
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_correcting import BOX, BOXES, CABINET
from roomkin.stages.contracts import Objects, read_json, write_json
from roomkin.stages.contracts.hand import CORRECTIONS, PROJECT, Correction
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.contracts.things import THINGS, Ground, Name, Thing, Things
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.extraction.noise import read_folder
from roomkin.stages.extraction.reconstruct import correct_image
from tests.unit.synthetic_room import FLOOR, WALL, write_room


def leave_out(folder: Path, name: str) -> Path:
    """A room of a cabinet, and of a box that was found and left out, with a guess."""
    write_room(folder, BOXES, ["cabinet", "box"])
    path = folder / "annotations.json"
    said = json.loads(path.read_text())
    path.write_text(json.dumps(said | {"objects": said["objects"][:1]}))
    names = [Name(name=name, probability=0.41), Name(name="stool", probability=0.2)]
    kept = Thing(mask=CABINET, names=[Name(name="cabinet", probability=0.9)], other=0.0, score=0.9, source="ssd")
    left = Thing(mask=BOX, names=names, other=0.3, score=0.8, source="mobile_sam", left_out="no name is sure")
    ground = Ground(camera_height=1.6, taken_from="a level surface below which 0.3 % of the points lie", share=0.4)
    write_json(folder / THINGS, Things(ground=ground, walls=1, things=[kept, left]))
    return folder


@pytest.fixture
def session(tmp_path: Path) -> Correcting:
    return Correcting(leave_out(tmp_path / "kitchen", "fridge"), ["mug"], tmp_path / "results", "kitchen")


def _told(page: Any, session: Correcting) -> list[dict[str, Any]]:
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    path = session.folder / CORRECTIONS
    return json.loads(path.read_text()).get("objects", []) if path.is_file() else []  # type: ignore[no-any-return]


def test_its_value_and_a_name_make_an_object_of_its_pixels(
    session: Correcting, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = session.folder
    assert "annotations.json does not name" not in capsys.readouterr().out  # it is left out, not forgotten
    write_json(folder / CORRECTIONS, {"version": 1, "objects": [{"mask": BOX, "label": "stool"}]})
    out = folder.parent / "found/objects.json"
    extract(input=folder, scene="kitchen", out=out, corrections=(folder / CORRECTIONS,))
    cabinet, stool = read_json(Objects, out).objects
    assert (cabinet.id, stool.id, stool.mask, stool.status) == ("cabinet_1", "stool_1", BOX, "ok")
    masks = read_scene_input(folder).masks
    assert stool.pixels == tuple(map(int, (*np.argwhere(masks == BOX).min(axis=0)[::-1],
                                           *np.argwhere(masks == BOX).max(axis=0)[::-1] + 1)))  # fmt: skip


def test_a_mask_is_called_floor_or_wall(session: Correcting) -> None:
    told = {BOX: Correction(mask=BOX, label="wall"), FLOOR: Correction(mask=FLOOR, gone=True)}
    image, lost = correct_image(read_folder(session.folder), told)
    assert image.annotations.walls == [WALL, BOX] and image.annotations.floor is None and lost == []
    image, _ = correct_image(read_folder(session.folder), {BOX: Correction(mask=BOX, label="floor")})
    assert image.annotations.floor == FLOOR and not (image.masks == BOX).any()  # all floors are one


def test_it_is_offered_with_its_guess_until_it_is_taken(session: Correcting) -> None:
    (offer,) = session.start()["offers"]
    assert (offer["text"], offer["why"], offer["label"]) == ("fridge, 41 %", "no name is sure", "fridge")
    assert offer["articulated"] and offer["outlines"]  # as a network's fridge is
    assert session.start()["proposals"][BOX] == ["fridge", "stool"]
    _check_named(session, session.results, None, f"drawn_{BOX}")  # the command on the scene's page
    session.chosen = f"drawn_{BOX}"
    assert session.start()["chosen"] == f"drawn_{BOX}"
    (session.folder / PROJECT).touch()
    assert Correcting(session.folder).start()["offers"] == [], (
        "nobody knows how far away it is: the page that draws does"
    )
    (session.folder / PROJECT).unlink()
    (session.folder / THINGS).unlink()
    assert Correcting(session.folder).start()["offers"] == []


def test_a_click_on_the_dashed_outline_takes_it(browser: Any, session: Correcting) -> None:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        assert page.locator("#left-out button").all_text_contents() == ["fridge, 41 %: no name is sure"]
        dashed = page.locator("#view .offer polygon")
        assert dashed.evaluate("e => getComputedStyle(e).strokeDasharray") != "none"
        assert page.locator("#view text", has_text="fridge, 41 %?").count() == 1
        dashed.click()
        assert _told(page, session) == [{"mask": BOX, "label": "fridge", "articulated": True}]
        assert page.locator("#objects button[aria-pressed=true]").text_content() == "fridge"
        assert page.locator("#proposals button").all_text_contents() == ["fridge", "stool"]
        assert page.locator("#left-out").is_hidden() and page.locator("#view .offer").count() == 0
        page.locator("#delete").click()
        assert _told(page, session) == []
        page.set_viewport_size({"width": 1400, "height": 400})
        page.locator("#left-out button").click()
        assert page.locator("#object").bounding_box()["y"] < 200, "its form is sought"
        page.set_viewport_size({"width": 1400, "height": 900})
        assert _told(page, session)[0]["label"] == "fridge"
        page.keyboard.press("Control+z")
        page.wait_for_selector("#left-out:not([hidden])")
        page.locator("#objects button", has_text="cabinet").click()
        page.locator("[data-tool=join]").click()
        page.locator("#view .offer polygon").click()  # it is a part of the cabinet
        assert _told(page, session) == [{"mask": CABINET, "joins": [BOX]}]
        assert page.locator("#left-out").is_hidden()


def test_a_later_outline_that_swallows_a_thing_says_so(browser: Any, session: Correcting) -> None:  # noqa: F811
    folder = session.folder
    rows, columns = np.nonzero(read_scene_input(folder).masks == CABINET)
    (x0, x1), (y0, y1) = ((float(v.min()) - 1, float(v.max()) + 2) for v in (columns, rows))
    middle = x0 + 0.7 * (x1 - x0)
    out = folder.parent / "found/objects.json"
    for right, said in ((x1, "cabinet: no pixel shows it, left out: it is "), (middle, "cabinet: 7")):
        corners = [[x0, y0], [right, y0], [right, y1], [x0, y1]]
        drawn = {"mask": 90, "label": "mirror", "outline": corners}
        write_json(folder / CORRECTIONS, {"version": 1, "objects": [drawn]})
        extract(input=folder, scene="kitchen", out=out, corrections=(folder / CORRECTIONS,))
        (lost,) = read_json(Objects, out).lost
        assert lost.startswith(said) and lost.endswith("under the outline of mirror"), lost
    with watched(browser, session, "#over polygon") as page:
        note = page.locator("#objects li", has_text="cabinet").locator(".note")
        assert "% of it is under the outline of mirror" in note.text_content()
    beside = {90: Correction(mask=90, label="mirror", outline=[(0.0, 0.0), (9.0, 0.0), (9.0, 9.0)])}
    assert correct_image(read_folder(folder), beside)[1] == []  # it covers floor and walls alone
