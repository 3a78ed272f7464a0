"""One micro run of the whole workflow, then what a user does next: run again, change something, edit a stage."""

import json
import os
import re
import resource
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from PIL import Image

from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.policies import ChosenRuns
from tests.packages import needs
from tests.workflow.workspace import MICRO, ROOT, copy, dry_run, overlay, planned, snakemake

WITHOUT_WORK = 8.0  # CPU seconds at most of a run with nothing to do; half of them are Snakemake's own start


def test_tables_and_report_are_there(run: Path) -> None:
    table2 = pd.read_csv(run / "results/tables/table2.csv")
    assert {"scene", "scale_m", "variant", "n_objects", "category_correct", "l2_cm_mean"} <= set(table2.columns)
    table3 = pd.read_csv(run / "results/tables/table3.csv")
    assert {"target", "policy", "test_asset", "successes", "wilson_low", "wilson_high"} <= set(table3.columns)
    page = (run / "results/report/index.html").read_text()
    assert "<img" in page and "http://" not in page.replace("http://www.w3.org", "")


def test_seed_and_code_of_a_picture_can_be_told_from_the_picture_and_from_the_page(run: Path) -> None:
    made = run / "results/generation/default/room_1"
    scene = json.loads((made / "scene_1.json").read_text())["made"]
    with Image.open(made / "comparison.png") as picture:
        assert json.loads(picture.text["scene_1.json"]) == scene  # type: ignore[attr-defined]
    page = (run / "results/report/index.html").read_text()
    assert all(f"<code>{scene[name]}</code>" in page for name in ("options", "inputs", "code"))
    assert f"seed of this run is {scene['seed']}" in page and f"<td>{scene['seed']}</td>" in page


def test_the_best_hyper_parameter_set_is_chosen_by_its_trial_and_only_it_is_tested(run: Path) -> None:
    selection, policies = (run / "results/evaluation" / name / "door/micro/twin" for name in ("selection", "policies"))
    chosen = read_json(ChosenRuns, selection / "chosen.json")
    assert [score.run for score in chosen.scores] == ["micro", "micro_small"] and len(chosen.runs) == 1
    assert sorted(path.name for path in policies.iterdir()) == [*chosen.runs, "rollouts.csv"]
    tried = pd.read_csv(selection / chosen.runs[0] / "seed_0/rollouts.csv")
    rows = pd.read_csv(policies / "rollouts.csv")
    assert tried["checkpoint"].nunique() == 2 and set(rows["checkpoint"]) < set(tried["checkpoint"])
    assert not set(tried["initial_state"]) & set(rows["initial_state"])
    assert set(rows["test_asset"]) == {"twin", "dissimilar", "trained", "test"} and set(rows["cloud"]) == {
        "target_link"
    }


def test_second_run_has_nothing_to_do_and_says_so_soon(run: Path) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = snakemake(run, "all", *MICRO)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]
    assert after.ru_utime - before.ru_utime < WITHOUT_WORK
    assert "no longer what was written" not in done.stdout


@needs("ops")
def test_over_a_damaged_file_it_is_not_silent_though_nothing_is_to_be_done(run: Path, tmp_path: Path) -> None:
    """The command that it names makes the file anew."""
    folder = copy(run, tmp_path / "run")
    table = folder / "results/tables/table3.csv"
    whole, times = table.read_bytes(), (table.stat().st_atime_ns, table.stat().st_mtime_ns)
    table.write_bytes(whole[:-1])
    os.utime(table, ns=times)
    said = snakemake(folder, "all", *MICRO).stdout
    _, _, end = said.partition("Nothing to be done")
    assert "no longer what was written: results/tables/table3.csv. Fix: snakemake --cores 2 --force results/" in end
    forced = snakemake(folder, *re.findall(r"--force \S+", end)[0].split(), *MICRO)
    assert forced.returncode == 0 and table.read_bytes() == whole
    assert said.count("no longer what was written") == 2 and forced.stdout.count("no longer what was written") == 1


def test_another_seed_of_training_keeps_everything_before_it(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    done = dry_run(folder, "all", *overlay(folder, "experiment: {seeds: [1]}"))
    then = {
        "all",
        "train",
        "trainings",
        "selection_rollout",
        "choose",
        "rollout",  # of the policy that has nothing to choose
        "merge",
        "table3",
        "report_page",
    }  # what is chosen is not known
    assert set(planned(done.stdout)) == then, done.stdout


def test_a_second_variant_encodes_only_what_it_must(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    text = "{experiment: {variants: {weights: {hog: {normals: 3.0}}, fine: {hog: {grid: 24}}}}}"
    done = dry_run(folder, "matching", *overlay(folder, text))
    assert planned(done.stdout) == {"features": 2, "match": 2, "draw_cousins": 2, "matching": 1}, done.stdout


def test_the_page_names_no_file_that_this_run_did_not_declare(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    results = folder / "results"
    shutil.copytree(results / "generation/default", results / "generation/old_variant")
    shutil.copytree(results / "training/door/micro/twin/micro", results / "training/door/micro/twin/old_run")
    shutil.copytree(folder / "benchmarks/assets", folder / "benchmarks/old_stage")
    (results / "report/index.html").unlink()
    done = snakemake(folder, "all", *MICRO)
    assert done.returncode == 0 and planned(done.stdout) == {"all": 1, "report_page": 1}, done.stdout[-3000:]
    assert (results / "report/index.html").read_bytes() == (run / "results/report/index.html").read_bytes()


MADE_AGAIN = {"generate", "draw_scenes", "scene_page"}
DRAWER = {"kind": "drawer", "left": 0.0, "right": 1.0, "bottom": 0.6, "top": 1.0}


@pytest.mark.parametrize(
    "known", [True, False]
)  # whether Snakemake knows how the results were made: not of copied ones
@pytest.mark.parametrize(
    ("told", "rerun"),
    [
        ({"nudge": [0.05, 0.0], "banned": ["base_cabinet_0"]}, MADE_AGAIN),
        (
            {"model": "base_cabinet_0", "mounting": {"type": 2}, "panels": [DRAWER]},
            {"extract", "draw_objects", "match", *MADE_AGAIN},
        ),
        ({"on": "floor", "size": [0.5, 0.5, 0.8]}, {"extract", "draw_objects", "match", *MADE_AGAIN}),
    ],
)
def test_a_correction_runs_what_depends_on_it_and_nothing_else(
    run: Path, tmp_path: Path, told: dict[str, Any], rerun: set[str], known: bool
) -> None:
    folder = copy(run, tmp_path / "run")
    if not known:
        shutil.rmtree(folder / ".snakemake")
    page = "results/report/scenes/room_1.html"
    (folder / page).parent.mkdir(exist_ok=True)
    path = folder / "hand/room_1/corrections.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"version": 1, "objects": [{"mask": 1, **told}]}))
    done = dry_run(folder, page, "-p", *MICRO)
    assert set(planned(done.stdout)) == rerun, done.stdout
    readers = ("extract" in rerun) + bool({"model", "nudge"} & set(told))
    assert done.stdout.count("--corrections hand/room_1/corrections.json") == readers


def test_corrections_count_by_what_a_stage_reads_and_by_age_where_nobody_knows_what_it_read(
    run: Path, tmp_path: Path
) -> None:
    folder = copy(run, tmp_path / "run")
    shutil.rmtree(folder / ".snakemake")
    asked = ("results/generation/default/room_1/scene_1.json", *MICRO)

    def correct(nudge: float) -> None:
        told = {"mask": 1, "size": [0.5, 0.5, 0.8], "nudge": [nudge, 0.0]}
        path = folder / "hand/room_1/corrections.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"version": 1, "objects": [told]}))

    assert "Nothing to be done" in dry_run(folder, *asked).stdout
    correct(0.05)
    done = snakemake(folder, *asked)
    assert done.returncode == 0 and set(planned(done.stdout)) == {"extract", "match", "generate"}, done.stdout[-3000:]
    correct(0.05)
    assert "Nothing to be done" in dry_run(folder, *asked).stdout
    correct(0.06)
    assert set(planned(dry_run(folder, *asked).stdout)) == {"generate"}
    by_age = dry_run(folder, *asked, "--rerun-triggers", "mtime")
    shutil.rmtree(folder / ".snakemake")
    for done in (by_age, dry_run(folder, *asked)):
        assert set(planned(done.stdout)) == {"extract", "match", "generate"}, done.stdout
    (folder / "hand/room_1/corrections.json").write_text('{"version": 1}')  # all is taken back
    done = dry_run(folder, *asked)
    assert set(planned(done.stdout)) == {"extract", "match", "generate"}, done.stdout


def test_more_snapshots_keep_library_rooms_and_extraction(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    done = dry_run(folder, "matching", "extraction", *overlay(folder, "assets: {n_snap: 8}"))
    assert set(planned(done.stdout)) == {"snapshots", "features", "match", "draw_cousins", "matching"}, done.stdout


def test_an_edit_reruns_what_uses_it_and_a_touch_nothing(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    shutil.copytree(ROOT / "roomkin", folder / "roomkin", symlinks=True)
    shutil.copytree(ROOT / "stages", folder / "stages", ignore=shutil.ignore_patterns("__pycache__"))
    here = {"PYTHONPATH": str(folder)}
    module = folder / "stages/tables/policies.py"
    module.touch()
    done = snakemake(folder, "-n", "all", *MICRO, environment=here)
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]
    module.write_text(module.read_text() + "\n# edited\n")
    done = snakemake(folder, "-n", "all", *MICRO, environment=here)
    assert set(planned(done.stdout)) == {"all", "table3", "report_page"}, done.stdout[-3000:]
