"""The page that corrects, with results of a run beside the folder: doubts first, cousins to choose, sizes, places."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.corrected_scene import read_told, read_told_to, write_run
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_correcting import BOXES
from roomkin.plugins.report.tests.test_report_browser import CONTRAST
from roomkin.stages.contracts import Objects, read_json
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.hand import CORRECTIONS, Correction
from roomkin.stages.extraction.corrected_masks import find_corners
from roomkin.stages.extraction.extract import run as extract
from tests.unit.synthetic_room import OBJECT, WALL, write_room

# Asked at once: whatever is solved meanwhile draws outlines anew.
MIDDLE = """(selector) => {
  const box = document.querySelector(selector).getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
}"""

CABINET, BOX = OBJECT, OBJECT + 1
DOUBT = DoubtKind.UNUSUAL_SIZE.of(
    what="is 60 by 220 cm, 80 cm high; usual are 30 to 60 by 40 to 120 cm, 60 to 90 cm high"
)


@pytest.fixture
def session(tmp_path: Path) -> Correcting:
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "cabinet"])
    return write_run(folder, tmp_path / "results", {1: [DOUBT]})


@pytest.fixture
def opened(browser: Any, session: Correcting) -> Iterator[Any]:  # noqa: F811
    with watched(browser, session, "#over polygon") as page:
        yield page


def _front(page: Any) -> str:
    """Where the front of the chosen thing is drawn, once no answer of the server moves it any more."""
    shown = "document.querySelector('#view .solid.front').getAttribute('points')"
    page.wait_for_function(
        f"() => {{ const at = {shown}, now = performance.now();"
        " if (window.front !== at) { window.front = at; window.since = now; }"
        " return now - window.since > 700; }"
    )
    return str(page.locator("#view .solid.front").get_attribute("points"))


def test_from_a_doubt_to_another_model_in_two_clicks(opened: Any, session: Correcting) -> None:
    page = opened
    assert page.locator("#objects button").all_text_contents() == ["cabinet 1", "cabinet 2", "floor", "wall"]
    assert page.locator("#objects button[aria-pressed=true]").text_content() == "cabinet 1"  # as --choose says
    doubts = page.locator("#in-doubt button")
    assert doubts.filter(has_text=f"cabinet 2: {DOUBT.what}").count() == 1
    doubts.filter(has_text=DOUBT.what).click()
    assert DOUBT.what in page.locator("#own-doubts").text_content()
    page.wait_for_selector("#cousins img")
    models = page.locator("#cousins li")
    assert models.count() == 12 and page.locator("#view .solid").count() == 6
    assert models.first.text_content().startswith("cabinet 0 · 1.00 · cousin 1 · stands there")
    models.nth(10).locator("[data-asset]").click()  # one that is no cousin
    assert read_told(page, session) == {BOX: {"model": "cabinet_10"}}
    page.get_by_label("the chosen one in every scene").check()
    page.get_by_label("cabinet 3: not this one").click()
    assert read_told(page, session) == {BOX: {"model": "cabinet_10", "pinned": True, "banned": ["cabinet_3"]}}
    page.get_by_label("cabinet 10: not this one").click()  # what is banned is not chosen, and so not in every scene
    assert read_told(page, session) == {BOX: {"banned": ["cabinet_3", "cabinet_10"]}}
    assert page.locator("#pinned").is_disabled()
    page.get_by_label("Same model as").select_option(label="cabinet 1")
    assert read_told(page, session)[BOX]["like"] == CABINET
    low = page.evaluate(CONTRAST)
    assert [line for line in low if not line.startswith("text ")] == []


def test_what_comes_next_stays_in_sight(opened: Any) -> None:
    page = opened
    for size in ({"width": 1280, "height": 800}, {"width": 390, "height": 844}):
        page.set_viewport_size(size)
        for name in ("cabinet 2", "cabinet 1"):
            page.locator("#objects button", has_text=name).click()
            for part in ("#hint", "#close", "#command", "#label"):
                box = page.locator(part).bounding_box()
                assert box["y"] >= 0 and box["y"] + box["height"] <= size["height"], (size, part)
            assert page.locator("#label").evaluate(
                "e => document.elementFromPoint(...(({ x, y }) => [x + 9, y + 9])(e.getBoundingClientRect())) === e"
            )
        scrolled = (
            "() => [...document.querySelectorAll('aside ul')].filter((e) => e.scrollHeight > e.clientHeight + 1).length"
        )
        assert page.evaluate(scrolled) == 0


def test_a_proposed_name_is_taken_by_a_click(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "cabinet"])
    given = json.loads((folder / "annotations.json").read_text())
    given["objects"][0]["proposals"] = ["cabinet", "fridge", "oven"]
    (folder / "annotations.json").write_text(json.dumps(given))
    session = Correcting(folder, ["mug"], tmp_path / "results", "kitchen", None, "cabinet_1")
    with watched(browser, session, "#over polygon") as page:
        names = page.locator("#proposals button")
        assert names.all_text_contents() == ["cabinet", "fridge", "oven"]
        assert page.locator("#proposals button[aria-pressed=true]").count() == 0
        names.nth(0).click()
        assert read_told(page, session) == {CABINET: {"named": True}}
        names.nth(1).click()
        assert read_told(page, session) == {CABINET: {"label": "fridge", "named": True}}
        assert page.locator("#proposals button[aria-pressed=true]").text_content() == "fridge"
        assert page.locator("#label").input_value() == "fridge"
        page.locator("#objects button").nth(1).click()
        assert names.count() == 0


def test_doubted_names_come_first_and_a_click_settles_each(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    """Before any run: one of the proposed names is one click, another word a click and the word."""
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "sofa"])
    given = json.loads((folder / "annotations.json").read_text())
    for item, names in zip(given["objects"], (["cabinet", "fridge", "oven"], ["sofa", "bed", "box"]), strict=True):
        doubt = {"cause": "name", "what": f"called {names[0]}, 34 % sure"}
        item |= {"proposals": names, "doubts": [doubt]}
    (folder / "annotations.json").write_text(json.dumps(given))
    session = Correcting(folder, ["mug"], tmp_path / "results", "kitchen")
    with watched(browser, session, "#over polygon") as page:
        lines = page.locator("#in-doubt li")
        assert (
            page.locator("#in-doubt summary").text_content()
            == "2 doubts about 2 things; a click leads to what mends it"
        )
        assert lines.nth(0).locator("button").all_text_contents() == ["cabinet?", "cabinet", "fridge", "oven"]
        lines.nth(0).get_by_role("button", name="fridge").click()
        assert read_told(page, session) == {CABINET: {"label": "fridge", "named": True}}
        assert lines.locator("button").all_text_contents() == ["sofa?", "sofa", "bed", "box"]
        lines.locator("button").first.click()
        page.keyboard.type("mug")
        page.keyboard.press("Enter")
        assert read_told(page, session)[BOX] == {"label": "mug"}
        assert page.locator("#in-doubt").is_hidden()
        page.keyboard.press("Control+z")
        page.wait_for_function("() => document.querySelectorAll('#in-doubt li').length === 1")


def test_names_stand_at_the_largest_outline_and_keep_their_numbers(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    """A stray pixel far off moves no name; a doubt about a size leads to the field for it."""
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "cabinet"])
    masks = np.array(Image.open(folder / "masks.png"))
    masks[0, 0] = CABINET
    Image.fromarray(masks).save(folder / "masks.png")
    given = json.loads((folder / "annotations.json").read_text())
    given["objects"][1]["doubts"] = [{"cause": "size", "what": "cut off by the picture's border"}]
    (folder / "annotations.json").write_text(json.dumps(given))
    session = Correcting(folder, ["mug"], tmp_path / "results", "kitchen")
    with watched(browser, session, "#over polygon") as page:
        shown = page.locator("#over text")
        assert sorted(shown.all_text_contents())[:2] == ["cabinet 1", "cabinet 2"]
        first = page.locator("#over text", has_text="cabinet 1")
        columns = np.nonzero(masks[1:] == CABINET)[1]
        assert float(first.get_attribute("x")) > columns.min() - 5
        page.locator("#in-doubt button").first.click()
        assert page.evaluate("document.activeElement.id") == "width"
        page.locator("#objects button", has_text="cabinet 2").click()
        page.locator("#label").fill("sofa")
        page.keyboard.press("Enter")
        page.locator("#objects button", has_text="cabinet").first.click()
        page.locator("#label").fill("sofa")
        page.keyboard.press("Enter")
        page.wait_for_function("() => document.querySelector('#objects').textContent.includes('sofa 2')")
        assert page.locator("#objects button").nth(0).text_content() == "sofa 2"  # the second to be called so


def test_a_room_is_put_right_from_its_doubt_on_and_made_again(opened: Any, session: Correcting) -> None:
    """Nine actions; of what comes of them extraction reads all but the model, which generation reads."""
    page, results = opened, session.folder.parent / "results"
    page.locator("#made").click()
    page.wait_for_function("() => document.querySelector('#view image').getAttribute('href') === 'made.png'")
    page.keyboard.press("s")
    assert page.locator("#view image").get_attribute("href") == "picture.jpg"
    page.locator("#in-doubt button").first.click()
    page.locator("[data-asset=cabinet_5]").click()
    page.get_by_role("button", name="As its model: 55 wide × 40 deep × 80 high, cm").click()
    page.locator("#on").select_option(label="the floor")
    page.locator("#mounting").select_option(label="stands, touches no wall")
    page.get_by_label("it opens").check()
    page.locator("#front-view summary").click()
    page.wait_for_selector("#front-picture image")
    box = page.locator("#front-picture").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x - 40, y - 30)
    page.mouse.down()
    page.mouse.move(x + 40, y + 30, steps=4)
    page.mouse.up()
    told = read_told(page, session)[BOX]
    assert told.keys() == {"articulated", "drawers", "panels", "mounting", "on", "size", "model"}
    assert "changed" in page.locator("#in-doubt button").first.get_attribute("class")
    page.keyboard.press("Control+s")
    page.wait_for_selector("#written:not([hidden])")
    path = session.folder / CORRECTIONS
    assert read_told_to(path, "generation") == {BOX: Correction(mask=BOX, model="cabinet_5")}
    extract(input=session.folder, scene="kitchen", out=results / "again/objects.json", corrections=(path,))
    before = {item.mask: item for item in read_json(Objects, results / "extraction/kitchen/objects.json").objects}
    after = {item.mask: item for item in read_json(Objects, results / "again/objects.json").objects}
    assert after[CABINET] == before[CABINET]  # nothing was said of it
    thing = after[BOX]
    assert (thing.support, thing.told, thing.drawers) == ("floor", ["mounting", "size"], 1)
    assert thing.box is not None and sorted(thing.box.size) == pytest.approx([0.4, 0.55, 0.8])
    assert [panel.model_dump() for panel in thing.panels] == told["panels"]


def test_drawers_are_drawn_on_the_front(opened: Any, session: Correcting) -> None:
    page = opened
    page.locator("#objects button", has_text="cabinet 2").click()
    assert page.locator("#front-view").is_hidden()
    page.get_by_label("Drawers").fill("3")
    page.keyboard.press("Enter")
    assert read_told(page, session)[BOX] == {"articulated": True, "drawers": 3}  # counts alone
    page.locator("#front-view summary").click()
    page.wait_for_selector("#front-picture:not([hidden])")
    page.get_by_role("button", name="Lay out evenly").click()
    assert page.locator("#front-picture text").all_text_contents() == ["drawer 1", "drawer 2", "drawer 3"]
    a, d, e, f = page.locator("#front-picture").evaluate(
        "e => { const m = e.getScreenCTM(), b = e.viewBox.baseVal;"
        " return [m.a * b.width, m.d * b.height, m.e, m.f + m.d * b.height]; }"
    )

    def drag(*shares: tuple[float, float]) -> None:
        for k, (x, y) in enumerate(shares):
            page.mouse.move(x * a + e, f - y * d, steps=4)
            if k == 0:
                page.mouse.down()
        page.mouse.up()

    def panels() -> list[dict[str, Any]]:
        return list(read_told(page, session)[BOX]["panels"])

    drag((0.5, 0.5), (0.5, 0.5))  # a click chooses the middle one
    drag((0.5, 1 / 3), (0.5, 0.2))  # its lower edge
    drag((0.7, 0.1), (0.7, 0.1))
    drag((0.5, 1 / 3), (0.5, 0.195))  # that of the lowest, up to it: it snaps
    middle, lowest = panels()[1:]
    assert middle["bottom"] == lowest["top"] == pytest.approx(0.2, abs=0.01) and middle["top"] == pytest.approx(
        2 / 3, abs=1e-3
    )
    drag((0.3, 0.1), (0.3, 0.9))  # all of it: it stays within the front
    assert panels()[2]["top"] == 1 and panels()[2]["bottom"] == pytest.approx(1 - lowest["top"], abs=1e-3)
    page.keyboard.press("Control+z")
    page.keyboard.press("Delete")  # the box, not the thing
    assert len(panels()) == 2 and read_told(page, session)[BOX]["drawers"] == 2
    page.get_by_role("button", name="Door", exact=True).click()
    drag((0.02, 0.02), (0.6, 0.18))
    assert panels()[2]["kind"] == "door" and panels()[2]["left"] == pytest.approx(0.02, abs=0.01)
    assert page.locator("#doors").input_value() == "1" and page.locator("#front-picture text").count() == 3
    told = read_told_to(session.folder / CORRECTIONS, "extraction")
    assert {item.kind for item in told[BOX].panels or []} == {"door", "drawer"}
    page.get_by_label("Drawers").fill("4")  # boxes that are not right any more go
    page.keyboard.press("Enter")
    assert read_told(page, session)[BOX] == {"articulated": True, "doors": 1, "drawers": 4}


def test_size_support_front_and_place_are_said(opened: Any, session: Correcting) -> None:
    page = opened
    page.locator("#objects button", has_text="cabinet 2").click()
    width = f"{round(session.made.placed[BOX].size[1], 3):g}"
    page.wait_for_function("width => document.querySelector('#width').value === width", arg=width)
    page.locator("#height").fill("0.5")
    page.keyboard.press("Enter")
    depth, width, _ = session.made.placed[BOX].size
    assert read_told(page, session)[BOX]["size"] == pytest.approx([width, depth, 0.5], abs=1e-3)
    page.locator("#on").select_option(label="cabinet 1")
    page.get_by_role("button", name="↺ 90°").click()
    page.get_by_role("button", name="←", exact=True).click()
    page.get_by_role("button", name="↓", exact=True).click(modifiers=["Shift"])
    drawn = _front(page)
    page.get_by_role("button", name="→", exact=True).click()
    page.wait_for_function(f"() => document.querySelector('#view .solid.front').getAttribute('points') !== '{drawn}'")
    page.get_by_role("button", name="←", exact=True).click()  # it is shown where it will stand
    page.wait_for_function(f"() => document.querySelector('#view .solid.front').getAttribute('points') === '{drawn}'")
    told = read_told(page, session)[BOX]
    assert told["on"] == CABINET and told["front"] == pytest.approx(-np.pi / 2, abs=1e-3)
    assert told["nudge"] == [-0.1, 0.02]
    assert page.locator("#nudge").text_content() == "10 cm nearer, 2 cm to the left"
    page.locator("#objects button", has_text="cabinet 1").click()
    assert "cabinet 2" not in page.locator("#on").text_content()  # it stands on this one already
    page.locator("#mounting").select_option(label="hangs on wall")
    assert page.locator("#on").is_disabled()
    page.locator("#view").focus()
    page.keyboard.press("Delete")  # what stood on it stands where it is found again
    assert "on" not in read_told(page, session)[BOX] and read_told(page, session)[CABINET] == {"gone": True}
    for _ in range(10):
        page.keyboard.press("Control+z")
    assert read_told(page, session) == {}
    assert page.locator("#command").text_content().endswith("results/report/scenes/kitchen.html")


def test_parts_are_joined_click_by_click_and_names_keep_their_numbers(opened: Any, session: Correcting) -> None:
    page = opened
    page.keyboard.press("j")
    assert "part of the chosen thing" in page.locator("#hint").text_content()
    for count, part in ((3, "cabinet_2"), (2, "wall_1")):
        page.mouse.click(*page.evaluate(MIDDLE, f"[data-object={part}] polygon"))
        page.wait_for_function(f"() => document.querySelectorAll('#objects button').length === {count}")
    assert read_told(page, session) == {CABINET: {"joins": [BOX, WALL]}}
    page.keyboard.press("j")
    assert page.locator("[data-tool=join]").get_attribute("aria-pressed") == "false"
    for _ in range(2):
        page.click("#undo")
    page.wait_for_function("() => document.querySelectorAll('#objects button').length === 4")
    assert read_told(page, session) == {}
    page.locator("#objects button", has_text="cabinet 1").click()
    page.get_by_role("button", name="Delete", exact=True).last.click()
    assert page.locator("#objects button").all_text_contents() == ["cabinet 2", "floor", "wall"]


def test_what_an_outline_covers_is_brought_to_the_front(opened: Any, session: Correcting) -> None:
    page = opened
    shown = session.given.masks == BOX
    page.locator("#objects button", has_text="cabinet 1").click()
    page.keyboard.press("o")
    (x0, y0), (x1, y1) = find_corners(shown)
    a, d, e, f = page.locator("#view").evaluate("e => { const m = e.getScreenCTM(); return [m.a, m.d, m.e, m.f]; }")
    for x, y in ((x0 - 5, y0 - 5), (x1 + 5, y0 - 5), (x1 + 5, y1 + 5), (x0 - 5, y1 + 5)):
        page.mouse.click(x * a + e, y * d + f)
    page.keyboard.press("Enter")
    covered = page.locator("#objects li", has_text="cabinet 2").locator(".note")
    page.wait_for_function("() => document.querySelector('#objects').textContent.includes('no pixel shows it')")
    page.get_by_role("button", name="to the front", exact=True).click()  # beside what is said of it
    page.wait_for_function("() => !document.querySelector('#objects').textContent.includes('no pixel shows it')")
    assert read_told(page, session)[BOX] == {"layer": 1} and covered.text_content() == ""
    assert (session._paint_drawing(session.open_drawing()).masks == BOX).sum() == shown.sum()
    page.locator("#objects button", has_text="cabinet 2").click()
    for name, layer in (("To the front", 2), ("To the back", -1)):
        page.get_by_role("button", name=name, exact=True).click()
        assert read_told(page, session)[BOX] == {"layer": layer}
    page.wait_for_function("() => document.querySelector('#objects').textContent.includes('no pixel shows it')")
