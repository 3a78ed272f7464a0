"""The page's section about the policy experiment: assets, demonstrations, training, rollouts."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from plugins.in_scene.contract import SceneDemonstrations
from plugins.report.album import Album, Picture
from plugins.report.page.charts import Points, line_chart
from plugins.report.page.files import RunFiles
from plugins.report.page.films import FilmedAsset, read_films
from plugins.report.roles import lists_table, role_title, roles_table, used_roles
from plugins.report.snapshots import Snapshots
from stages.contracts.files import read_json
from stages.contracts.ledgers import read_attempts, read_metrics
from stages.contracts.policies import TaskAssets
from stages.tables.markup import Table
from stages.tables.order import set_key, sort_key, target_title, title
from stages.tables.statistics import wilson
from stages.tables.text import NOTHING, cell, percent, span

STEPS = ("step", "steps", "update", "iteration", "epoch")


@dataclass(frozen=True)
class TargetPart:
    """The whole experiment on one target.

    scene: holds the object that was matched. curves: policy -> chart of its training; rollouts: policy -> films of it.
    in_scenes: films of demonstrations inside generated scenes; not_in_scenes: scene -> why there is none.
    """

    target: str
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


def _demonstrations(ledgers: list[Path], target: str, confidence: float) -> Table | None:
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
    return Table(f"demonstrations-{target}", caption, columns, rows, headers=2) if rows else None


def _policy_name(folder: Path) -> str:
    """.../<policy>/<training set>/<run>/seed_<n> -> 'lite, trained on 4 cousins, seed 0'."""
    policy, training_set, run, seed = folder.parts[-4:]
    name = policy if run == policy else f"{policy} ({run})"
    return f"{name}, trained on {title(training_set)}, {title(seed)}"


def _folder_key(path: Path) -> Any:
    policy, training_set, run, seed = path.parent.parts[-4:]
    return policy, set_key(training_set), run, sort_key(seed)


def _curves(files: RunFiles, target: str) -> dict[str, Markup]:
    found = {}
    for path in sorted(files.find_all(f"training/{target}/*/*/*/*/metrics.jsonl"), key=_folder_key):
        step, series = losses(read_metrics(path))
        name = _policy_name(path.parent)
        if chart := line_chart(series, step, f"Loss of the policy {name}"):
            found[name] = chart
    return found


def _rollouts(files: RunFiles, target: str, album: Album) -> dict[str, list[FilmedAsset]]:
    archives = sorted(files.find_all(f"evaluation/policies/{target}/*/*/*/*/films.zip"), key=_folder_key)
    named = {_policy_name(path.parent): path for path in archives}
    films = {name: read_films(path, f"Rollout of the policy {name},", album) for name, path in named.items()}
    return {name: cells for name, cells in films.items() if cells}


def _list_not_in_scenes(path: Path | None) -> dict[str, str]:
    found = read_json(SceneDemonstrations, path).demonstrations if path else []
    return {title(f"rank_{one.rank}"): one.reason for one in found if one.status == "failed"}


def _pictures(assets: TaskAssets | None, used: set[str], album: Album, snapshots: Snapshots) -> list[Picture]:
    """The assets of the roles that were not drawn or are used."""
    kept = [(role, asset.asset) for role, asset in used_roles(assets, used).items()] if assets else []
    thumbnails = [
        album.thumbnail(snapshots.picture(asset), f"{role_title(role)}: {asset.replace('_', ' ')}")
        for role, asset in kept
    ]
    return [picture for picture in thumbnails if picture]


def _target(
    files: RunFiles, target: str, chosen: Path | None, album: Album, snapshots: Snapshots, confidence: float
) -> TargetPart:
    assets = read_json(TaskAssets, chosen) if chosen else None
    ledgers = sorted(
        files.find_all(f"demonstrations/{target}/*/attempts.jsonl"), key=lambda path: set_key(path.parent.name)
    )
    roles = {path.parent.name for path in ledgers}
    tables = [roles_table(assets, roles, f"roles-{target}", "Assets by role.")] if assets else []
    films = [
        film for path in ledgers
        for film in read_films(files.find_first(f"{target}/{path.parent.name}/films.zip"), "Demonstration", album)
    ]  # fmt: skip
    return TargetPart(
        target=target,
        title=target_title(target, assets.task if assets else target),
        scene=assets.scene if assets else "",
        source=f"{title(assets.object)} of {title(assets.scene)}" if assets else "",
        pictures=_pictures(assets, roles, album, snapshots),
        assets=tables + (lists_table(assets, f"lists-{target}", "Sets of assets.") if assets else []),
        demonstrations=_demonstrations(ledgers, target, confidence),
        films=films,
        curves=_curves(files, target),
        rollouts=_rollouts(files, target, album),
        in_scenes=read_films(files.find_first(f"{target}/in_scene/films.zip"), "Demonstration in the scene", album),
        not_in_scenes=_list_not_in_scenes(files.find_first(f"demonstrations/{target}/in_scene/in_scene.json")),
    )


def collect(files: RunFiles, album: Album, confidence: float) -> list[TargetPart]:
    """Every target of the run."""
    snapshots = Snapshots(files.find_all("assets/snapshots/shard_*.h5"))
    chosen = {path.parent.name: path for path in files.find_all("experiment/*/*/assets.json")}
    named = [
        *chosen,
        *files.names("demonstrations/*/*/attempts.jsonl", 1),
        *files.names("training/*/*/*/*/*/metrics.jsonl", 4),
        *files.names("evaluation/policies/*/*/*/*/*/films.zip", 4),
    ]
    return [_target(files, name, chosen.get(name), album, snapshots, confidence) for name in dict.fromkeys(named)]
