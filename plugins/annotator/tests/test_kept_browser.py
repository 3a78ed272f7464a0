"""No save is lost in the browser: a page is closed at once, the disk is full, another page has written meanwhile."""

import errno
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from roomkin.plugins.annotator.server import PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.plugins.annotator.tests.annotate_page import serve, wait_for
from roomkin.plugins.annotator.tests.test_annotate_browser import ROOM, browser  # noqa: F401
from roomkin.stages.contracts import files
from roomkin.stages.contracts.hand import PROJECT
from roomkin.stages.perception.read.photo import read_photo

WALL = """async (many) => {
  const { edit, freeId } = await import('./state.js');
  const add = (project) => project.walls.push({ id: freeId('wall'), a: [90, 300], b: [200 + many, 310], free: false });
  for (let k = 0; k < many; k += 1) edit(add);
}"""
LARGE = """async () => {
  const { edit } = await import('./state.js');
  const outline = [...Array(900).keys()].map((k) => [100 + k / 1000, 200 + k / 1000]);
  const points = [[100, 300], [150, 300], [150, 200]];
  for (const id of 'abcdef') edit((project) => project.objects.push({ id, on: 'floor', points, outline }));
}"""
WATCH = """() => {
  window.setTimeout = () => 1; // nothing is sent after a while
  Object.defineProperty(document, 'hidden', { value: true });
  window.outlive = []; // for each save, whether it goes on when its page is gone
  const { fetch } = window;
  window.fetch = (name, what) => {
    if (name === 'save') window.outlive.push(what.keepalive);
    return fetch(name, what);
  };
}"""
LEAVE: dict[str, Callable[[Any], Any]] = {
    "closes the tab": lambda page: page.close(run_before_unload=True),
    "has it closed": lambda page: page.close(),
    "goes elsewhere": lambda page: page.goto("about:blank"),
    "reloads": lambda page: page.reload(),
    "closes the window": lambda page: page.context.close(),
}


@pytest.fixture
def opens(tmp_path: Path) -> Iterator[Callable[[], PageServer]]:
    """Opens a server of one photograph, as often as it is called."""
    servers = []

    def start() -> PageServer:
        servers.append(serve(Session(read_photo(ROOM / "rgb.jpg"), "rgb.jpg", tmp_path / "room", ["bowl"])))
        return servers[-1]

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def _open(browser: Any, server: PageServer) -> Any:  # noqa: F811
    page = browser.new_context().new_page()
    page.set_default_timeout(20_000)
    page.goto(server.address)
    page.wait_for_selector("#over line")
    page.mouse.click(5, 5)  # a browser asks nobody who has touched nothing whether to leave
    return page


def _draw(page: Any, many: int = 1) -> None:
    page.evaluate(WALL, many)


def _wait(page: Any, said: str) -> None:
    page.wait_for_function(f"() => document.getElementById('saved').textContent.startsWith('{said}')")


def _walls(server: PageServer) -> int:
    path = server.session.folder / PROJECT
    return len(json.loads(path.read_text())["walls"]) if path.is_file() else 0


@pytest.mark.parametrize("leave", LEAVE.values(), ids=LEAVE)
def test_who_leaves_at_once_loses_no_edit(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
    leave: Callable[[Any], Any],
) -> None:
    server = opens()
    for count, milliseconds in enumerate((0, 50, 150, 240), 1):
        page = _open(browser, server)
        _draw(page)
        _draw(page)
        page.wait_for_timeout(milliseconds)
        leave(page)
        until = time.monotonic() + 20
        while _walls(server) != 2 * count and time.monotonic() < until:
            time.sleep(0.02)
        assert _walls(server) == 2 * count, milliseconds


def test_what_waits_to_be_sent_is_sent_by_every_event_of_leaving(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    page = _open(browser, server := opens())
    page.evaluate(WATCH)
    for count, event in enumerate(("beforeunload", "pagehide", "visibilitychange"), 1):
        _draw(page)
        page.evaluate("(name) => document.dispatchEvent(new Event(name, { bubbles: true }))", event)
        _wait(page, "saved")
        assert _walls(server) == count, event
    page.evaluate(LARGE)
    page.evaluate("() => dispatchEvent(new Event('pagehide'))")
    _wait(page, "saved")
    assert page.evaluate("() => window.outlive") == [True, True, True, False]  # as a browser allows 64 KiB


def test_a_save_that_arrives_late_does_not_win_over_a_newer_one(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    page, held = _open(browser, server := opens()), []
    page.route("**/save", lambda route: held.append(route), times=1)
    with page.expect_request("**/save"):
        _draw(page)
    _draw(page)
    page.evaluate("() => dispatchEvent(new Event('pagehide'))")
    _wait(page, "saved")
    with page.expect_response("**/save") as late:
        held[0].continue_()
    assert late.value.status == 200 and _walls(server) == 2
    assert page.locator("#saved").text_content() == "saved"


def test_what_is_typed_into_a_field_is_an_edit_also_without_enter(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    page = _open(browser, server := opens())
    page.locator("#across").fill("70")
    page.reload()
    page.wait_for_selector("#over line")
    assert page.locator("#across").input_value() == "70.0"
    assert json.loads((server.session.folder / PROJECT).read_text())["perspective"]["focal"] > 0


def test_a_full_disk_is_told_on_the_page_until_there_is_room(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(_: Path) -> None:
        raise OSError(errno.ENOSPC, "full")

    page = _open(browser, server := opens())
    _draw(page)
    _wait(page, "saved")
    path = server.session.folder / PROJECT
    before, asked = path.read_bytes(), []
    with monkeypatch.context() as patch:
        patch.setattr(files, "sync", full)
        _draw(page)
        _wait(page, "NOT saved: ")
        page.wait_for_timeout(500)  # no answer to something else takes the line away
        said = page.locator("#saved")
        assert f"{path}: No space left on device" in said.text_content()
        assert said.evaluate(
            "e => getComputedStyle(e).color === getComputedStyle(document.getElementById('trouble')).color"
        )
        assert path.read_bytes() == before and [one.name for one in path.parent.iterdir()] == [PROJECT]
        page.on("dialog", lambda dialog: asked.append(dialog.type) or dialog.dismiss())
        page.close(run_before_unload=True)
        wait_for(lambda: bool(asked), page)
        assert asked == ["beforeunload"] and not page.is_closed()
    page.get_by_role("button", name="Undo").click()
    _wait(page, "saved")
    assert _walls(server) == 1
    page.get_by_role("button", name="Redo").click()
    _wait(page, "saved")
    assert _walls(server) == 2


def test_a_command_that_was_ended_is_told_on_the_page(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    page = _open(browser, opens())
    page.route("**/save", lambda route: route.abort())
    _draw(page)
    _wait(page, "NOT saved: the command that shows this page does not answer")
    page.unroute("**/save")
    _draw(page)
    _wait(page, "saved")


def test_a_page_that_is_refused_keeps_what_it_shows_and_goes_on_once_reloaded(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    one, other = _open(browser, server := opens()), _open(browser, opens())
    _draw(one)
    _wait(one, "saved")
    _draw(other, 2)
    _wait(other, "NOT saved: ")
    assert "changed since this page was opened" in other.locator("#saved").text_content()
    shown = "async () => (await import('./state.js')).state.project.walls.length"
    assert other.evaluate(shown) == 2 and _walls(server) == 1
    other.get_by_role("button", name="Undo").click()
    _wait(other, "NOT saved: ")
    assert other.evaluate(shown) == 1
    other.get_by_role("tab", name="4 Write").click()
    with other.expect_response("**/write") as answer:
        other.get_by_role("button", name="Done").click()
    assert answer.value.status == 409 and _walls(server) == 1
    assert "Done" not in other.locator("#hint").text_content()
    other.on("dialog", lambda dialog: dialog.accept())
    other.reload()
    other.wait_for_selector("#over line")
    _draw(other, 2)
    _wait(other, "saved")
    assert _walls(server) == 3


def test_who_leaves_while_a_large_drawing_is_not_saved_is_asked(
    browser: Any,  # noqa: F811
    opens: Callable[[], PageServer],
) -> None:
    page, held, asked = _open(browser, server := opens()), [], []
    page.route("**/save", lambda route: held.append(route))
    page.on("dialog", lambda dialog: asked.append(dialog.type) or dialog.dismiss())
    page.evaluate(LARGE)
    page.close(run_before_unload=True)
    wait_for(lambda: bool(asked), page)
    assert asked == ["beforeunload"] and not page.is_closed()
    for route in held:
        route.continue_()
    page.unroute("**/save")
    _wait(page, "saved")
    assert len(json.loads((server.session.folder / PROJECT).read_text())["objects"]) == 6
    with page.expect_event("close"):
        page.close(run_before_unload=True)
    assert asked == ["beforeunload"]
