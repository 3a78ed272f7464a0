"""Read the rows that `evaluation` wrote and the values that the paper published."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import BaseModel

from roomkin.stages.contracts import files
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_text

# Columns that name one file of rows.
ONE_SCENE = ["scene", "variant", "rank", "protocol", "draw"]
ONE_TEST = ["target", "policy", "training_set", "run", "seed", "checkpoint", "test_asset"]
PUBLISHED_2 = [
    "scene", "n_objects", "scale_m", "variant", "category_correct", "model_correct", "l2_cm_mean", "l2_cm_std",
    "orientation_paper_rad_mean", "orientation_paper_rad_std", "iou_mean", "iou_std", "oriented_iou_mean",
    "oriented_iou_std",
]  # fmt: skip
TASKS = {"bowl": "put_away_bowl"}  # as the paper calls them -> as we do
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
    return table.assign(task=table["task"].replace(TASKS), rate=table["success_percent"] / 100)


def published_policies(folder: Path) -> pd.DataFrame:
    """Table 3 of the paper: one row per cell (task, test_asset, training_set) with mean and std over its runs.

    Columns: the three keys, `feature_distance`, `runs`, `mean` and `std` (sample) of the success rate in [0, 1].
    """
    cells = published_runs(folder).groupby(["task", "test_asset", "training_set"], sort=False)
    columns = {"feature_distance": ("dino_distance", "first"), "runs": ("rate", "count")}
    return cells.agg(**columns, mean=("rate", "mean"), std=("rate", "std")).reset_index()
