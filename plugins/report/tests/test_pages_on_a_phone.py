"""Pages in headless Chromium, as wide as a phone: nothing overflows, links are reached; walls hide nothing."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from roomkin.plugins.report import overview
from roomkin.plugins.report.tests.test_report_browser import FRAME, WIDE, address, browser, unfold  # noqa: F401
from roomkin.plugins.report.tests.test_scene_page import made  # noqa: F401

PHONE = {"width": 390, "height": 844}
HIDDEN = """
() => [...document.querySelectorAll('nav li:not([hidden]) a')].filter((link) => {
  const box = link.getBoundingClientRect();
  const on_top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  return box.left < 0 || box.right > innerWidth || on_top !== link;
}).map((link) => link.textContent)
"""
EMPTY = """
() => {
  const canvas = document.querySelector('#turntable canvas');
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {willReadFrequently: true});
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let empty = 0;
  for (let i = 0; i < data.length; i += 4) empty += data[i] === 0xd1 && data[i + 1] === 0xd1 && data[i + 2] === 0xd6;
  return 4 * empty / data.length;
}
"""


@pytest.fixture(scope="module")
def pages(address: str, made: Path) -> dict[str, Path]:  # noqa: F811
    """Every page that the report's rules write, of small made-up runs."""
    report = Path(address.removeprefix("file://"))
    results, over = report.parent / "results", report.with_name("overview.html")
    overview.run(scenes=("room_1", "room_2", "lost"), variant="default", out=over, results=results, logs=report.parent)
    tables = {path.stem: path for path in results.glob("tables/*.html")} | {"scene": made / "room_1.html"}
    return {"report": report, "times": report.with_name("times.html"), "overview": over} | tables


@pytest.fixture
def phone(browser: Any) -> Iterator[Any]:  # noqa: F811
    page = browser.new_page(viewport=PHONE, offline=True, reduced_motion="reduce")
    yield page
    page.close()


def test_no_page_overflows(pages: dict[str, Path], phone: Any) -> None:
    assert {"report", "times", "overview", "scene", "table2", "table3"} <= set(pages)
    for name, path in pages.items():
        phone.goto(path.as_uri())
        unfold(phone)
        assert phone.evaluate("() => document.documentElement.scrollWidth") == PHONE["width"], name
        assert phone.evaluate(WIDE) == [], name


@pytest.mark.parametrize(("name", "links"), [("report", 7), ("scene", 5)])
@pytest.mark.parametrize("width", [360, 660, 1280])
def test_navigation_is_whole_and_stays_in_sight(
    pages: dict[str, Path], phone: Any, name: str, links: int, width: int
) -> None:
    phone.set_viewport_size({"width": width, "height": 844})
    phone.goto(pages[name].as_uri())
    assert phone.locator("nav a").count() >= links
    for below in (0, 1500):
        phone.evaluate(f"() => window.scrollTo(0, {below})")
        assert phone.evaluate(HIDDEN) == []
    phone.locator("nav a[href='#scenes'], nav a[href='#policies']").click()
    heading = phone.locator("#scenes h2, #policies h2").bounding_box()
    bar = phone.locator("nav ul").bounding_box()
    assert bar["y"] + bar["height"] <= heading["y"] < 400  # the bar does not cover what it leads to


def test_of_two_objects_in_a_row_the_neighbour_of_the_one_that_is_opened_keeps_its_height(
    pages: dict[str, Path], phone: Any
) -> None:
    phone.set_viewport_size({"width": 1280, "height": 844})
    phone.goto(pages["scene"].as_uri())
    cards = phone.locator(".match")
    boxes = [cards.nth(number).bounding_box() for number in range(2)]
    assert boxes[0]["y"] == boxes[1]["y"]
    cards.first.locator("details.story > summary").click()
    assert cards.first.bounding_box()["height"] > boxes[0]["height"] + 100
    assert cards.nth(1).bounding_box()["height"] == boxes[1]["height"]


def test_a_wall_seen_from_behind_or_edge_on_hides_nothing(pages: dict[str, Path], phone: Any) -> None:
    phone.goto(pages["report"].as_uri())
    phone.locator("button.turn").first.click()
    phone.wait_for_function("() => document.activeElement.matches('#turntable canvas')")

    def empty_after(keys: int) -> float:
        for _ in range(keys):
            phone.keyboard.press("ArrowRight")  # 0.1 rad
        phone.evaluate(FRAME)
        share: float = phone.evaluate(EMPTY)
        return share

    front, edge, behind = empty_after(0), empty_after(16), empty_after(15)
    assert 0.02 < front < 0.2  # the wall is seen
    assert edge > 0.6 and behind > 0.5
