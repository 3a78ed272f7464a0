"""Stages replaced by commands that share nothing with ours: what they write is used, or refused and kept."""

import json
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from tests.workflow.workspace import copy, dry_run, overlay, planned, snakemake

STRANGERS = Path(__file__).parent / "strangers"
PYTHON = f"{shlex.quote(sys.executable)} -I -S"  # no site-packages, no repository
ASSETS = "results/experiment/default/door/assets.json"
MATCHED = {"match", "distances", "draw_cousins", "select", "generate", "draw_scenes"}
NO_POLICIES = "\nexperiment: {training_sets: []}"  # they read nothing that a stranger writes


def stages(*parts: str) -> str:
    """Overlay that replaces commands."""
    return f"stages: {{{', '.join(parts)}}}"


def stranger(stage: str, command: str, line: str, *code: str) -> str:
    """One of them."""
    return f"{stage}: {{{command}: {{command: {json.dumps(line)}, code: [{', '.join(code)}]}}}}"


def test_what_strangers_write_is_used_by_what_follows_and_by_nothing_before(run: Path, tmp_path: Path) -> None:
    """First all after another extraction, with another generation, then all between another matching and scenes."""
    folder = copy(run, tmp_path / "run")
    chains: list[tuple[dict[str, str], tuple[str, ...], set[str]]] = [
        (
            {"extraction": "extract", "generation": "generate"}, ("all",),
            {"all", "extract", "draw_objects", *MATCHED, "score", "demonstrate_in_scene", "trainings", "table2",
             "table2_robustness", "table3", "report_page"},
        ),
        (
            {"extraction": "extract", "matching": "match"}, ("matching", "generation", ASSETS),
            {"matching", "generation", *MATCHED},
        ),
    ]  # fmt: skip
    for commands, targets, runs in chains:
        scripts = {command: f"{command}.py" for command in commands.values()}
        for script in scripts.values():
            shutil.copy(STRANGERS / script, folder / script)
        parts = [stranger(stage, name, f"{PYTHON} {name}.py", f"{name}.py") for stage, name in commands.items()]
        config = overlay(folder, stages(*parts) + NO_POLICIES)
        done = snakemake(folder, *targets, *config)
        assert done.returncode == 0, done.stdout[-5000:]
        assert set(planned(done.stdout)) - {ASSETS} == runs
        again = dry_run(folder, *targets, *config)
        assert "Nothing to be done" in again.stdout, again.stdout[-3000:]
        scene = json.loads((folder / "results/generation/default/room_1/scene_1.json").read_text())
        assert sum(item.get("status", "ok") == "ok" for item in scene["objects"]) >= 4
        assert (folder / "results/generation/default/room_1/comparison.png").stat().st_size > 10_000
    for script in scripts.values():
        with (folder / script).open("a") as own:
            own.write("\n")  # an edit counts, although the command is the same
    assert {*scripts} <= set(planned(dry_run(folder, *targets, *config).stdout))


BREAK = """\
import json, subprocess, sys
subprocess.run([sys.executable, "-I", "-S", "stranger.py", *sys.argv[1:]], check=True)
out = sys.argv[sys.argv.index("--out") + 1]
EDIT
"""
NAN = "made['objects'][0]['cousins'][0]['distance'] = float('nan')"
WRONG = [
    ("matching", "match", f"made = json.load(open(out)); {NAN}; json.dump(made, open(out, 'w'))",
     "cousins.json: ", "objects.0.cousins.0.distance", ["matching/default/room_1/cousins.json"]),
    ("extraction", "extract", "open(out[:-12] + 'clouds.npz', 'w').write('no archive')",
     "clouds.npz: ", "", [f"extraction/room_1/{name}" for name in ("objects.json", "masks.png", "clouds.npz")]),
    ("generation", "generate", "import os; os.remove(out + '/scene_2.json')", "scene_2.json: ", "no such file",
     ["generation/default/room_1/scene_1.json"]),
]  # fmt: skip


@pytest.mark.parametrize(("stage", "command", "edit", "file", "field", "kept"), WRONG)
def test_wrong_output_is_refused_in_one_line_and_kept(
    run: Path, tmp_path: Path, stage: str, command: str, edit: str, file: str, field: str, kept: list[str]
) -> None:
    folder = copy(run, tmp_path / "run")
    shutil.copy(STRANGERS / f"{command}.py", folder / "stranger.py")
    (folder / "mine.py").write_text(BREAK.replace("EDIT", edit))
    done = snakemake(folder, stage, *overlay(folder, stages(stranger(stage, command, f"{PYTHON} mine.py", "mine.py"))))
    assert done.returncode == 1
    errors = [line for line in dict.fromkeys(done.stdout.splitlines()) if line.startswith("error: ")]
    assert len(errors) == 1, done.stdout[-3000:]
    assert file in errors[0] and field in errors[0]
    assert "Traceback" not in done.stdout
    for name in kept:
        assert (folder / "results" / f"{name}.refused").is_file(), name
        assert not (folder / "results" / name).exists(), name
