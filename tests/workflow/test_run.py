"""One micro run of the whole workflow, then what a user does next: run again, swap a stage, edit a stage."""

import json
import shutil
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from tests.workflow.workspace import ROOT, make, snakemake

MICRO = ("--configfile", "config.yaml", "config/test/micro.yaml")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make(tmp_path_factory.mktemp("run"))
    done = snakemake(folder, "all", *MICRO)
    assert done.returncode == 0, done.stdout[-6000:]
    return folder


def overlay(folder: Path, text: str) -> tuple[str, ...]:
    """Config arguments of the micro run plus `text`."""
    path = folder / "mine.yaml"
    path.write_text(text)
    return (*MICRO, str(path))


def planned(output: str) -> set[str]:
    """Names of the rules in the job table of a dry run."""
    lines = output.splitlines()
    if not any(line.startswith("job ") for line in lines):
        return set()
    start = next(index for index, line in enumerate(lines) if line.startswith("job "))
    names = set()
    for line in lines[start + 2 :]:
        if not line.strip() or line.startswith("total"):
            break
        names.add(line.split()[0])
    return names


def test_tables_and_report_are_there(run: Path) -> None:
    table2 = pd.read_csv(run / "results/tables/table2.csv")
    assert {"scene", "scale_m", "variant", "n_objects", "category_correct", "l2_cm_mean"} <= set(table2.columns)
    table3 = pd.read_csv(run / "results/tables/table3.csv")
    assert {"task", "test_asset", "successes", "wilson_low", "wilson_high"} <= set(table3.columns)
    page = (run / "results/report/index.html").read_text()
    assert "<img" in page and "http://" not in page.replace("http://www.w3.org", "")


def test_second_run_has_nothing_to_do(run: Path) -> None:
    start = time.perf_counter()
    done = snakemake(run, "all", *MICRO)
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]
    assert time.perf_counter() - start < 30  # 10 s on a free machine


def test_another_seed_of_training_keeps_everything_before_it(run: Path) -> None:
    done = snakemake(run, "-n", "all", *overlay(run, "experiment: {seeds: [1]}"))
    assert planned(done.stdout) == {"all", "train", "rollout", "tables", "figures", "report_page"}, done.stdout


@pytest.mark.parametrize("swap", ["votes", "faiss", "clean_depth"])
def test_shipped_swaps_run(run: Path, swap: str) -> None:
    first = {"votes": "match", "faiss": "match", "clean_depth": "extract"}[swap]
    done = snakemake(run, "-n", "matching", *MICRO, f"config/swaps/{swap}.yaml")
    assert first in planned(done.stdout), done.stdout
    folder = run.parent / f"swap_{swap}"
    if not folder.exists():
        shutil.copytree(run, folder, symlinks=True)
    done = snakemake(folder, "matching", *MICRO, f"config/swaps/{swap}.yaml")
    assert done.returncode == 0, done.stdout[-3000:]


COMMAND = """\
import json, subprocess, sys
subprocess.check_call([sys.executable, "-m", "stages.matching", "match", *sys.argv[1:]])
path = sys.argv[sys.argv.index("--out") + 1]
cousins = json.load(open(path))
EDIT
json.dump(cousins, open(path, "w"))
"""
MINE = f"stages: {{matching: {{match: {{command: '{sys.executable} mine.py', code: [mine.py]}}}}}}"


def test_a_verb_is_replaced_by_a_command(run: Path) -> None:
    folder = run.parent / "replaced"
    shutil.copytree(run, folder, symlinks=True)
    (folder / "mine.py").write_text(COMMAND.replace("EDIT", "cousins['encoder'] = 'mine'"))
    done = snakemake(folder, "matching", *overlay(folder, MINE))
    assert done.returncode == 0, done.stdout[-3000:]
    assert planned(done.stdout) == {"match", "matching"}  # `features` is still ours
    assert json.loads((folder / "results/matching/b/room_1/cousins.json").read_text())["encoder"] == "mine"
    done = snakemake(folder, "-n", "matching", *overlay(folder, MINE))
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]
    (folder / "mine.py").write_text(COMMAND.replace("EDIT", "cousins['encoder'] = 'other'"))
    done = snakemake(folder, "-n", "matching", *overlay(folder, MINE))
    assert planned(done.stdout) == {"match", "matching"}


def test_a_replaced_verb_with_wrong_output_is_refused_in_one_line(run: Path) -> None:
    folder = run.parent / "refused"
    shutil.copytree(run, folder, symlinks=True)
    (folder / "mine.py").write_text(COMMAND.replace("EDIT", "del cousins['scene']"))
    done = snakemake(folder, "matching", *overlay(folder, MINE))
    assert done.returncode == 1
    assert "cousins.json: breaks the Cousins contract at scene: Field required" in done.stdout, done.stdout[-3000:]
    assert not (folder / "results/matching/b/room_1/cousins.json").exists()


def test_an_edit_reruns_what_uses_it_and_a_touch_nothing(run: Path) -> None:
    folder = run.parent / "edited"
    shutil.copytree(run, folder, symlinks=True)
    shutil.copytree(ROOT / "stages", folder / "stages", ignore=shutil.ignore_patterns("__pycache__"))
    here = {"PYTHONPATH": str(folder)}
    module = folder / "stages/tables/tables.py"
    module.touch()
    done = snakemake(folder, "-n", "all", *MICRO, environment=here)
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]
    module.write_text(module.read_text() + "\n# edited\n")
    done = snakemake(folder, "-n", "all", *MICRO, environment=here)
    assert planned(done.stdout) == {"all", "tables", "figures", "report_page"}, done.stdout[-3000:]
