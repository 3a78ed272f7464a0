"""The one command: what it runs, in what words, what it completes, and what it says of mistakes."""

import contextlib
import importlib
import os
import pty
import select
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from roomkin import __main__, completion, correct, picture
from roomkin.workflow import COMMANDS, list_homes, run_snakemake
from tests.commands import list_commands
from tests.packages import needs
from tests.refusals import refused
from tests.workflow.workspace import ROOT, put

pytestmark = needs("annotator", "importing", "ops", "scorecard")


def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[Any, str, str]:
    """Exit code, stdout and stderr of `roomkin`."""
    monkeypatch.setattr(sys, "argv", ["roomkin", *words])
    monkeypatch.setattr(sys, "path", [*sys.path])
    with pytest.raises(SystemExit) as ended:
        __main__.start()
    return ended.value.code or 0, *capsys.readouterr()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "matching           nearest categories"),
        (["picture"], "roomkin correct <name>"),
        (["correct"], "--choose"),
        (["import"], "usage: roomkin importing import"),
        (["demo"], "--cores"),
        (["score"], "usage: roomkin scorecard score"),
        (["check"], "--mend"),
        (["completion"], "files"),
        (["matching"], "usage: roomkin matching COMMAND"),
        (["matching", "match"], "usage: roomkin matching match"),
        (["config"], "show"),
    ],
)
def test_help_is_a_page(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    code, page, fault = say(monkeypatch, capsys, *words, "--help")
    assert code == 0 and says in page and not fault and 3 < len(page.splitlines()) < 50


@pytest.mark.parametrize(
    ("words", "code", "fault"),
    [
        (["pictur"], 2, "error: roomkin has no command 'pictur'. Fix: did you mean 'picture'?\n"),
        (["matchin", "match"], 2, "error: roomkin has no command 'matchin'. Fix: did you mean 'matching'?\n"),
        (["matching", "mtach"], 2, "error: roomkin matching has no command 'mtach'. Fix: did you mean 'match'?\n"),
        (["picture", "--depht", "a"], 2, "error: roomkin picture: there is no --depht. Fix: did you mean '--depth'?\n"),
        (["picture", "a.jpg"], 1, "error: a.jpg: no such file. Fix: did you mean 'a.png'? [E-FILE-MISSING]\n"),
        (["picture", "a.png", "--depth", "b"], 1, "error: b: no such file. Fix: correct the path [E-FILE-MISSING]\n"),
        (["correct"], 1, "error: results: has no scene. Fix: roomkin picture kitchen.jpg [E-OBJECT-MISSING]\n"),
    ],
)
def test_a_mistake_is_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], code: int, fault: str
) -> None:
    Path("a.png").touch()
    assert say(monkeypatch, capsys, *words) == (code, "", fault)


def test_every_stage_and_package_with_commands_is_there() -> None:
    homes = {f"roomkin.{folder.replace('/', '.')}" for folder, _ in list_commands()}
    assert {*list_homes().values()} == homes | {"roomkin.stages.config", "roomkin.stages.contracts"}
    assert not {*list_homes()} & {*COMMANDS}


def test_the_script_that_pip_makes_starts_it() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, _, function = project["scripts"]["roomkin"].partition(":")
    assert getattr(importlib.import_module(module), function) is __main__.start


@pytest.fixture
def become(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The words of the Snakemake that a command becomes; weights are fetched by nobody."""
    said: list[str] = []
    monkeypatch.setattr("os.execv", lambda program, words: said.extend(words))
    monkeypatch.setattr("roomkin.stages.perception.fetch.run", lambda: said.append("fetched"))
    return said


def test_a_picture_opens_one_page_whatever_it_is_called_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """The drawing of what was drawn into; else, and where a thing of the scene is named, what was found and made."""
    opened: list[Path] = []
    monkeypatch.setattr("roomkin.plugins.annotator.annotate.run", lambda image, **said: opened.append(image))
    hall, room = Path("results/photo/hall"), Path("results/scenes/room_1/input")
    for folder in (hall, room, Path("results/photo/room_1-photo")):
        for name in ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json"):
            put(folder / name)
    correct.run(Path("hall"))
    put(Path("hand/hall/project.json"))
    put(Path("hall.jpg"))
    for picture_ in ("hall", "hall.jpg", "other/hall.jpg", str(hall)):
        correct.run(Path(picture_))
    correct.run(hall, choose="cabinet_1")
    put(Path("results/photo/room_1-photo/project.json"))
    correct.run(Path("room_1.jpg"))
    drawn = hall / "rgb.png"
    assert opened == [hall, drawn, Path("hall.jpg"), drawn, drawn, hall, Path("results/photo/room_1-photo/rgb.png")]


@pytest.mark.parametrize(
    "name", ["000048", "frame #3.png", "a: b.png", 'it\'s `x` $HOME "q".png', "厨房.png", "{x}.jpg"]
)
def test_the_workflow_gets_a_name_as_it_was_typed(become: list[str], name: str) -> None:
    from snakemake.cli import get_argument_parser, parse_config

    for file in (name, "k.json", "mine.yaml"):
        Path(file).touch()
    picture.run(Path(name), depth=Path(name), intrinsics=Path("k.json"), config=(Path("mine.yaml"),), cores=3)
    assert become.pop(0) == "fetched" and Path(become.pop(0)).name == "snakemake"
    said = get_argument_parser().parse_args(become)
    assert (said.targets, said.cores, said.configfile) == (["photo"], 3, [Path("mine.yaml")])
    assert said.snakefile == str(ROOT / "Snakefile")
    assert parse_config(said.config) == {"image": name, "depth": name, "camera": "k.json"}


def test_the_demo_is_made_in_its_folder(become: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["roomkin", "demo"])
    __main__.start()
    assert become[3:5] == ["--cores", "2"] and become[-2:] == ["--", "pages"] and "demo" in become
    assert yaml.safe_load(Path(become[become.index("--configfile") + 1]).read_text())["experiment"]["rooms"] == [
        "room_1"
    ]


def test_without_snakemake_it_says_what_brings_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr("roomkin.stages.perception.fetch.run", lambda: None)
    with refused("E-COMMAND-MISSING", "needs Snakemake. Fix: pip install 'roomkin[workflow]'"):
        picture.run(tmp_path)


def test_the_scene_of_a_picture_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[tuple[Path, str]] = []
    monkeypatch.setattr(
        "roomkin.plugins.annotator.annotate.run", lambda folder, **said: opened.append((folder, said["scene"]))
    )
    frame, hall = Path("results/scenes/kitchen/frame"), Path("results/photo/hall")
    for name in ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json"):
        put(frame / name)
    correct.run()
    for name in ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json"):
        put(hall / name)
    correct.run(Path("pictures/kitchen.jpg"))
    correct.run(Path("hall"))
    correct.run(hall)
    assert opened == [(frame, "kitchen"), (frame, "kitchen"), (hall, "hall"), (hall, "hall")]
    with refused("E-OBJECT-MISSING", "results: has several scenes. Fix: there are: kitchen, hall"):
        correct.run()
    with refused("E-OBJECT-MISSING", "has no scene of kitchn.jpg. Fix: did you mean 'kitchen'?"):
        correct.run(Path("kitchn.jpg"))


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("pic", {"picture", "pictures"}),
        ("matching ", {"features", "shards", "match", "distances"}),
        ("matching match --wi", {"--without"}),
        ("matching match --image a.png --out", {"--out"}),
        ("picture a.png --int", {"--intrinsics"}),
        ("import m --o", {"--out"}),
        ("picture ki", set()),
    ],
)
def test_the_tab_key(capsys: pytest.CaptureFixture[str], typed: str, offered: set[str]) -> None:
    completion.run()
    script = (
        capsys.readouterr().out + 'COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _roomkin; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    words = " ".join(f"'{word}'" for word in ["roomkin", *typed.split(" ")])
    done = subprocess.run(["bash", "-c", f"COMP_WORDS=({words})\n{script}"], capture_output=True, text=True, check=True)
    assert {*done.stdout.split()} == offered and not done.stderr
    assert "complete -o default -F _roomkin roomkin" in script and os.linesep in script


def test_the_tab_key_of_zsh(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    if shutil.which("zsh") is None:
        pytest.skip("no zsh: its Tab key is not pressed (apt-get install zsh)")
    completion.run()
    lines = "autoload -U compinit bashcompinit; compinit -u -D; bashcompinit\n"
    (tmp_path / ".zshrc").write_text(f"{lines}{capfd.readouterr().out}\nPS1='ready> '\n")
    process, screen = pty.fork()
    if not process:
        os.execvpe("zsh", ["zsh", "-i"], os.environ | {"ZDOTDIR": str(tmp_path), "TERM": "dumb"})

    def read_until(words: str) -> None:
        shown, last = "", time.monotonic() + 30
        while words not in shown:
            assert select.select([screen], [], [], max(0, last - time.monotonic()))[0], shown
            shown += os.read(screen, 4096).decode(errors="replace")

    read_until("ready> ")
    os.write(screen, b"roomkin matching ma\t")
    read_until("roomkin matching match ")
    os.write(screen, b"--wi\t")
    read_until("--without ")
    os.close(screen)
    os.waitpid(process, 0)


@pytest.mark.parametrize("code", [0, 3])
def test_what_follows_a_run_follows_only_if_it_ended_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    program = tmp_path / "snakemake"
    program.write_text(f"#!/bin/sh\necho $* >{tmp_path}/asked\nexit {code}\n")
    program.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    followed: list[str] = []
    with contextlib.suppress(SystemExit) if code else contextlib.nullcontext():
        run_snakemake(3, "photo", then=lambda: followed.append("page"))
    assert (tmp_path / "asked").read_text().endswith("--cores 3 photo\n") and len(followed) == (code == 0)
