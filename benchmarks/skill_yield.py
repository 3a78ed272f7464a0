"""How often the Open skill succeeds over a whole library, and where it fails: `python -m benchmarks.skill_yield`.

Every asset with a joint for the task is tried with a few seeds, each at its own size, without a camera; flaps as well,
which an experiment does not choose. attempts.csv has a line per attempt and grows: the same command goes on where it
was stopped. summary.md counts by handle, hinge and category; films/ shows failures.
"""

import argparse
import csv
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from plugins.films.demonstrations import film_demonstrations
from stages.articulated.asset_folder import read_asset
from stages.config.demonstrations import DemonstrationsConfig
from stages.contracts.library_folder import AssetFolders
from stages.contracts.task_options import TaskConfig
from stages.demonstrations.attempt import Recorder
from stages.plugins import load
from stages.tasks.api import Size, TaskEnv

FIELDS = ("asset", "category", "joint", "handle", "hinge", "seed", "success", "cause", "retries", "steps", "opened")


def seeds(asset: str, count: int) -> list[int]:
    """Initial states of an asset, others than those of any other."""
    return np.random.default_rng((900, *asset.encode())).integers(0, 2**31, count).tolist()


def joints(folder: Path, task: str, every: bool) -> list[str]:
    """The joint that the task chooses; or every one with a handle."""
    if every:
        return [
            joint.name
            for joint in read_asset(folder).joints
            if joint.part_type == load("tasks", task).part_type and joint.handle
        ]
    chosen = load("tasks", task).target_joint(folder, flaps=True)
    return [] if chosen is None else [chosen.joint]


def attempts(
    folder: Path, task: str, joint: str, size: Size | None, states: list[int], options: DemonstrationsConfig
) -> Iterator[Any]:
    """A line of the ledger per seed."""
    asset = read_asset(folder)
    world = TaskEnv(task, folder, joint, size, TaskConfig(), render=False)
    opened = next(item for item in asset.joints if item.name == joint)
    recorder = Recorder(world, options)
    for seed in states:
        episode, outcome = recorder.attempt(seed)
        yield {
            "asset": asset.id,
            "category": asset.category,
            "joint": joint,
            "handle": opened.handle,
            "hinge": opened.panel.hinge if opened.panel else "",
            "seed": seed,
            "success": int(outcome.success),
            "cause": outcome.cause,
            "retries": outcome.retries,
            "steps": len(episode.actions),
            "opened": round(world.opened, 3),
        }
    world.close()


def summary(rows: list[dict[str, str]]) -> str:
    """Yield and causes as markdown tables, the worst assets last."""
    lines = [f"{sum(int(row['success']) for row in rows)} of {len(rows)} attempts succeeded.", ""]
    for key in ("handle", "hinge", "category", "asset"):
        groups: dict[str, list[dict[str, str]]] = defaultdict(list)
        for row in rows:
            groups[row[key]].append(row)
        lines += [f"| {key} | assets | successes | attempts | yield | causes |", "|---|---|---|---|---|---|"]
        for name, group in sorted(groups.items()):
            good = sum(int(row["success"]) for row in group)
            if key == "asset" and good > 0.7 * len(group):
                continue
            causes = Counter(row["cause"] for row in group if row["success"] == "0")
            failures = ", ".join(f"{cause} {count}" for cause, count in causes.most_common())
            assets = len({row["asset"] for row in group})
            lines.append(f"| {name} | {assets} | {good} | {len(group)} | {good / len(group):.0%} | {failures} |")
        lines.append("")
    return "\n".join(lines)


def film(
    folder: Path, task: str, row: dict[str, str], size: Size | None, options: DemonstrationsConfig, out: Path
) -> None:
    """Films of one failed attempt, as it was."""
    world = TaskEnv(task, folder, row["joint"], size, TaskConfig(), render=True)
    recorder = Recorder(world, options, film=True, failures=True)
    recorder.attempt(int(row["seed"]))
    film_demonstrations(out, recorder.filmed, "twin", world.options.control_frequency)
    world.close()


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--library", type=Path, default=Path("results/assets/library/library.json"))
    parser.add_argument("--task", default="door")
    parser.add_argument("--attempts", type=int, default=3, help="seeds per asset")
    parser.add_argument("--recovery", type=float, default=0.0, help="as demonstrations.recovery")
    parser.add_argument("--every", action="store_true", help="all doors (drawers) with a handle, not one per asset")
    parser.add_argument("--only", default="", help="part of an asset's name")
    parser.add_argument(
        "--size", type=float, nargs=3, help="the box of all of them, metres, as in an experiment; its own"
    )
    parser.add_argument("--films", type=int, default=0, help="failures to film")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    options = DemonstrationsConfig(recovery=given.recovery)
    size = tuple(given.size) if given.size else None
    given.out.mkdir(parents=True, exist_ok=True)
    ledger = given.out / "attempts.csv"
    rows = list(csv.DictReader(ledger.open())) if ledger.exists() else []
    seen = {(row["asset"], row["joint"], int(row["seed"])) for row in rows}
    models = AssetFolders(given.library)
    with ledger.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if file.tell() == 0:
            writer.writeheader()
        for asset in models:
            if not models.asset(asset).joints or given.only not in asset:
                continue
            folder = models[asset]
            for joint in joints(folder, given.task, given.every):
                states = [seed for seed in seeds(asset, given.attempts) if (asset, joint, seed) not in seen]
                for row in attempts(folder, given.task, joint, size, states, options) if states else ():
                    writer.writerow(row)
                    file.flush()
    rows = list(csv.DictReader(ledger.open()))
    (given.out / "summary.md").write_text(summary(rows))
    print(summary(rows))
    failed = [row for row in rows if row["success"] == "0" and int(row["steps"])]
    for row in failed[: given.films]:
        out = given.out / "films" / f"{row['asset']}-{row['seed']}-{row['cause']}"
        film(models[row["asset"]], given.task, row, size, options, out)


if __name__ == "__main__":
    main()
