"""Verb `sets`: how training sets compare over many objects, measured and forecast; also while a study is running."""

from collections.abc import Iterator
from itertools import combinations, islice, product
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from plugins.claims import trainings
from plugins.claims.claims import FAILS, HOLDS, OPEN
from plugins.studies.forecasts import FORECAST, agreement_table, measure_agreement
from plugins.studies.objects import ROLLOUT, Estimate, estimate, pair_cells
from plugins.studies.progress import policy_file
from plugins.studies.set_tables import comparisons_table, sets_table
from stages.config.evaluation import USUAL
from stages.config.model import Config, read_files
from stages.config.tables import TablesConfig
from stages.config.targets import Cell
from stages.contracts.files import write_text
from stages.contracts.policies import Rollout
from stages.tables.markup import markdown
from stages.tables.rows import ONE_TEST, read_rows, read_table
from stages.tables.writing import write_csv

CELL = ["condition", "task", "object", "training_set", "seed"]
PART = ["condition", "task"]
POLICY = ["object", "training_set", "seed"]
ESTIMATE = ["objects", "families", "rollouts", "mean", "low", "high", "crossed_low", "crossed_high"]
CELLS = [*CELL, "assets", "success", "forecast", "outcome", "status"]
SETS = [*PART, "training_set", "policies", "policies_asked", *ESTIMATE, "forecast", "status"]
COMPARISONS = [*PART, "training_set", "baseline", "objects_asked", *ESTIMATE, "forecast", "verdict", "preliminary"]
COMPARISONS += ["learned_mean", "learned_low", "learned_high"]
SUCCESS = [*PART, *ROLLOUT, "training_set", "success"]  # of a rollout


def run(
    *,
    out: Path,
    configs: tuple[Path, ...] = (Path("config.yaml"),),
    results: Path = Path("results"),
    forecast: Path | None = None,
) -> None:
    """Write cells.csv, sets.csv, comparisons.csv, agreement.csv and sets.md; what has not run is marked `not run`.

    Every target is an object; what is compared is success over its unseen assets, of its first policy.

    Args:
        out: folder to write into.
        configs: the config files of the study, later ones over earlier ones.
        results: folder that the study writes.
        forecast: success to be expected, written before any rollout: a CSV with task, object, training_set, seed,
            forecast.
    """
    config = read_files(configs)
    predicted = read_table(forecast, FORECAST, FORECAST[:3]) if forecast else pd.DataFrame(columns=FORECAST)
    cells, rollouts = collect(config, results, predicted)
    frames = {
        "cells": cells,
        "sets": of_sets(cells, rollouts, config.tables),
        "comparisons": compare(cells, rollouts, config.tables),
        "agreement": measure_agreement(cells),
    }
    for name, frame in frames.items():
        write_csv(out / f"{name}.csv", frame)
    tables = [
        comparisons_table(frames["comparisons"]),
        sets_table(frames["sets"]),
        agreement_table(frames["agreement"]),
    ]
    text = [
        "# Training sets over many objects",
        *map(markdown, tables),
        *trainings.failed_note(list_outcomes(config, results)),
    ]
    write_text(out / "sets.md", "\n\n".join(part.strip() for part in text) + "\n")


class Asked(NamedTuple):
    """A policy that the study asks for, under a condition."""

    condition: str
    task: str
    object: str
    training_set: str
    seed: int
    policy: str
    run: str


def list_policies(config: Config) -> Iterator[Asked]:
    """All policies that the study asks for, under the usual condition and the others."""
    for condition in (USUAL, *config.evaluation.conditions):
        for target in config.experiment.targets:
            task = config.experiment.task(target)
            for policy, plan in islice(config.experiment.plans(target).items(), 1):
                for name, seed in product(plan.training_sets, plan.seeds):
                    yield Asked(condition, task, target, name, seed, policy, plan.configs[0])


def collect(config: Config, results: Path, predicted: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """A row with `CELLS` per policy that is asked for, and the rollouts with `SUCCESS` of those that have run."""
    rows: list[dict[str, Any]] = []
    parts = [pd.DataFrame(columns=SUCCESS)]
    for one in list_policies(config):
        folder = "" if one.condition == USUAL else one.condition
        path = policy_file(results, folder, Cell(one.object, one.policy, one.training_set), one.run, one.seed)
        about: dict[str, Any] = dict(zip(CELL, one, strict=False)) | {"status": "not run"}
        if path.is_file():
            found = read_rows(Rollout, [path], ONE_TEST)
            part = found[found["test_asset"] == config.evaluation.split]
            part = part.assign(condition=one.condition, task=one.task, object=one.object)
            parts.append(part[SUCCESS])
            about |= {"status": "run", "assets": len(part), "success": part["success"].mean()}
        rows.append(about)
    outcomes = list_outcomes(config, results).rename(columns={"target": "object"})[[*POLICY, "outcome"]]
    cells = pd.DataFrame(rows, columns=[*CELL, "assets", "success", "status"]).astype({"assets": "Int64"})
    cells = cells.merge(outcomes, "left", on=POLICY).merge(predicted[FORECAST], "left", on=["task", *POLICY])
    return cells[CELLS], pd.concat(parts[1:] or parts, ignore_index=True)


def list_outcomes(config: Config, results: Path) -> pd.DataFrame:
    """How the trainings ended that are there (`trainings.collect`)."""
    folders = {
        f"{one.object}/{one.policy}/{one.training_set}/{one.run}/seed_{one.seed}" for one in list_policies(config)
    }
    paths = [results / f"training/{folder}/config.json" for folder in sorted(folders)]
    return trainings.collect([path for path in paths if path.is_file()])


def of_sets(cells: pd.DataFrame, rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row with `SETS` per condition, task and training set."""
    rows = []
    for key, part in cells.groupby([*PART, "training_set"], sort=False):
        ran = part[part["status"] == "run"]
        row = dict(zip([*PART, "training_set"], key, strict=True)) | {"policies": len(ran), "policies_asked": len(part)}
        row |= {"status": "run" if len(ran) else "not run", "forecast": average_objects(ran, "forecast")}
        rows.append(row | numbers(estimate(_part(rollouts, *map(str, key)), options)))
    return pd.DataFrame(rows, columns=SETS)


def compare(cells: pd.DataFrame, rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row with `COMPARISONS` per condition, task and pair of training sets.

    Policies of one object and seed are compared, on the same assets. forecast: of those same policies; learned_...:
    without the pairs of which a training did not learn or stayed behind.
    """
    rows = []
    for key, part in cells.groupby(PART, sort=False):
        condition, task = map(str, key)
        policies = {
            str(name): of.set_index(["object", "seed"]) for name, of in part.groupby("training_set", sort=False)
        }
        for baseline, name in combinations(policies, 2):
            ours, theirs = policies[name], policies[baseline]
            pairs = pair_cells(_part(rollouts, condition, task, name), _part(rollouts, condition, task, baseline))
            ran = pd.MultiIndex.from_frame(pairs[["object", "seed"]].drop_duplicates())
            bad = [side.index[side["outcome"].isin([trainings.BEHIND, trainings.STUCK])] for side in (ours, theirs)]
            kept = ~pd.MultiIndex.from_frame(pairs[["object", "seed"]]).isin(bad[0].union(bad[1]))
            predicted = (ours["forecast"] - theirs["forecast"]).loc[ran].reset_index()
            found, learned = estimate(pairs, options), estimate(pairs[kept], options)
            row: dict[str, Any] = {"condition": condition, "task": task, "training_set": name, "baseline": baseline}
            row |= {"objects_asked": part["object"].nunique(), "preliminary": len(ran) < len(ours), **numbers(found)}
            row |= {"forecast": average_objects(predicted, "forecast"), "verdict": judge_difference(found)}
            row |= {"learned_mean": learned.mean, "learned_low": learned.low, "learned_high": learned.high}
            rows.append(row)
    return pd.DataFrame(rows, columns=COMPARISONS)


def judge_difference(found: Estimate) -> str:
    """Whether the side opens more than its baseline, by the interval of the difference."""
    return HOLDS if found.low > 0 else FAILS if found.high < 0 else OPEN


def numbers(found: Estimate) -> dict[str, Any]:
    """An estimate as columns."""
    return dict(zip(ESTIMATE, [*found[:-1], *found.crossed], strict=True))


def average_objects(rows: pd.DataFrame, column: str) -> float:
    """The mean of a column, objects alike; NaN without rows."""
    return float(rows.groupby("object")[column].mean().mean())


def _part(rollouts: pd.DataFrame, condition: str, task: str, name: str) -> pd.DataFrame:
    wanted = {"condition": condition, "task": task, "training_set": name}
    return rollouts[(rollouts[list(wanted)] == list(wanted.values())).all(axis=1)][[*ROLLOUT, "success"]]
