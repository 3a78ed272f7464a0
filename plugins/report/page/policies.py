"""The page's section about the policy experiment: assets, demonstrations, training, rollouts."""

from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from roomkin.plugins.films.kinds import Film, read_films
from roomkin.plugins.in_scene.kinds import SceneDemonstration, SceneDemonstrations
from roomkin.plugins.report.album import Album, Animation, PagePicture, SnapshotShards
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.result import Points, line_chart
from roomkin.plugins.report.roles import lists_table, role_title, roles_table, used_roles
from roomkin.stages.contracts.archives import unpack
from roomkin.stages.contracts.episode_store import read_attempts, read_metrics
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.policies import TaskAssets
from roomkin.stages.tables.intervals import wilson
from roomkin.stages.tables.rows import set_key, sort_key, target_title, title
from roomkin.stages.tables.text import NOTHING, TextTable, cell, percent, span

Films = dict[str, list[tuple[Film, Animation]]]  # by role: the first film is shown, the others on demand


class TargetPart(NamedTuple):
    """The whole experiment on one target.

    plan: its assets; pictures: of those in use. curves: policy -> chart of its training. rollouts: policy -> films of
    it. scene_films: of demonstrations inside generated scenes; in_scenes: what became of each.
    """

    target: str
    title: str
    plan: TaskAssets | None
    pictures: list[PagePicture]
    assets: list[TextTable]
    demonstrations: TextTable | None
    films: Films
    curves: dict[str, Markup]
    rollouts: dict[str, Films]
    scene_films: Films
    in_scenes: list[SceneDemonstration]

    @property
    def scene(self) -> str:
        """The scene of the object that was matched."""
        return self.plan.scene if self.plan else ""


def collect_films(archive: Path | None, whose: str, album: Album) -> Films:
    """The films of a films.zip, by role, in their order.

    Raises:
        InputError: the list of films is broken, or a film is missing.
    """
    films: Films = {}
    if archive is None:
        return films
    folder = unpack(archive, "make the films again")
    for film in read_films(folder / "films.json").films:
        moving = album.film(folder / film.file, f"{whose} on {title(film.role)}")
        films.setdefault(film.role, []).append((film, moving))
    return films


def losses(rows: list[dict[str, Any]]) -> dict[str, Points]:
    """Every loss (a key with 'loss' or 'nll' in it) as points (step, value) of a metrics file."""
    series: dict[str, Points] = {}
    for row in rows:
        for key, value in row.items():
            if isinstance(value, int | float) and ("loss" in key or "nll" in key):
                series.setdefault(key, []).append((float(row["step"]), float(value)))
    return series


def _demonstrations(ledgers: list[Path], target: str, confidence: float) -> TextTable | None:
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
    return TextTable(f"demonstrations-{target}", caption, columns, rows, headers=2) if rows else None


def _policy_name(folder: Path) -> str:
    """.../<policy>/<training set>/<run>/seed_<n> -> 'lite, trained on 4 cousins, seed 0'."""
    policy, training_set, run, seed = folder.parts[-4:]
    name = policy if run == policy else f"{policy} ({run})"
    return f"{name}, trained on {title(training_set)}, {title(seed)}"


def _folder_key(path: Path) -> Any:
    policy, training_set, run, seed = path.parent.parts[-4:]
    return policy, set_key(training_set), run, sort_key(seed)


def _by_policy(files: RunFiles, pattern: str) -> dict[str, Path]:
    """A policy's name -> the file in its folder."""
    return {_policy_name(path.parent): path for path in sorted(files.find_all(pattern), key=_folder_key)}


def _target(
    files: RunFiles, target: str, chosen: Path | None, album: Album, snapshots: SnapshotShards, confidence: float
) -> TargetPart:
    plan = read_json(TaskAssets, chosen) if chosen else None
    ledgers = files.find_all(f"demonstrations/{target}/*/attempts.jsonl")
    ledgers = sorted(ledgers, key=lambda path: set_key(path.parent.name))
    roles = {path.parent.name for path in ledgers}
    used = used_roles(plan, roles) if plan else {}
    thumbnails = [
        album.thumbnail(snapshots.picture(asset.asset), f"{role_title(role)}: {asset.asset.replace('_', ' ')}")
        for role, asset in used.items()
    ]

    def films(path: str, whose: str) -> Films:
        return collect_films(files.find_first(f"{path}/films.zip"), whose, album)

    curves = {
        name: line_chart(losses(read_metrics(path)), "step", f"Loss of the policy {name}")
        for name, path in _by_policy(files, f"training/{target}/*/*/*/*/metrics.jsonl").items()
    }
    rollouts = {
        name: collect_films(path, f"Rollout of the policy {name},", album)
        for name, path in _by_policy(files, f"evaluation/policies/{target}/*/*/*/*/films.zip").items()
    }
    in_scene = files.find_first(f"demonstrations/{target}/in_scene/in_scene.json")
    tables = [roles_table(plan, roles, f"roles-{target}", "Assets by role.")] if plan else []
    return TargetPart(
        target=target,
        title=target_title(target, plan.task if plan else target),
        plan=plan,
        pictures=[picture for picture in thumbnails if picture],
        assets=tables + (lists_table(plan, f"lists-{target}", "Sets of assets.") if plan else []),
        demonstrations=_demonstrations(ledgers, target, confidence),
        films={role: found for path in ledgers for role, found in films(str(path.parent), "Demonstration").items()},
        curves={name: chart for name, chart in curves.items() if chart},
        rollouts={name: found for name, found in rollouts.items() if found},
        scene_films=films(f"{target}/in_scene", "Demonstration in the scene"),
        in_scenes=read_json(SceneDemonstrations, in_scene).demonstrations if in_scene else [],
    )


def collect(files: RunFiles, album: Album, confidence: float) -> list[TargetPart]:
    """Every target of the run."""
    snapshots = SnapshotShards(files.find_all("assets/snapshots/shard_*.h5"))
    chosen = {path.parent.name: path for path in files.find_all("experiment/*/*/assets.json")}
    named = [
        *chosen,
        *files.names("demonstrations/*/*/attempts.jsonl", 1),
        *files.names("training/*/*/*/*/*/metrics.jsonl", 4),
        *files.names("evaluation/policies/*/*/*/*/*/films.zip", 4),
    ]
    return [_target(files, name, chosen.get(name), album, snapshots, confidence) for name in dict.fromkeys(named)]
