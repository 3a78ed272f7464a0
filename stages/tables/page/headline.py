"""The few numbers at the top of the page, each with its interval."""

from dataclasses import dataclass

import pandas as pd

from stages.config.tables import TablesConfig
from stages.tables.markup import number, percent, span
from stages.tables.page.library import LibraryPart
from stages.tables.page.policies import TaskPart
from stages.tables.rows import records
from stages.tables.statistics import wilson
from stages.tables.table2 import TOTAL


@dataclass(frozen=True)
class Tile:
    """A number, what it is, and how sure it is."""

    value: str
    label: str
    detail: str = ""


def rate(successes: int, episodes: int, confidence: float) -> str:
    """'31/50, 48–75 %': counts with their Wilson interval."""
    low, high = wilson(successes, episodes, confidence)
    return f"{successes}/{episodes}, {span(low, high)} %"


def _scene_tiles(table: pd.DataFrame, confidence: float) -> list[Tile]:
    tiles = []
    for row in records(table[table["scene"] == TOTAL]):
        variant, objects = f"variant ({row['variant']})", int(row["n_objects"])
        right = int(row["model_correct"])
        tiles.append(Tile(percent(right / objects), f"right model, {variant}", rate(right, objects, confidence)))
        detail = f"{number(row['l2_cm_low'], 1)}–{number(row['l2_cm_high'], 1)} cm, {row['n_placed']} objects"
        tiles.append(Tile(f"{number(row['l2_cm_mean'], 1)} cm", f"off the true place, {variant}", detail))
    return tiles


def tiles(
    scenes: pd.DataFrame | None,
    library: LibraryPart | None,
    tasks: list[TaskPart],
    options: TablesConfig,
) -> list[Tile]:
    """The tiles of what was run; nothing is said of the rest."""
    found = []
    if library:
        detail = f"{library.with_doors} with doors, {library.with_drawers} with drawers"
        found.append(Tile(str(library.models), f"models in {len(library.categories)} categories", detail))
    if scenes is not None:
        found += _scene_tiles(scenes, options.confidence)
    attempts = sum(item.attempts for task in tasks for item in task.demonstrations)
    if attempts:
        successes = sum(item.successes for task in tasks for item in task.demonstrations)
        counts = rate(successes, attempts, options.confidence)
        found.append(Tile(percent(successes / attempts), "of demonstrations succeed", counts))
    return found
