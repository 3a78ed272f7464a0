"""A page's run of the workflow: its progress, its end, a stop; and the buttons in the browser."""

import os
import shlex
import sys
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.annotator import after
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.making import Making
from roomkin.plugins.annotator.tests.annotate_page import serve, wait_for, watched
from roomkin.plugins.annotator.tests.corrected_scene import write_run
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_correcting import BOXES
from tests.refusals import refused
from tests.unit.synthetic_room import write_room


def shell(text: str) -> str:
    return f"bash -c {shlex.quote(text)}"


@pytest.fixture
def session(tmp_path: Path) -> Correcting:
    return write_run(write_room(tmp_path / "kitchen", BOXES, ["cabinet", "cabinet"]), tmp_path / "results", {})


def test_progress_is_read_off_the_lines_of_a_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("VERBOSE", "1")
    making = Making()
    assert making.describe() == {"running": False, "done": 0, "total": 0, "line": "", "code": None}
    go = tmp_path / "go"
    lines = r"echo 12 jobs, a line as each ends; echo '[ 3/12] match b room  2 s'; printf 'views: 1/9\rviews: 2/9'; "
    making.start(shell(f"{lines} until [ -e {go} ]; do sleep .05; done; echo; echo error: a: b. [$VERBOSE]; exit 3"))
    wait_for(lambda: making.describe()["line"].startswith("views: 1"))
    assert making.describe() | {"line": ""} == {"running": True, "done": 3, "total": 12, "line": "", "code": None}
    making.start(shell("echo another"))  # one at a time
    assert not making.is_new()
    go.touch()
    wait_for(lambda: not making.describe()["running"] and making.describe()["line"].startswith("error"))
    assert making.describe() == {"running": False, "done": 3, "total": 12, "line": "error: a: b. []", "code": 3}
    assert [making.is_new(), making.is_new()] == [True, False]


def test_a_stop_ends_all_that_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("roomkin.plugins.annotator.making.PATIENCE", 0.5)
    making = Making()
    making.stop()
    made = tmp_path / "pid"
    making.start(shell(f"sleep 60 & echo $! >{made}; trap '' INT; wait"))
    wait_for(lambda: made.is_file() and made.read_text().endswith("\n"))
    making.stop()
    assert making.describe()["line"] == "stopped; what was made is kept" and making.describe()["code"] != 0
    with pytest.raises(OSError):
        wait_for(lambda: bool(os.kill(int(made.read_text()), 0)))


def test_without_the_workflow_there_is_nothing_to_run() -> None:
    with refused("E-FOLDER-MISSING", "in its clone"):
        Making().start("cd CLONE && snakemake --cores 2")


def test_the_program_beside_this_python_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program = tmp_path / "bin/snakemake"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\npwd\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program.with_name("python")))
    making = Making()
    making.start(f"cd {tmp_path} && snakemake --cores 2")
    wait_for(lambda: making.describe()["line"] == str(tmp_path))


def test_only_the_page_may_ask_and_only_for_this_command(session: Correcting, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Correcting, "command", lambda self: shell("echo fixed"))
    server = serve(session)

    def post(address: str, **headers: str) -> int:
        body = b'{"command": "echo other"}'
        try:
            with urlopen(Request(address, body, {"Content-Type": "application/json", **headers})) as reply:
                return int(reply.status)
        except HTTPError as error:
            return error.code

    root = f"http://127.0.0.1:{server.server_port}/"
    assert post(f"{root}make") == post(f"{root}wrong/make") == 404
    assert post(f"{server.address}make", Origin="http://elsewhere") == 404
    server.opened = 2
    assert post(f"{server.address}make") == 409  # an older tab
    assert server.making.describe()["code"] is None
    assert post(f"{server.address}make", **{"X-Page": "2"}) == 200
    wait_for(lambda: server.making.describe()["line"] == "fixed")
    server.shutdown()
    server.server_close()


def test_a_scene_is_made_again_without_a_shell(
    browser: Any,  # noqa: F811
    session: Correcting,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """A change, a click, its progress, then the new scene in the picture's place; a cause if it fails; a stop."""
    scene, go = tmp_path / "results/generation/b/kitchen/scene_1.png", tmp_path / "go"
    Image.fromarray(np.full((36, 48, 3), 77, np.uint8)).save(tmp_path / "new.png")
    corrected = session.folder / "corrections.json"
    text = (
        f"echo '[1/2] match  2 s'; until [ -e {go} ]; do sleep .05; done; grep -q sofa {corrected} && mv {{}} {scene}"
    )
    commands = [
        shell(text.format(tmp_path / "new.png")),
        shell("echo error: no room. Fix: a box; exit 1"),
        shell("sleep 60"),
    ]
    monkeypatch.setattr(Correcting, "command", lambda self: commands[0])
    with watched(browser, session, "#over polygon") as page:
        page.locator("#objects button", has_text="cabinet 1").click()
        page.locator("#label").fill("sofa")
        page.keyboard.press("Enter")
        page.locator("#make").click()
        page.wait_for_function("() => document.getElementById('making').textContent === '1 of 2: match  2 s'")
        assert page.locator("#progress").get_attribute("value") == "1" and page.locator("#make").is_disabled()
        go.touch()
        page.wait_for_function("() => document.querySelector('#view image')?.getAttribute('href') === 'made.png'")
        assert page.locator("#objects button", has_text="sofa").count() == 1
        assert session.find_last_picture() == scene and not (tmp_path / "new.png").exists()
        commands.pop(0)
        page.locator("#make").click()
        page.locator("#making.trouble", has_text="error: no room. Fix: a box").wait_for()
        commands.pop(0)
        page.locator("#make").click()
        page.locator("#stop").click()
        page.wait_for_function("() => document.getElementById('making').textContent.startsWith('stopped')")
        assert not page.locator("#make").is_disabled()


@pytest.mark.parametrize(("terminal", "browser_here"), [(True, True), (False, True), (True, False)])
def test_a_picture_ends_with_its_page_where_somebody_sits(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    terminal: bool,
    browser_here: bool,
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    if browser_here:
        monkeypatch.setenv("DISPLAY", ":0")
    asked: list[Path] = []
    monkeypatch.setattr(after, "correct", asked.append)  # what `roomkin correct` opens
    monkeypatch.setattr("sys.stdout.isatty", lambda: terminal, raising=False)
    after.run(Path("kitchen.png"))
    assert asked == [Path("kitchen.png")] * (terminal and browser_here)
    assert ("roomkin correct kitchen.png" in capsys.readouterr().out) == (terminal and not browser_here)
    after.run(tmp_path)  # a recording's folder
    assert tmp_path not in asked
