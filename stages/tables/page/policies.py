"""The page's section about the policy experiment: assets, demonstrations, training, rollouts."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from stages.contracts.files import read_json
from stages.contracts.in_scene import SceneDemonstrations
from stages.contracts.ledgers import read_attempts, read_metrics
from stages.contracts.policies import TaskAssets
from stages.contracts.snapshot_pictures import Snapshots
from stages.tables.markup import Table
from stages.tables.order import natural, role_title, set_key, task_key, title
from stages.tables.page.charts import Points, line_chart
from stages.tables.page.files import RunFiles
from stages.tables.page.films import FilmedAsset, read_films
from stages.tables.page.pictures import Album, Picture
from stages.tables.roles import lists_table, roles_table, used_roles
from stages.tables.statistics import wilson
from stages.tables.text import NOTHING, cell, percent, span

STEPS = ("step", "steps", "update", "iteration", "epoch")


@dataclass(frozen=True)
class TaskPart:
    """The whole experiment on one task.

    scene: holds the object that was matched. curves: policy -> chart of its training; rollouts: policy -> films of it.
    in_scenes: films of demonstrations inside generated scenes; not_in_scenes: scene -> why there is none.
    """

    task: str
    title: str
    scene: str
    source: str
    pictures: list[Picture]
    assets: list[Table]
    demonstrations: Table | None
    films: list[FilmedAsset]
    curves: dict[str, Markup]
    rollouts: dict[str, list[FilmedAsset]]
    in_scenes: list[FilmedAsset]
    not_in_scenes: dict[str, str]


def losses(rows: list[dict[str, Any]]) -> tuple[str, dict[str, Points]]:
    """The step's name and every loss (a key with 'loss' or 'nll' in it) as points of a metrics file."""
    step = next((name for name in STEPS if any(name in row for row in rows)), "line")
    series: dict[str, Points] = {}
    for index, row in enumerate(rows):
        for key, value in row.items():
            if isinstance(value, int | float) and ("loss" in key or "nll" in key):
                series.setdefault(key, []).append((float(row.get(step, index)), float(value)))
    return step, series


def _demonstrations(ledgers: list[Path], task: str, confidence: float) -> Table | None:
    """A row per asset: success with its interval, and why attempts failed."""
    rows = []
    for ledger in ledgers:
        tried = read_attempts(ledger)
        kept = sum(attempt.success for attempt in tried)
        low, high = wilson(kept, len(tried), confidence)
        failures = Counter(attempt.cause.replace("_", " ") for attempt in tried if not attempt.success)
        causes = ", ".join(f"{cause} {times}" for cause, times in failures.most_common()) or NOTHING
        rate = cell(percent(kept / len(tried)), f"[{span(low, high)}]")
        rows.append([role_title(ledger.parent.name), tried[0].asset, rate, f"{kept}/{len(tried)}", causes])
    columns = ["Asset", "Model", "Success", "Kept / tried", "Why attempts failed"]
    caption = "Demonstrations by asset; only successes become data."
    return Table(f"demonstrations-{task}", caption, columns, rows, headers=2) if rows else None


def _policy_name(folder: Path) -> str:
    """.../<training set>/<run>/seed_<n> -> 'trained on 4 cousins, lite, seed 0'."""
    return f"trained on {title(folder.parents[1].name)}, {folder.parent.name}, {title(folder.name)}"


def _folder_key(path: Path) -> Any:
    folder = path.parent
    return set_key(folder.parents[1].name), folder.parent.name, natural(folder.name)


def _curves(files: RunFiles, task: str) -> dict[str, Markup]:
    found = {}
    for path in sorted(files.all(f"training/{task}/*/*/*/metrics.jsonl"), key=_folder_key):
        step, series = losses(read_metrics(path))
        name = _policy_name(path.parent)
        if chart := line_chart(series, step, f"Loss of the policy {name}"):
            found[name] = chart
    return found


def _rollouts(files: RunFiles, task: str, album: Album) -> dict[str, list[FilmedAsset]]:
    archives = sorted(files.all(f"evaluation/policies/{task}/*/*/*/films.zip"), key=_folder_key)
    named = {_policy_name(path.parent): path for path in archives}
    films = {name: read_films(path, f"Rollout of the policy {name},", album) for name, path in named.items()}
    return {name: cells for name, cells in films.items() if cells}


def _not_in_scenes(path: Path | None) -> dict[str, str]:
    found = read_json(SceneDemonstrations, path).demonstrations if path else []
    return {title(f"rank_{one.rank}"): one.reason for one in found if one.status == "failed"}


def _pictures(assets: TaskAssets | None, used: set[str], album: Album, snapshots: Snapshots) -> list[Picture]:
    """The assets of the roles that were not drawn or are used."""
    kept = [(role, asset.asset) for role, asset in used_roles(assets, used).items()] if assets else []
    made = [
        album.thumbnail(snapshots.picture(asset), f"{role_title(role)}: {asset.replace('_', ' ')}")
        for role, asset in kept
    ]
    return [picture for picture in made if picture]


def _task(
    files: RunFiles, task: str, chosen: Path | None, album: Album, snapshots: Snapshots, confidence: float
) -> TaskPart:
    assets = read_json(TaskAssets, chosen) if chosen else None
    ledgers = sorted(files.all(f"demonstrations/{task}/*/attempts.jsonl"), key=lambda path: set_key(path.parent.name))
    roles = {path.parent.name for path in ledgers}
    tables = [roles_table(assets, roles, f"roles-{task}", "Assets by role.")] if assets else []
    films = [
        film for path in ledgers
        for film in read_films(files.one(f"{task}/{path.parent.name}/films.zip"), "Demonstration", album)
    ]  # fmt: skip
    return TaskPart(
        task=task,
        title=title(task),
        scene=assets.scene if assets else "",
        source=f"{title(assets.object)} of {title(assets.scene)}" if assets else "",
        pictures=_pictures(assets, roles, album, snapshots),
        assets=tables + (lists_table(assets, f"lists-{task}", "Sets of assets.") if assets else []),
        demonstrations=_demonstrations(ledgers, task, confidence),
        films=films,
        curves=_curves(files, task),
        rollouts=_rollouts(files, task, album),
        in_scenes=read_films(files.one(f"{task}/in_scene/films.zip"), "Demonstration in the scene", album),
        not_in_scenes=_not_in_scenes(files.one(f"demonstrations/{task}/in_scene/in_scene.json")),
    )


def collect(files: RunFiles, album: Album, confidence: float) -> list[TaskPart]:
    """Every task of the run, in the paper's order."""
    snapshots = Snapshots(files.all("assets/snapshots/shard_*.h5"))
    chosen = {path.parent.name: path for path in files.all("experiment/*/*/assets.json")}
    tasks = {
        *chosen,
        *files.names("demonstrations/*/*/attempts.jsonl", 1),
        *files.names("training/*/*/*/*/metrics.jsonl", 3),
        *files.names("evaluation/policies/*/*/*/*/films.zip", 3),
    }
    return [_task(files, task, chosen.get(task), album, snapshots, confidence) for task in sorted(tasks, key=task_key)]
