"""Command `trainings`: how every training ended, and which failed: known before any rollout."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from roomkin.plugins.claims.claims import MIN_SPREAD_RUNS
from roomkin.stages.contracts import read_json, trained
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.trained import TrainedPolicy
from roomkin.stages.plugins import shorten_name
from roomkin.stages.tables.rows import in_order, read_table, records, row_title, title
from roomkin.stages.tables.text import NOTHING, TextTable, cell, number, read_notes, write

ALIKE = ["target", "policy", "run"]  # trainings whose losses can be compared: one target's assets, one method
COLUMNS = [
    *("target", "task", "policy", "run", "training_set", "seed", "best_step", "validation_loss", "validation_error"),
    *("constant_error", "plateau", "others", "others_loss", "outcome"),
]
LEARNED, LATE, BEHIND, STUCK = "learned", "learned late", "stayed behind", "did not learn"
FAILED = (LATE, BEHIND, STUCK)
AGAIN = "train the policy again"
FAR = 3.0  # robust standard deviations of the others
PART = 0.25  # of the others' loss; which episodes a seed validates on moved it by up to 0.15 (of 83 trainings)


def collect(configs: Sequence[Path]) -> pd.DataFrame:
    """A row per policy with `COLUMNS`; `configs`: .../<target>/<policy>/<training set>/<run>/seed_<n>/config.json.

    others, others_loss: how many other seeds of its training set learned (or, without any, other trainings of its
    target and policy), and their median loss. Without validation episodes losses and outcome are missing.
    """
    rows: list[dict[str, Any]] = []
    for path in configs:
        config, (target, policy, name, run) = read_json(TrainedPolicy, path, AGAIN), path.absolute().parts[-6:-2]
        outcome = LATE if config.late else LEARNED if config.learned else STUCK
        rows.append(
            {"target": target, "task": shorten_name(config.task), "policy": policy, "run": run, "training_set": name}
            | {"validation_loss": config.best_loss, "validation_error": config.best_error, "seed": config.seed}
            | {"best_step": config.best_step, "constant_error": config.constant_error, "plateau": config.plateau}
            | {"outcome": None if config.best_loss is None else outcome}
        )
    table = in_order(pd.DataFrame(rows, columns=COLUMNS), [*ALIKE, "training_set", "seed"])
    table = table.astype({"validation_loss": float, "plateau": "Int64", "others": "Int64"})
    for index, row in table.dropna(subset="validation_loss").iterrows():
        known = table.drop(index).dropna(subset="validation_loss")
        alike = known[(known[ALIKE] == row[ALIKE]).all(axis=1) & ~known["outcome"].isin([LATE, STUCK])]  # no measure
        of_set = alike.loc[alike["training_set"] == row["training_set"], "validation_loss"]
        of_row = alike["validation_loss"]
        others = of_set if len(of_set) else of_row
        table.loc[index, ["others", "others_loss"]] = len(others), others.median()
        if row["outcome"] == LEARNED and is_behind(row["validation_loss"], of_set, of_row):
            table.loc[index, "outcome"] = BEHIND
    return table


def is_behind(loss: float, of_set: pd.Series, of_row: pd.Series) -> bool:
    """Whether a loss lies far above those of the other seeds, and, if these are few, of the whole row, too.

    A lone seed is not held against other sets: their demonstrations may be easier.
    """
    if not len(of_set) or len(of_row) < MIN_SPREAD_RUNS:
        return False
    return is_far(loss, of_set) and (len(of_set) >= MIN_SPREAD_RUNS or is_far(loss, of_row))


def is_far(loss: float, others: pd.Series) -> bool:
    """Whether a loss lies far above those of the others, by how they differ and by what they reached."""
    median = others.median()
    spread = 1.4826 * (others - median).abs().median()
    return bool(loss - median > max(FAR * spread, PART * abs(median)))


def read_trainings(path: Path | None) -> pd.DataFrame:
    """The frame that `collect` gave, from its file; without one no rows."""
    if path is None:
        return collect([])
    return read_table(path, COLUMNS, ["target", "task", "policy", "run", "training_set", "outcome"]).convert_dtypes(
        convert_floating=False
    )


def failed(table: pd.DataFrame) -> list[str]:
    """A phrase for every training that failed; `table` as `collect` gives."""
    return [
        f"{row_title(row)}, {title(row['training_set'])}{_run(row)}: {_phrase(row)}"
        for row in records(table[table["outcome"].isin(FAILED)])
    ]


def _run(row: dict[str, Any]) -> str:
    """The run, where the policy is not called so."""
    return "" if row["run"] == row["policy"] else f", {row['run']}"


def _phrase(row: dict[str, Any]) -> str:
    text = f"seed {row['seed']} {row['outcome']}: validation loss {number(row['validation_loss'], 1)}"
    return f"{text}, others {number(row['others_loss'], 1)}" if row["others"] else text


def failed_note(table: pd.DataFrame) -> list[str]:
    """The note about failed trainings below a table of rollouts; none without any."""
    phrases = failed(table)
    return [f"Of the trainings these failed, and count like all others: {'; '.join(phrases)}."] if phrases else []


def _cells(group: pd.DataFrame) -> list[str]:
    """The outcome of a training set's trainings over its seeds, and which of them failed."""
    losses = group["validation_loss"].dropna()
    if losses.empty:
        return [cell(NOTHING, count(len(group), "training")), NOTHING, NOTHING, ""]
    ends = f"{number(losses.min(), 2)} to {number(losses.max(), 2)}, {count(len(losses), 'training')}"
    errors = (number(group[name].median(), 2) for name in ("validation_error", "constant_error"))
    phrases = map(_phrase, records(group[group["outcome"].isin(FAILED)]))
    return [cell(number(losses.median(), 2), ends), *errors, "\n".join(phrases)]


def trainings_table(table: pd.DataFrame) -> TextTable:
    """A row per training set and hyper-parameter set; `table` as `collect` gives."""
    groups = table.groupby([*ALIKE, "training_set"], sort=False)
    return TextTable(
        name="trainings",
        caption="Trainings: what they reached on validation episodes, and which failed.",
        columns=["Policy", "Hyper-parameters", "Training set", "Validation loss", "Error", "Constant action", "Failed"],
        rows=[
            [row_title(records(group)[0]), str(run), title(str(name)), *_cells(group)]
            for (*_, run, name), group in groups
        ],
        headers=3,
        notes=read_notes(
            "trainings", "roomkin.plugins.claims", late=trained.LATE, part=PART, far=f"{FAR:g}",
            min_spread_runs=MIN_SPREAD_RUNS,
        ),
    )  # fmt: skip


def run(*, out: Path, policies: tuple[Path, ...] = ()) -> None:
    """Write trainings (.csv, .html, .tex), and name those that failed.

    Args:
        out: folder to write into.
        policies: config.json of the policies, in the fixed layout of results/training.
    """
    table = collect(policies)
    write(out, "trainings", table, [trainings_table(table)])
    print(f"claims: {count(len(table), 'training')}, {len(failed(table)) or 'none'} failed", file=sys.stderr)
    for phrase in failed(table):
        print(f"claims: {phrase}", file=sys.stderr)
