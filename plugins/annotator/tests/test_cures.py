"""Beside each doubt stands the click that cures it, where one click does."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.cures import find_beneath, list_cures, match_walls
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.corrected_scene import read_told, write_run
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.report.tests.test_report_browser import CONTRAST
from roomkin.stages.contracts import write_json
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.things import THINGS, Thing, Things
from roomkin.stages.geometry.boxes import UprightBox
from tests.unit.synthetic_room import OBJECT, WALL, write_room

CABINET, BOX = OBJECT, OBJECT + 1
BOXES = [UprightBox((3.7, -0.8, 0.4), (0.6, 0.8, 0.8), 0.0), UprightBox((3.6, -0.8, 0.95), (0.3, 0.4, 0.3), 0.0)]
OF_CABINET = [
    DoubtKind.BEHIND_WALL.of(depth=7, wall="wall_1"), DoubtKind.STRETCHED.of(times=1.7), DoubtKind.CUT_OFF.of(),
    DoubtKind.NO_FIT.of(), DoubtKind.PLACE_UNSURE.of(share=40),
]  # fmt: skip
OF_BOX = [DoubtKind.UNNAMED.of(), DoubtKind.BEYOND_WALL.of(wall="wall_1"), DoubtKind.SURFACE.of()]


@pytest.fixture
def session(tmp_path: Path) -> Correcting:
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "box"])
    return write_run(folder, tmp_path / "results", {0: OF_CABINET, 1: OF_BOX})


def test_below_a_thing_lies_what_most_of_its_columns_show_there() -> None:
    masks = np.zeros((100, 60), np.uint16)
    masks[20:40, 10:40] = 5
    assert find_beneath(masks, 5) is None and find_beneath(masks, 6) is None
    masks[41:60, 10:26] = 7
    masks[41:60, 26:40] = 8
    masks[70:, :] = 1  # too far below
    assert find_beneath(masks, 5) == 7
    masks[41:60, 10:24] = 0
    assert find_beneath(masks, 5) is None and find_beneath(masks, 1) is None


def test_a_mask_shows_the_wall_that_its_points_lie_on(session: Correcting) -> None:
    objects, depth, wall = session.made.objects, session.given.depth, session.given.masks == WALL
    assert objects is not None
    beside = objects.walls[0].model_copy(update={"id": "wall_2", "offset": objects.walls[0].offset + 0.1})
    two = objects.model_copy(update={"walls": [beside, objects.walls[0]]})
    assert match_walls(two, depth, {WALL: wall, 7: wall & False})[WALL].id == "wall_1"
    assert match_walls(objects, depth, {WALL: wall, 7: wall & False}).keys() == {WALL}
    assert match_walls(objects, 0.8 * depth, {WALL: wall}) == {}, "another one, that the run did not know"


def test_a_kind_of_doubt_knows_its_own_words() -> None:
    assert DoubtKind.BEHIND_WALL.read(OF_CABINET[0]) == {"depth": "7", "wall": "wall_1"}
    assert DoubtKind.UNNAMED.read(OF_BOX[0]) == {} and DoubtKind.UNNAMED.read(OF_BOX[1]) is None
    assert DoubtKind.UNNAMED.read(Doubt(cause="name", what=OF_BOX[0].what)) is None


def test_no_wall_carries_what_is_seen_before_it() -> None:
    for room, offered in (({WALL: "wall"}, []), ({WALL: "floor"}, ["floor"]), ({}, [WALL])):
        cures = list_cures(DoubtKind.UNNAMED.of(), lambda: WALL, {}, (0, 0), None, None, room)
        assert [cure["set"]["on"] for cure in cures] == offered


def test_one_click_beside_a_doubt_mends_it(browser: Any, session: Correcting) -> None:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        lines = page.locator("#in-doubt li")

        def line(doubt: Doubt) -> Any:
            found = lines.filter(has_text=doubt.what)
            assert found.count() == 1 and "correction page" not in found.text_content()  # no advice, an act
            return found

        line(OF_BOX[0]).get_by_role("button", name="put it on cabinet").click()
        assert read_told(page, session) == {BOX: {"on": CABINET}}
        assert line(OF_BOX[0]).locator("[aria-pressed=true]").last.text_content() == "put it on cabinet"
        assert page.locator("#label").input_value() == "box"  # what is changed is shown
        line(OF_BOX[1]).get_by_role("button", name="it hangs on wall").click()
        assert read_told(page, session)[BOX] == {"mounting": {"type": 1, "walls": [WALL]}}
        line(OF_BOX[2]).get_by_role("button", name="it is floor").click()
        assert read_told(page, session)[BOX]["label"] == "floor"
        page.keyboard.press("Control+z")
        line(OF_CABINET[0]).get_by_role("button", name="move it 8 cm, before the wall").click()
        assert read_told(page, session)[CABINET]["nudge"] == pytest.approx(
            [-0.08, 0], abs=5e-3
        )  # the camera looks a little aside
        own = page.locator("#own-doubts li", has_text=OF_CABINET[1].what)
        own.get_by_role("button", name="as its model: 50 wide × 40 deep × 80 high, cm").click()
        assert read_told(page, session)[CABINET]["size"] == [0.5, 0.4, 0.8]
        depth, width, height = session.made.placed[CABINET].size
        placed = f"keep as placed: {100 * width:.0f} wide × {100 * depth:.0f} deep × {100 * height:.0f} high, cm"
        own.get_by_role("button", name=placed).click()
        assert read_told(page, session)[CABINET]["size"] == pytest.approx([width, depth, height], abs=1e-3)
        assert line(OF_CABINET[2]).locator("button").count() == 1  # a size is offered once
        line(OF_CABINET[3]).get_by_role("button", name="keep its model").click()
        assert read_told(page, session)[CABINET]["model"] == "cabinet_0"
        line(OF_CABINET[4]).get_by_role("button", name="it stands right").click()
        assert read_told(page, session)[CABINET]["nudge"] == [0, 0]
        low = page.evaluate(CONTRAST)
        assert [text for text in low if not text.startswith("text ")] == []


def test_what_rests_on_the_old_name_or_model_is_gone_with_it(browser: Any, session: Correcting) -> None:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        cures = page.locator("#in-doubt").get_by_role(
            "button", name=re.compile("^(as its model|keep as placed|keep its)")
        )
        for count in (3, 0):  # what is said of the other thing rests on no model
            assert cures.count() == count
            page.locator("#label").fill("fridge")
            page.keyboard.press("Enter")
            page.wait_for_function(
                "() => document.querySelector('#in-doubt').textContent.includes('fridge as cabinet: ')"
            )
        assert page.locator("#metres").text_content() == "Metres, as placed as cabinet"
        assert page.locator("#own-size").is_hidden()
        assert page.locator("#in-doubt").get_by_role("button", name="move it 8 cm, before the wall").count() == 1
        read_told(page, session)
    with watched(browser, session, "#over polygon") as page:  # opened again before the next run
        assert page.locator("#in-doubt").get_by_role("button", name=re.compile("^(as its|keep)")).count() == 0
        page.keyboard.press("n")
        page.keyboard.press("p")
        page.locator("#label").fill("cabinet")
        page.keyboard.press("Enter")
        page.wait_for_selector("#cousins img")
        page.get_by_label("cabinet 0: not this one").click()
        page.wait_for_function("() => !document.querySelector('#in-doubt').textContent.includes('as its model')")
        page.locator("[data-asset=cabinet_5]").click()
        page.get_by_role("button", name="As its model: 55 wide × 40 deep × 80 high, cm", exact=True).click()
        assert read_told(page, session)[CABINET]["size"] == [0.55, 0.4, 0.8]


def test_what_carries_it_and_was_left_out_is_taken_by_the_same_click(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "box"])
    path = folder / "annotations.json"
    said = json.loads(path.read_text())
    path.write_text(json.dumps(said | {"objects": said["objects"][1:]}))
    left = Thing(mask=CABINET, names=[], other=1.0, score=0.8, source="mobile_sam", left_out="no name is sure")
    write_json(folder / THINGS, Things(walls=1, things=[left]))
    session = write_run(folder, tmp_path / "results", {0: [DoubtKind.UNNAMED.of()]})
    with watched(browser, session, "#over polygon") as page:
        page.locator("#in-doubt").get_by_role("button", name="put it on thing").click()
        assert read_told(page, session) == {BOX: {"on": CABINET}, CABINET: {}}
        page.keyboard.press("Control+z")
        assert read_told(page, session) == {}
