"""Paths that a command is to read are looked for before it is imported: of every command of every package."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from roomkin import picture
from roomkin.stages.cli import find_missing_path, find_module
from tests.commands import list_commands, read_flags
from tests.refusals import refused
from tests.workflow.workspace import ROOT

# They are given nothing that has to be there. `correct` and `after` take a picture by its scene's name, too.
READ_NOTHING = (
    "claims.trainings furniture.facts furniture.library ops.clean ops.cluster ops.verify perception.fetch"
    " perception.from-rgbd report.overview report.report report.viewer robustness.table scorecard.baselines"
    " studies.quote studies.results tables.policies tables.scenes"
)
# Each command in turn, in one Python: what it says and its exit code, and which large libraries it has loaded by then.
LOOK = """\
import contextlib, io, json, runpy, sys

found = {}
for name, module, words in json.load(sys.stdin):
    sys.argv = [module, *words]
    with contextlib.redirect_stderr(io.StringIO()) as said:
        try:
            runpy.run_module(module, run_name="__main__")
        except SystemExit as end:
            large = {"torch", "sapien", "mani_skill", "open3d", "matplotlib", "cv2", "scipy", "trimesh"}
            found[name] = [end.code, said.getvalue(), sorted(large & sys.modules.keys())]
print(json.dumps(found))
"""


@pytest.mark.parametrize(
    ("module", "given", "missing"),
    [
        ("roomkin.plugins.importing.import_", ["nowhere", "--up", "y"], "nowhere"),
        ("roomkin.plugins.importing.import_", ["--up", "y", "nowhere"], "nowhere"),
        ("roomkin.plugins.importing.import_", ["a.png", "--out", "new"], ""),
        ("roomkin.plugins.importing.import_", ["nowhere", "--help"], ""),
        ("roomkin.picture", ["a.png", "--depth=nowhere"], "nowhere"),
        ("roomkin.picture", ["a.png", "--config", "nowhere", "--cores", "2"], ""),
        ("roomkin.picture", ["--cores", "2", "a.png"], ""),
        ("roomkin.correct", ["scene", "--results", "nowhere"], ""),
        ("roomkin.stages.matching.shards", ["--snapshots", "nowhere"], ""),  # nothing is drawn yet
        ("roomkin.plugins.report.report", ["--benchmarks", "a.png", "nowhere"], ""),  # Snakemake writes not every one
        ("roomkin.plugins.annotator.annotate", ["a.png", "--out", "new", "--camera", "a.png/x"], "a.png/x"),
    ],
)
def test_a_path_that_is_not_there_is_found(module: str, given: list[str], missing: str) -> None:
    Path("a.png").touch()
    assert find_missing_path(module, given) == missing


def test_a_config_that_is_not_there_is_refused_before_weights_are_fetched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(picture, "load_command", lambda *_: pytest.fail("something is done"))
    with refused("E-FILE-MISSING", "nowhere.yaml"):
        picture.run(Path("a.png"), config=(Path("nowhere.yaml"),))


def test_every_command_says_what_is_missing_before_it_imports_anything_large() -> None:
    asked, nothing = [], set()
    for folder, command in list_commands():
        name, home = f"{Path(folder).name}.{command}", f"roomkin.{folder.replace('/', '.')}"
        needed = sorted(read_flags(ROOT / folder, command)[1])
        words = ["/nowhere", *(word for flag in needed for word in (flag, "/nowhere"))]
        if find_missing_path(f"{home}.{find_module(command)}", words):
            asked.append([name, home, [command, *words]])
        else:
            nothing.add(name)
    assert nothing == set(READ_NOTHING.split())
    asked.append(["picture", "roomkin", ["picture", "/nowhere"]])
    asked.append(["correct", "roomkin", ["correct", "/nowhere"]])
    looked = subprocess.run([sys.executable, "-c", LOOK], input=json.dumps(asked), capture_output=True, text=True)
    assert looked.returncode == 0, looked.stderr[-3000:]
    found = json.loads(looked.stdout)
    assert {name for name, *_ in asked} == found.keys()
    for name, (code, said, large) in found.items():
        missing = "results: has no scene of /nowhere." if name == "correct" else "/nowhere: no such file."
        assert code == 1 and said.startswith(f"error: {missing}"), (name, code, said)
        assert not large, (name, large)
