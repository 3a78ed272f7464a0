"""What the page says of the policy experiment: assets, demonstrations, training, rollouts."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from stages.contracts.files import read_json
from stages.contracts.in_scene import SceneDemonstrations
from stages.contracts.ledgers import read_attempts, read_metrics
from stages.contracts.policies import TaskAsset, TaskAssets
from stages.contracts.snapshot_pictures import Snapshots
from stages.tables.markup import Table
from stages.tables.order import natural, role_title, set_key, task_key, title
from stages.tables.page.charts import Points, line_chart
from stages.tables.page.files import RunFiles
from stages.tables.page.films import FilmedAsset, read_films
from stages.tables.page.pictures import Album, Picture
from stages.tables.roles import by_role, kind_of, known_kinds, lists_table

STEPS = ("step", "steps", "update", "iteration", "epoch")
SIZE = 132  # pixels of an asset's picture


@dataclass(frozen=True)
class Demonstrations:
    """The attempts on one asset; `causes` counts the failures, most frequent first."""

    role: str
    attempts: int
    successes: int
    causes: list[tuple[str, int]]
    films: list[FilmedAsset]


@dataclass(frozen=True)
class Line:
    """An asset of the experiment (None: not in its list) and its demonstrations (None: not collected).

    known: whether some demonstrated asset has such a handle.
    """

    role: str
    asset: TaskAsset | None
    picture: Picture | None
    demonstrations: Demonstrations | None
    known: bool


@dataclass(frozen=True)
class Curve:
    """Training of one policy."""

    name: str
    chart: Markup


@dataclass(frozen=True)
class Rollouts:
    """Filmed rollouts of one policy, a cell per test asset."""

    name: str
    cells: list[FilmedAsset]


@dataclass(frozen=True)
class InScenes:
    """Demonstrations inside generated scenes: films, and why there are none of the other ranks."""

    cells: list[FilmedAsset]
    reasons: list[tuple[str, str]]


@dataclass(frozen=True)
class TaskPart:
    """The whole experiment on one task; `scene` holds the object that was matched."""

    task: str
    title: str
    scene: str
    source: str
    lines: list[Line]
    lists: list[Table]
    curves: list[Curve]
    rollouts: list[Rollouts]
    in_scenes: InScenes | None

    @property
    def demonstrations(self) -> list[Demonstrations]:
        """Those that were collected."""
        return [line.demonstrations for line in self.lines if line.demonstrations]

    @property
    def missing(self) -> list[str]:
        """Assets on which nothing was collected: test assets and cousins further away."""
        return [role_title(line.role) for line in self.lines if not line.demonstrations]


def losses(rows: list[dict[str, Any]]) -> tuple[str, dict[str, Points]]:
    """The step's name and every loss (a key with 'loss' or 'nll' in it) as points of a metrics file."""
    step = next((name for name in STEPS if any(name in row for row in rows)), "line")
    series: dict[str, Points] = {}
    for index, row in enumerate(rows):
        for key, value in row.items():
            if isinstance(value, int | float) and ("loss" in key or "nll" in key):
                series.setdefault(key, []).append((float(row.get(step, index)), float(value)))
    return step, series


def _demonstrations(ledger: Path, films: Path | None, album: Album) -> Demonstrations:
    attempts = read_attempts(ledger)
    failed = Counter(attempt.cause for attempt in attempts if not attempt.success)
    causes = sorted(failed.items(), key=lambda item: (-item[1], item[0]))
    role = ledger.parent.name
    return Demonstrations(
        role, len(attempts), len(attempts) - sum(failed.values()), causes, read_films(films, "Demonstration", album)
    )


def _policy_name(folder: Path) -> str:
    """.../<training set>/<run>/seed_<n> -> 'trained on 4 cousins, lite, seed 0'."""
    return f"trained on {title(folder.parents[1].name)}, {folder.parent.name}, {title(folder.name)}"


def _folder_key(path: Path) -> Any:
    folder = path.parent
    return set_key(folder.parents[1].name), folder.parent.name, natural(folder.name)


def _curves(files: RunFiles, task: str) -> list[Curve]:
    curves = []
    for path in sorted(files.all(f"training/{task}/*/*/*/metrics.jsonl"), key=_folder_key):
        step, series = losses(read_metrics(path))
        name = _policy_name(path.parent)
        curves.append(Curve(name, line_chart(series, step, f"Loss of the policy {name}")))
    return [curve for curve in curves if curve.chart]


def _rollouts(files: RunFiles, task: str, album: Album) -> list[Rollouts]:
    made = []
    for folder in sorted(files.all(f"evaluation/policies/{task}/*/*/*/films.zip"), key=_folder_key):
        name = _policy_name(folder.parent)
        made.append(Rollouts(name, read_films(folder, f"Rollout of the policy {name},", album)))
    return [item for item in made if item.cells]


def _in_scenes(files: RunFiles, task: str, album: Album) -> InScenes | None:
    path = files.one(f"demonstrations/{task}/in_scene/in_scene.json")
    if path is None:
        return None
    found = read_json(SceneDemonstrations, path).demonstrations
    films = read_films(files.one(f"{task}/in_scene/films.zip"), "Demonstration in the scene", album)
    return InScenes(films, [(title(f"rank_{one.rank}"), one.reason) for one in found if one.status == "failed"])


def _task(files: RunFiles, task: str, chosen: Path | None, album: Album, snapshots: Snapshots) -> TaskPart:
    assets = read_json(TaskAssets, chosen) if chosen else None
    known = by_role(assets) if assets else {}
    done = {
        path.parent.name: _demonstrations(path, files.one(f"{task}/{path.parent.name}/films.zip"), album)
        for path in files.all(f"demonstrations/{task}/*/attempts.jsonl")
    }

    def picture(role: str) -> Picture | None:
        view = snapshots.picture(known[role].asset) if role in known else None
        return album.put(view, f"{known[role].asset}, {role_title(role)}", SIZE) if view else None

    handles = known_kinds(assets, done) if assets else set()

    def line(role: str) -> Line:
        asset = known.get(role)
        return Line(role, asset, picture(role), done.get(role), asset is not None and kind_of(asset) in handles)

    named = [role for role in known if role in done or not role.startswith("random_")]
    roles = [*named, *sorted(set(done) - set(named), key=set_key)]
    return TaskPart(
        task=task,
        title=title(task),
        scene=assets.scene if assets else "",
        source=f"{title(assets.object)} of {title(assets.scene)}" if assets else "",
        lines=[line(role) for role in roles],
        lists=lists_table(assets, f"lists-{task}", "Sets of assets.") if assets else [],
        curves=_curves(files, task),
        rollouts=_rollouts(files, task, album),
        in_scenes=_in_scenes(files, task, album),
    )


def collect(files: RunFiles, album: Album) -> list[TaskPart]:
    """Every task of the run, in the paper's order."""
    snapshots = Snapshots(files.all("assets/snapshots/shard_*.h5"))
    chosen = {path.parent.name: path for path in files.all("experiment/*/*/assets.json")}
    tasks = {
        *chosen,
        *files.names("demonstrations/*/*/attempts.jsonl", 1),
        *files.names("training/*/*/*/*/metrics.jsonl", 3),
        *files.names("evaluation/policies/*/*/*/*/films.zip", 3),
    }
    return [_task(files, task, chosen.get(task), album, snapshots) for task in sorted(tasks, key=task_key)]
