"""Training sets compared over many objects: objects resampled, cells that have not run, the forecast."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plugins.studies import sets
from plugins.studies.forecasts import measure_agreement
from plugins.studies.objects import ROLLOUT, estimate, pair_cells, standard_error
from stages.config.tables import TablesConfig
from stages.contracts.policies import Rollout
from tests.unit.tables_results import write_rows

OPTIONS = TablesConfig(bootstrap_samples=400)
GAIN = 0.05


def differences(seed: int, objects: int = 16, between: float = 0.1, families: float = 0.1) -> pd.DataFrame:
    """A paired difference of mean `GAIN` whose objects and families differ by these standard deviations."""
    rng = np.random.default_rng(seed)
    gains, kinds = rng.normal(GAIN, between, objects), rng.normal(0, families, 60)
    rows = [
        (f"o{number}", f"f{family}", f"a{family}", run, gains[number] + kinds[family] + rng.normal(0, 0.6))
        for number in range(objects)
        for family in rng.permutation(60)[:20]
        for run in (0, 1)
    ]
    return pd.DataFrame(rows, columns=[*ROLLOUT, "success"])


@pytest.mark.parametrize(("between", "families"), [(0.0, 0.0), (0.15, 0.0), (0.1, 0.15)])
def test_intervals_hold_the_mean_about_as_often_as_they_say(between: float, families: float) -> None:
    found = [differences(seed, between=between, families=families) for seed in range(120)]
    means = [rows.groupby("object")["success"].mean().mean() for rows in found]
    errors = np.array([standard_error(rows) for rows in found])
    assert np.mean(errors) == pytest.approx(np.std(means), rel=0.25), "the error is that of the mean over worlds"
    inside = np.abs(np.array(means) - GAIN) < 2.13 * errors  # t of 15 degrees of freedom
    assert 0.89 <= inside.mean() <= 1.0


def test_objects_that_differ_make_intervals_wide_and_the_crossed_bootstrap_is_wider_still() -> None:
    alike, apart = (estimate(differences(3, between=each), OPTIONS) for each in (0.0, 0.4))
    assert apart.high - apart.low > 2 * (alike.high - alike.low)
    assert alike.crossed.high - alike.crossed.low > alike.high - alike.low
    assert (alike.objects, alike.rollouts) == (16, 16 * 20 * 2)
    assert estimate(differences(3), OPTIONS) == estimate(differences(3), OPTIONS)


def test_objects_weigh_alike_and_one_object_has_no_interval() -> None:
    rows = differences(0, objects=2)
    rows = rows[(rows["object"] == "o0") | (rows["seed"] == 0)].assign(success=lambda each: each["object"] == "o0")
    assert estimate(rows, OPTIONS).mean == 0.5
    alone = estimate(rows[rows["object"] == "o0"], OPTIONS)
    assert alone.mean == 1.0 and np.isnan(alone.low) and np.isnan(alone.crossed.low)
    assert estimate(rows[:0], OPTIONS).objects == 0


def test_only_the_same_asset_object_and_seed_are_paired() -> None:
    ours = pd.DataFrame([("o", "f", "a", 0, True), ("o", "f", "a", 1, True), ("o", "g", "b", 0, False)])
    theirs = pd.DataFrame([("o", "f", "a", 0, False), ("p", "f", "a", 1, False), ("o", "g", "b", 0, False)])
    names = [*ROLLOUT, "success"]
    found = pair_cells(ours.set_axis(names, axis=1), theirs.set_axis(names, axis=1))
    assert found[["asset", "success"]].to_numpy().tolist() == [["a", 1.0], ["b", 0.0]]


CONFIG = """
experiment:
  targets:
    door: null
    door_1: {task: door, room: room_1, object: cabinet_1}
    door_2: {task: door, room: room_2, object: sideboard_1}
    drawer_1: {task: drawer, room: room_2, object: chest_of_drawers_1}
  training_sets: [cousins_4, random_4]
  policies: {lite: {}}
  episodes: 16
  seeds: [0, 1]
evaluation: {test_assets: [twin], conditions: {mujoco: {simulator: mujoco}}}
tables: {bootstrap_samples: 200}
"""


def roll_out(results: Path, row: str, name: str, seed: int, opened: int) -> None:
    """Rollouts of one policy on ten unseen assets, the first of which it opens."""
    about = {"target": row, "task": "door", "policy": "lite", "training_set": name, "run": "lite", "seed": seed}
    about |= {"cloud": "target_link", "checkpoint": "best", "test_asset": "test", "handle": "bar", "handle_length": 0.1}
    about |= {"feature_distance": 1.0, "official_success": True, "steps": 9, "opened": 0.5}
    rows = [
        Rollout(**about, asset=f"a{k}", family=f"f{k}", episode=k, initial_state=k, success=k < opened)  # type: ignore[arg-type]
        for k in range(10)
    ]
    write_rows(results / f"evaluation/policies/{row}/lite/{name}/lite/seed_{seed}/rollouts.csv", rows)


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """Doors of two objects with one seed each, a third policy without its pair; no drawers."""
    (tmp_path / "study.yaml").write_text(CONFIG)
    for row, (near, chance) in {"door_1": (4, 7), "door_2": (5, 6)}.items():
        roll_out(tmp_path / "results", row, "cousins_4", 0, near)
        roll_out(tmp_path / "results", row, "random_4", 0, chance)
    roll_out(tmp_path / "results", "door_1", "random_4", 1, 10)
    told = [("door", f"door_{k}", name, 0, p) for k in (1, 2) for name, p in (("cousins_4", 0.5), ("random_4", 0.6))]
    pd.DataFrame(told, columns=sets.FORECAST).to_csv(tmp_path / "forecast.csv", index=False)
    return tmp_path


def test_what_has_run_is_compared_and_the_rest_is_marked(study: Path) -> None:
    out = study / "out"
    sets.run(out=out, configs=(study / "study.yaml",), results=study / "results", forecast=study / "forecast.csv")
    cells, found = pd.read_csv(out / "cells.csv"), pd.read_csv(out / "comparisons.csv")
    assert len(cells) == 2 * 3 * 2 * 2 and (cells["status"] == "run").sum() == 5
    door = found[(found["task"] == "door") & (found["condition"] == "usual")].iloc[0]
    assert (door["training_set"], door["baseline"]) == ("random_4", "cousins_4")
    assert door["mean"] == pytest.approx(0.2) and door["forecast"] == pytest.approx(0.1)
    assert (door["objects"], door["objects_asked"], door["rollouts"]) == (2, 2, 20)
    assert door["preliminary"] and door["verdict"] == "cannot be said"
    text = (out / "sets.md").read_text()
    rows = [line for line in text.splitlines() if line.startswith("| Drawer opening | usual | 4 random assets")]
    assert len(rows) == 2 and all("not run" in line for line in rows)
    assert "cannot be said, preliminary" in text and "2 of 2 objects" in text
    sets.run(out=study / "again", configs=(study / "study.yaml",), results=study / "results")
    assert pd.read_csv(study / "again/comparisons.csv")["mean"].equals(found["mean"]), "also without a forecast"


def test_a_failed_training_counts_and_the_difference_without_it_stands_beside(study: Path) -> None:
    config = sets.read_files((study / "study.yaml",))
    told = pd.read_csv(study / "forecast.csv")
    cells, rollouts = sets.collect(config, study / "results", told)
    failed = (cells["object"] == "door_1") & (cells["training_set"] == "cousins_4") & (cells["seed"] == 0)
    cells["outcome"] = np.where(failed, "did not learn", "learned")
    door = sets.compare(cells, rollouts, config.tables).iloc[0]
    assert door["mean"] == pytest.approx(0.2) and door["learned_mean"] == pytest.approx(0.1)


def test_the_forecast_is_held_against_every_cell() -> None:
    told = [0.1, 0.3, 0.6, 0.9]
    cells = pd.DataFrame({"condition": "usual", "task": "door", "forecast": told, "success": [0.2, 0.4, 0.7, 1.0]})
    whole, *bins = measure_agreement(pd.concat([cells, cells[:1].assign(success=None)])).itertuples()
    assert (whole.bin, whole.cells) == ("all", 4)
    assert [whole.error, whole.correlation, whole.slope] == pytest.approx([0.1, 1, 1])
    assert [row.cells for row in bins] == [1, 1, 1, 1]
