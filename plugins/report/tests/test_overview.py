"""The page over all scenes: a row for each, what failed and why, in order; a thousand of them."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from roomkin.plugins.report import overview
from roomkin.plugins.report.page.overview import RunFolders, count_failures, row
from roomkin.plugins.report.tests.test_report_browser import WIDE, browser  # noqa: F401
from roomkin.plugins.report.tests.test_tables_report import Checker
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene
from tests.refusals import refused
from tests.unit.tables_results import write_run


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two rooms, both made."""
    found = write_run(tmp_path_factory.mktemp("run")) / "results"
    for room in ("room_1", "room_2"):
        Image.new("RGB", (288, 108), "grey").save(found / f"generation/default/{room}/thumbnail.webp")
    return found


@pytest.fixture
def layout(results: Path, tmp_path: Path) -> RunFolders:
    return RunFolders(results, tmp_path / "logs", "default")


def log(layout: RunFolders, name: str, text: str) -> None:
    path = layout.logs / f"{name}.log"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def test_a_scene_tells_what_failed_and_what_is_doubtful(layout: RunFolders) -> None:
    found = row("room_1", layout)
    assert found.stopped is None and found.picture.startswith("data:image/webp;base64,")
    scene = read_json(GeneratedScene, layout.results / "generation/default/room_1/scene_1.json")
    assert found.placed == sum(item.status == "ok" for item in scene.objects) > 0
    assert len(found.found.scenes) == len(list(layout.results.glob("generation/default/room_1/scene_*.json")))
    assert ("vase_1", "extraction") in {(failure.about, failure.stage) for failure in found.failures}
    assert all(failure.reason for failure in found.failures) and found.doubts


def test_a_camera_higher_than_anybody_holds_it_is_doubted_first(layout: RunFolders) -> None:
    path = layout.results / "extraction/room_1/objects.json"
    said = json.loads(path.read_text())
    said["floor_from_camera"][2][3] = 5.74
    path.write_text(json.dumps(said))
    found = row("room_1", layout)
    ((about, doubt),) = found.doubts[0].items
    assert about == "camera" and "depth in feet (1.75 m)" in doubt and "known length" in found.doubts[0].mend
    assert found.doubted >= 1


def test_a_scene_that_stopped_is_told_by_the_last_line_of_its_log(layout: RunFolders) -> None:
    log(layout, "scenes/frame_lost", "reading\nerror: a.png: no such file. Fix: correct the path\n\n")
    log(layout, "extraction/dead", "")
    told = {name: row(name, layout).stopped for name in ("lost", "dead", "waits")}
    assert [each and each.reason for each in told.values()] == [
        "a.png: no such file. Fix: correct the path",
        f"{layout.logs}/extraction/dead.log is empty: the job was killed",
        "not run",
    ]
    assert {each and each.stage for each in told.values()} == {"extraction"}


def test_what_later_stages_left_of_an_earlier_run_does_not_count(layout: RunFolders, tmp_path: Path) -> None:
    for path in layout.results.rglob("*"):
        if path.is_file() and "room_1" in path.parts and path.name != "cousins.json":
            copied = tmp_path / "results" / path.relative_to(layout.results)
            copied.parent.mkdir(parents=True, exist_ok=True)
            copied.write_bytes(path.read_bytes())
    left = RunFolders(tmp_path / "results", layout.logs, "default")
    log(layout, "matching/default_room_1", "error: features: too few\n")
    found = row("room_1", left)
    assert found.stopped and (found.stopped.stage, found.stopped.reason) == ("matching", "features: too few")
    assert (found.found.scenes, found.placed, found.picture) == ([], 0, "") and found.found.seen


def test_reasons_that_differ_by_numbers_are_one(layout: RunFolders) -> None:
    for name, pixels in (("a", 12), ("b", 4.5)):
        log(layout, f"extraction/{name}", f"error: only {pixels} pixels\n")
    assert count_failures(row(name, layout) for name in ("a", "b", "c")) == [("extraction: only … pixels", 2)]


def test_the_page_needs_nothing_else(results: Path, layout: RunFolders, tmp_path: Path) -> None:
    log(layout, "extraction/lost", "error: rgb.png: <b>broken</b>\n")
    page, failed = tmp_path / "default.html", tmp_path / "default.failed.html"
    failed.touch()
    overview.run(
        scenes=("room_2", "room_10", "lost", "room_1"), variant="default", out=page, results=results, logs=layout.logs,
        pages=(tmp_path / "scenes" / "room_2.html",),
    )  # fmt: skip
    assert not failed.exists()
    text = page.read_text()
    checker = Checker()
    checker.feed(text)
    assert checker.open == [] and checker.unnamed == []
    outside = [one for one in (*checker.links, *checker.sources) if not one.startswith("data:")]
    assert outside == ["scenes/room_2.html?from=../default.html"]
    assert re.findall(r'<th scope="row">(?:<a [^>]*>)?(\w+)<', text) == ["lost", "room_1", "room_2", "room_10"]
    assert "rgb.png: &lt;b&gt;broken&lt;/b&gt;" in text and "2 were made" in text and "1 stopped" in text


def test_a_thousand_rows_are_shown_and_sorted(results: Path, layout: RunFolders, tmp_path: Path, browser: Any) -> None:  # noqa: F811
    names = [f"kitchen_{number}" for number in range(1000)]
    for name in names:
        for stage in ("extraction", "matching/default", "generation/default"):
            (tmp_path / "results" / stage).mkdir(parents=True, exist_ok=True)
            (tmp_path / "results" / stage / name).symlink_to(results / stage / f"room_{1 + len(name) % 2}")
    log(layout, "extraction/lost", "error: broken\n")
    page = tmp_path / "default.html"
    overview.run(scenes=(*names, "lost"), variant="default", out=page, results=tmp_path / "results", logs=layout.logs)
    assert page.stat().st_size < 12_000_000
    for width in (360, 1440):
        shown = browser.new_page(viewport={"width": width, "height": 900}, color_scheme="dark")
        errors: list[str] = []
        shown.on("pageerror", lambda error, told=errors: told.append(str(error)))
        shown.goto(page.as_uri())
        first = "() => document.querySelector('tbody th').textContent"
        assert shown.evaluate("document.querySelectorAll('tbody tr').length") == 1001
        assert shown.evaluate(first) == "kitchen_0"
        if width > 640:  # heads are hidden on narrow screens
            shown.get_by_role("button", name="Failed").click()
            assert shown.evaluate(first) == "lost"
            shown.get_by_role("button", name="Scene").click()
            shown.get_by_role("button", name="Scene").click()
            assert (
                shown.evaluate(first) == "lost"
                and shown.evaluate("document.querySelectorAll('tbody th')[1].textContent") == "kitchen_999"
            )
        assert shown.evaluate(WIDE) == [] and errors == []
        shown.close()


def test_broken_results_are_no_row(layout: RunFolders, tmp_path: Path) -> None:
    made = tmp_path / "results/extraction/room"
    made.mkdir(parents=True)
    (made / "objects.json").write_text("{}")
    with refused("E-CONTRACT-VERSION"):
        row("room", RunFolders(tmp_path / "results", layout.logs, "default"))
