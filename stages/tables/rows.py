"""Rows of results: their order and titles, how they are read, and rates per cell of a table."""

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import BaseModel

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts import files
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_text
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.contracts.policy_config import is_randomised, is_set, read_set, strip_randomised
from roomkin.stages.tables.intervals import difference_interval, pair_sides, rate_interval, rate_of, side_of

TASKS = {front: f"{front} opening".capitalize() for front in FRONTS} | {"put_away_bowl": "Putting away bowl"}
SPLITS = ("test", "validation")  # test assets that are sets of unseen assets
SKILL = "skill"  # training set of the scripted skill's rows
NAMES = {"all": "all assets", "trained": "training assets"}
NAMES |= {"test": "unseen assets", "validation": "unseen assets (validation)", "unseen": "held-out roles"}
NAMES |= {SKILL: "scripted skill", "matched": "matched by the run"}
SETS = {"cousins": "cousins", "random": "random assets", "cover": "covering assets"}  # training sets by their rules
CLOUDS = {"target_link": "cloud of the target link", "object": "cloud of the whole object"}
VARIANTS = {  # as the paper has them; what decided in a run stands in cousins.json
    "a": "encoder model, VLM orientation",
    "b": "encoder model, encoder orientation",
    "c": "VLM model, VLM orientation",
    "d": "VLM model, encoder orientation",
}

DEFAULT = "default"  # the variant of config.yaml
NO_IMAGE = "no-image"  # the variant of config/study/table2.yaml that judges are read against


def sort_key(text: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key under which room_2 comes before room_10."""
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", str(text)))


def variant_key(name: str) -> tuple[bool, tuple[tuple[int, int, str], ...]]:
    """Sort key of a variant: that of config.yaml first."""
    return name != DEFAULT, sort_key(name)


def set_key(name: str) -> tuple[int, tuple[tuple[int, int, str], ...]]:
    """Sort key of a training set or test asset: twin, by number, 'all', 'dissimilar', 'trained', sets, the skill."""
    first = {"twin": 0, "all": 2, "dissimilar": 2, "trained": 3, "unseen": 4}
    return ((first | dict.fromkeys(SPLITS, 5) | {SKILL: 6}).get(strip_randomised(name), 1), sort_key(name))


def title(name: str) -> str:
    """A name for people: cousins_4 -> '4 cousins', cousin_2 -> 'cousin 2', cover_8_randomised -> '8 covering assets,
    randomised'."""
    if is_randomised(name):
        return f"{title(strip_randomised(name))}, randomised"
    if is_set(name) and (read := read_set(name)).rule in SETS:
        return f"{read.size} {SETS[read.rule]}"
    return NAMES.get(name, name.replace("_", " "))


def task_title(task: str) -> str:
    """A task for people."""
    return TASKS.get(task, title(task).capitalize())


def target_title(target: str, task: str) -> str:
    """A target for people, by what is done there: 'Door opening', 'Door opening, room 1' (door_room_1)."""
    rest = title(target.removeprefix(f"{task}_"))
    return task_title(task) if target in task else f"{task_title(task)}, {rest}"


def row_title(row: Mapping[str, Any]) -> str:
    """A row of a table for people: its target and its policy, which the paper's and the skill's do not have."""
    target, policy = target_title(row["target"], row["task"]), row["policy"]
    return target if policy in ("", SKILL) else f"{target}, {policy}"


# Columns that name one file of rows.
ONE_SCENE = ["scene", "variant", "rank", "protocol", "draw"]
ONE_TEST = ["target", "policy", "training_set", "run", "seed", "checkpoint", "test_asset"]
PUBLISHED_2 = [
    "scene", "n_objects", "scale_m", "variant", "category_correct", "model_correct", "l2_cm_mean", "l2_cm_std",
    "orientation_paper_rad_mean", "orientation_paper_rad_std", "iou_mean", "iou_std", "oriented_iou_mean",
    "oriented_iou_std",
]  # fmt: skip
PAPER_TASKS = {"bowl": "put_away_bowl"}  # as the paper calls them -> as we do
PUBLISHED_3 = ["task", "test_asset", "dino_distance", "training_set", "run", "success_percent"]


def read_rows(model: type[BaseModel], paths: Sequence[Path], one_file: list[str]) -> pd.DataFrame:
    """All rows of some CSV files, each validated against `model`; a column per field, in the model's order.

    An empty cell of an optional field is None. Rows that agree in all `one_file` columns must come from one file: the
    same rows given twice would count twice.

    Raises:
        InputError: a file is missing, a row breaks the contract (file, line and field named), or two files
            hold the same rows.
    """
    rows = []
    source: dict[tuple[object, ...], int] = {}
    for number, path in enumerate(paths):
        for line in files.read_rows(model, path, "write it with `roomkin evaluation`"):
            row = line.model_dump()
            key = tuple(row[name] for name in one_file)
            if source.setdefault(key, number) != number:
                same = ", ".join(f"{name} {value}" for name, value in zip(one_file, key, strict=True))
                what = f"holds the same rows as {paths[source[key]]} ({same})."
                raise InputError(path, what, "give each file once", code="E-ROWS-TWICE")
            rows.append(row)
    return pd.DataFrame(rows, columns=list(model.model_fields))


def read_table(path: Path, columns: list[str], text: Sequence[str] = ()) -> pd.DataFrame:
    """A CSV table that has at least `columns`; the columns in `text` stay text, missing values there are ''.

    Raises:
        InputError: the file is missing, is not CSV, or lacks a column.
    """
    source = io.StringIO(read_text(path))
    try:
        table = pd.read_csv(source, dtype=dict.fromkeys(text, str), keep_default_na=False, na_values=[""])
    except ValueError as error:  # also pandas' parser errors
        raise InputError(path, f"is not a CSV table ({str(error).splitlines()[0]}).", code="E-TABLE-CSV") from None
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise InputError(path, f"lacks the column {missing[0]}.", code="E-TABLE-COLUMN")
    return table.fillna({name: "" for name in text if name in table})


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table as dictionaries."""
    return table.to_dict("records")  # type: ignore[return-value]


def published_scenes(folder: Path) -> pd.DataFrame:
    """Table 2 of the paper, indexed by (scene number, variant)."""
    return read_table(folder / "table2.csv", PUBLISHED_2, text=["variant"]).set_index(["scene", "variant"])


def published_runs(folder: Path) -> pd.DataFrame:
    """Table 3 of the paper, a row per cell and run: `PUBLISHED_3` and `rate`, the success in [0, 1]."""
    table = read_table(folder / "table3.csv", PUBLISHED_3, text=["task", "test_asset", "training_set"])
    return table.assign(task=table["task"].replace(PAPER_TASKS), rate=table["success_percent"] / 100)


def published_policies(folder: Path) -> pd.DataFrame:
    """Table 3 of the paper: one row per cell (task, test_asset, training_set) with mean and std over its runs.

    Columns: the three keys, `feature_distance`, `runs`, `mean` and `std` (sample) of the success rate in [0, 1].
    """
    cells = published_runs(folder).groupby(["task", "test_asset", "training_set"], sort=False)
    columns = {"feature_distance": ("dino_distance", "first"), "runs": ("rate", "count")}
    return cells.agg(**columns, mean=("rate", "mean"), std=("rate", "std")).reset_index()


ROW = ["target", "task", "policy"]
CELL = ["target", "policy", "test_asset", "training_set"]
RATE = [
    "task", "cloud", "feature_distance", "assets", "families", "places", "runs", "episodes", "successes",
    "official_successes", "steps", "mean", "std", "low", "high",
]  # fmt: skip
GAIN = ["assets", "places", "runs", "baseline_runs", "difference", "low", "high"]


def in_order(table: pd.DataFrame, by: Sequence[str] = CELL) -> pd.DataFrame:
    """Targets and policies in the order in which they come, in the paper's order of test assets and training sets."""

    def places(column: pd.Series) -> pd.Series:
        if column.name in ROW:
            return pd.Series(pd.factorize(column)[0], column.index).mask(column == SKILL, len(column))
        return column.map(set_key) if column.name in CELL else column

    return table.sort_values([name for name in by if name in table], key=places, ignore_index=True)


def rates(rollouts: pd.DataFrame, by: Sequence[str], options: TablesConfig) -> pd.DataFrame:
    """A row per group of rollouts that agree in `by`, with `RATE`.

    `mean`: over assets, their states and runs, assets alike; `std`: sample deviation over runs; `places`: initial
    states over all assets; `steps`: the mean of the episodes that succeed, NaN: none does.
    """
    rows: list[dict[str, Any]] = []
    for key, group in rollouts.groupby(list(by), sort=False):
        side = side_of(group)
        low, high = rate_interval(side, options)
        rows.append(
            dict(zip(by, key, strict=True))
            | {"task": group["task"].iloc[0], "cloud": group["cloud"].iloc[0]}
            | {"feature_distance": float(group["feature_distance"].mean()), "places": side.shape[1], "runs": len(side)}
            | {"assets": group["asset"].nunique(), "families": group["family"].nunique(), "episodes": len(group)}
            | {"successes": int(group["success"].sum()), "official_successes": int(group["official_success"].sum())}
            | {"steps": float(group.loc[group["success"], "steps"].mean())}
            | {"mean": rate_of(side), "std": side.mean(axis=1).std(), "low": low, "high": high}
        )
    return in_order(pd.DataFrame(rows, columns=list(dict.fromkeys([*by, *RATE]))))


def tabulate_gains(
    rollouts: pd.DataFrame, within: Sequence[str], side: str, baseline: str, options: TablesConfig, same: bool = False
) -> pd.DataFrame:
    """Success of every value of the column `side` minus that of `baseline`, a row each with `within`, `side`, `GAIN`.

    Only places where all policies of both were tested are compared, so that the pairs are whole.

    Args:
        same: both sides are the same policies: those that are on one alone are left out.
    """
    rows: list[dict[str, Any]] = []
    for key, group in rollouts.groupby(list(within), sort=False):
        sides = {str(name): side_of(part) for name, part in group.groupby(side, sort=False)}
        for name in sides if baseline in sides else ():
            ours, theirs = sides[name], sides[baseline]
            if same:
                policies = ours.index.intersection(theirs.index)
                ours, theirs = ours.loc[policies], theirs.loc[policies]
            ours, theirs = pair_sides(ours, theirs)
            if name == baseline or ours.empty:
                continue
            low, high = difference_interval(ours, theirs, options, same)
            rows.append(
                dict(zip(within, key, strict=True))
                | {side: name, "assets": ours.columns.get_level_values("asset").nunique(), "places": ours.shape[1]}
                | {"runs": len(ours), "baseline_runs": len(theirs)}
                | {"difference": rate_of(ours) - rate_of(theirs), "low": low, "high": high}
            )
    return in_order(pd.DataFrame(rows, columns=[*within, side, *GAIN]))
