"""Stages replaced by commands that share nothing with ours: what they write is used, or refused and kept."""

import json
import shutil
import sys
from pathlib import Path

import pytest

from tests.workflow.workspace import copy, dry_run, overlay, planned, snakemake

STRANGERS = Path(__file__).parent / "strangers"
PYTHON = f"{sys.executable} -I -S"  # no site-packages, no repository
SCORES = "results/evaluation/scenes/b/room_1/scores.csv"
ASSETS = "results/experiment/b/door/assets.json"
SCENES = {"generate", "draw_scenes", "score"}
REPORT = {"trainings", "table2", "table2_robustness", "table3", "report_page"}
NO_POLICIES = "\nexperiment: {training_sets: []}"  # they read nothing that a stranger writes


def stages(stage: str, command: str, line: str, *code: str) -> str:
    """Overlay that replaces one command."""
    return f"stages: {{{stage}: {{{command}: {{command: '{line}', code: [{', '.join(code)}]}}}}}}"


@pytest.mark.parametrize(
    ("stage", "command", "script", "targets", "runs"),
    [
        (
            "extraction", "extract", "extract.py", ("extraction", "matching", "generation", SCORES, ASSETS),
            {"extract", "draw_objects", "match", "distances", "draw_cousins", "select", *SCENES},
        ),
        (
            "matching", "match", "match.py", ("matching", "generation", SCORES, ASSETS),
            {"match", "distances", "draw_cousins", "select", *SCENES},
        ),
        (
            "generation", "generate", "generate.py", ("all",),
            {"all", "select", "demonstrate_in_scene", *SCENES, *REPORT},
        ),
    ],
    ids=["extraction", "matching", "generation"],
)  # fmt: skip
def test_a_command_by_a_stranger(
    run: Path, tmp_path: Path, stage: str, command: str, script: str, targets: tuple[str, ...], runs: set[str]
) -> None:
    folder = copy(run, tmp_path / "run")
    own = folder / script
    shutil.copy(STRANGERS / script, own)
    config = overlay(folder, stages(stage, command, f"{PYTHON} {script}", script) + NO_POLICIES)
    done = snakemake(folder, *targets, *config)
    assert done.returncode == 0, done.stdout[-5000:]
    assert set(planned(done.stdout)) - set(targets) == runs - set(targets)  # nothing before it, everything after it
    again = dry_run(folder, *targets, *config)
    assert "Nothing to be done" in again.stdout, again.stdout[-3000:]
    own.write_text(own.read_text() + "\n")  # an edit counts, although the command is the same
    assert command in planned(dry_run(folder, *targets, *config).stdout)
    shutil.copy(STRANGERS / script, own)
    scene = json.loads((folder / "results/generation/b/room_1/scene_1.json").read_text())
    assert sum(item.get("status", "ok") == "ok" for item in scene["objects"]) >= 4
    assert (folder / "results/generation/b/room_1/comparison.png").stat().st_size > 10_000


BREAK = """\
import json, subprocess, sys
subprocess.run([sys.executable, "-I", "-S", "stranger.py", *sys.argv[1:]], check=True)
out = sys.argv[sys.argv.index("--out") + 1]
EDIT
"""
NAN = "made['objects'][0]['cousins'][0]['distance'] = float('nan')"
WRONG = [
    ("matching", "match", f"made = json.load(open(out)); {NAN}; json.dump(made, open(out, 'w'))",
     "cousins.json: ", "objects.0.cousins.0.distance", ["matching/b/room_1/cousins.json"]),
    ("extraction", "extract", "open(out[:-12] + 'clouds.npz', 'w').write('no archive')",
     "clouds.npz: ", "", [f"extraction/room_1/{name}" for name in ("objects.json", "masks.png", "clouds.npz")]),
    ("generation", "generate", "import os; os.remove(out + '/scene_2.json')", "scene_2.json: ", "no such file",
     ["generation/b/room_1/scene_1.json"]),
]  # fmt: skip


@pytest.mark.parametrize(("stage", "command", "edit", "file", "field", "kept"), WRONG)
def test_wrong_output_is_refused_in_one_line_and_kept(
    run: Path, tmp_path: Path, stage: str, command: str, edit: str, file: str, field: str, kept: list[str]
) -> None:
    folder = copy(run, tmp_path / "run")
    shutil.copy(STRANGERS / f"{command}.py", folder / "stranger.py")
    (folder / "mine.py").write_text(BREAK.replace("EDIT", edit))
    done = snakemake(folder, stage, *overlay(folder, stages(stage, command, f"{PYTHON} mine.py", "mine.py")))
    assert done.returncode == 1
    errors = [line for line in dict.fromkeys(done.stdout.splitlines()) if line.startswith("error: ")]
    assert len(errors) == 1, done.stdout[-3000:]
    assert file in errors[0] and field in errors[0]
    assert "Traceback" not in done.stdout
    for name in kept:
        assert (folder / "results" / f"{name}.refused").is_file(), name
        assert not (folder / "results" / name).exists(), name
