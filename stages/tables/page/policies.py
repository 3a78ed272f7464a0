"""What the page says of the policy experiment: assets, demonstrations, training, rollouts."""

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup
from pydantic import ValidationError

from stages.contracts.errors import InputError
from stages.contracts.files import first_error, read_json, read_text
from stages.contracts.policies import Attempt, TaskAsset, TaskAssets
from stages.tables.order import natural, set_key, task_key, title
from stages.tables.page.charts import Points, line_chart
from stages.tables.page.pictures import Album, Picture

STEPS = ("step", "steps", "update", "iteration", "epoch")


@dataclass(frozen=True)
class Demonstrations:
    """The attempts on one asset; `causes` counts the failures, most frequent first."""

    role: str
    attempts: int
    successes: int
    causes: list[tuple[str, int]]
    film: Picture | None


@dataclass(frozen=True)
class Line:
    """An asset of the experiment (None: not in the list of matching) and its demonstrations (None: not collected)."""

    role: str
    asset: TaskAsset | None
    demonstrations: Demonstrations | None


@dataclass(frozen=True)
class Curve:
    """Training of one policy."""

    name: str
    chart: Markup


@dataclass(frozen=True)
class Films:
    """Rollouts of one policy, a strip per test asset."""

    name: str
    strips: list[Picture]


@dataclass(frozen=True)
class TaskPart:
    """The whole experiment on one task."""

    task: str
    title: str
    source: str
    lines: list[Line]
    curves: list[Curve]
    films: list[Films]

    @property
    def demonstrations(self) -> list[Demonstrations]:
        """Those that were collected."""
        return [line.demonstrations for line in self.lines if line.demonstrations]


def read_lines(path: Path) -> list[dict[str, Any]]:
    """The objects of a JSON-lines file.

    Raises:
        InputError: a line is no JSON object (file and line named).
    """
    rows = []
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        try:
            row = json.loads(line)
        except json.JSONDecodeError as error:
            raise InputError(f"{path}:{number}", f"is not JSON ({error.msg}).") from None
        if not isinstance(row, dict):
            raise InputError(f"{path}:{number}", "is not a JSON object.")
        rows.append(row)
    return rows


def read_attempts(path: Path) -> list[Attempt]:
    """The ledger of one asset."""
    attempts = []
    for number, row in enumerate(read_lines(path), start=1):
        try:
            attempts.append(Attempt.model_validate(row))
        except ValidationError as error:
            raise InputError(f"{path}:{number}", f"breaks the Attempt contract at {first_error(error)}.") from None
    return attempts


def _demonstrations(folder: Path, album: Album) -> Demonstrations:
    attempts = read_attempts(folder / "attempts.jsonl")
    failed = Counter(attempt.cause for attempt in attempts if not attempt.success)
    causes = sorted(failed.items(), key=lambda item: (-item[1], item[0]))
    film = album.maybe(folder / "film.png", f"Film strip: a demonstration on {title(folder.name)}")
    return Demonstrations(folder.name, len(attempts), len(attempts) - sum(failed.values()), causes, film)


def losses(rows: list[dict[str, Any]]) -> tuple[str, dict[str, Points]]:
    """The step's name and every loss (a key with 'loss' or 'nll' in it) as points of a metrics file."""
    step = next((name for name in STEPS if any(name in row for row in rows)), "line")
    series: dict[str, Points] = {}
    for index, row in enumerate(rows):
        for key, value in row.items():
            if isinstance(value, int | float) and ("loss" in key or "nll" in key):
                series.setdefault(key, []).append((float(row.get(step, index)), float(value)))
    return step, series


def _policy_name(folder: Path) -> str:
    """.../<training set>/<run>/seed_<n> -> 'trained on 4 cousins, lite, seed 0'."""
    return f"trained on {title(folder.parents[1].name)}, {folder.parent.name}, {title(folder.name)}"


def _folder_key(folder: Path) -> Any:
    return set_key(folder.parents[1].name), folder.parent.name, natural(folder.name)


def _curves(results: Path, task: str) -> list[Curve]:
    curves = []
    folders = {path.parent for path in results.glob(f"training/{task}/*/*/*/metrics.jsonl")}
    for folder in sorted(folders, key=_folder_key):
        step, series = losses(read_lines(folder / "metrics.jsonl"))
        name = _policy_name(folder)
        curves.append(Curve(name, line_chart(series, step, f"Loss of the policy {name}")))
    return [curve for curve in curves if curve.chart]


def _films(results: Path, task: str, album: Album) -> list[Films]:
    folders = {path.parent for path in results.glob(f"evaluation/policies/{task}/*/*/*/film_*.png")}
    films = []
    for folder in sorted(folders, key=_folder_key):
        name = _policy_name(folder)
        paths = sorted(folder.glob("film_*.png"), key=lambda path: set_key(path.stem.removeprefix("film_")))
        strips = [album.add(p, f"Rollout on {title(p.stem.removeprefix('film_'))}, policy {name}") for p in paths]
        films.append(Films(name, strips))
    return films


def collect(results: Path, album: Album) -> list[TaskPart]:
    """Every task of which anything was made, in the paper's order."""
    chosen = {path.parent.name: path for path in sorted(results.glob("experiment/*/*/assets.json"))}
    folders = [*results.glob("demonstrations/*"), *results.glob("training/*"), *results.glob("evaluation/policies/*")]
    parts = []
    for task in sorted({*chosen, *(folder.name for folder in folders if folder.is_dir())}, key=task_key):
        assets = read_json(TaskAssets, chosen[task]) if task in chosen else None
        known = {item.role: item for item in assets.assets} if assets else {}
        ledgers = results.glob(f"demonstrations/{task}/*/attempts.jsonl")
        done = {path.parent.name: _demonstrations(path.parent, album) for path in ledgers}
        roles = [*known, *sorted(set(done) - set(known), key=set_key)]
        parts.append(
            TaskPart(
                task=task,
                title=title(task),
                source=f"{title(assets.object)} of {title(assets.scene)}" if assets else "",
                lines=[Line(role, known.get(role), done.get(role)) for role in roles],
                curves=_curves(results, task),
                films=_films(results, task, album),
            )
        )
    return parts
