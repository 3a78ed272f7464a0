"""Where a policy's hand first closes, seen from the handle: why rollouts fail. Two commands:

    python -m benchmarks.closings roll --policies results/training/drawer/*/lite/seed_0 --roles dissimilar \\
        --assets results/experiment/b/drawer/assets.json --library results/assets/library/library.json --out drawer.csv
    python -m benchmarks.closings draw drawer.csv door.csv --out closings.png

`roll` repeats rollouts of the workflow (same states, same outcome) without films; `--roles test` or `validation`: those
on the unseen assets of that split. Its table has a line per episode:
where the hand was, relative to the handle, when the gripper was first commanded to close; where there is a bowl to be
picked up, relative to its middle, when a close was first commanded near it. `draw` has a panel per test asset
and training set: the front as the robot sees it, handle or bowl as a grey bar, a point per episode.
"""

import argparse
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle

from stages.config.evaluation import EvaluationConfig, SkillOptions
from stages.contracts.policies import TaskAsset, TaskAssets
from stages.evaluation.arena import PolicyArena
from stages.evaluation.states import Start, initial_states, list_unseen_starts, share_states
from stages.geometry.frames import apply, inverse
from stages.tasks.api import TaskEnv

if TYPE_CHECKING:
    from plugins.bowl.movable import Movable

BESIDE = 0.12  # metres: a hand this near to the middle of a bowl closes on it
COLOURS = {True: "#2a7fb8", False: "#d1495b"}


class Watched:
    """A task that notes where the hand is when it is first commanded to close, by asset and initial state."""

    def __init__(self, task: TaskEnv, notes: dict[tuple[str, int], dict[str, Any]]) -> None:
        self.task, self.notes = task, notes

    def __getattr__(self, name: str) -> Any:
        return getattr(self.task, name)

    def reset(self, seed: int) -> Any:
        self.key = (self.task.asset, seed)
        return self.task.reset(seed)

    def step(self, action: Any) -> Any:
        if action[6] < 0 and self.key not in self.notes:
            movable = getattr(self.task.env, "movable", None)  # of tasks with something to carry
            found = self.measure_hand_offset(movable()) if movable else self.measure_grasp()
            if found:
                self.notes[self.key] = found
        return self.task.step(action)

    def measure_hand_offset(self, item: "Movable") -> dict[str, Any]:
        """The hand's place from the middle of what is to be picked up (robot base frame); {} if far from it."""
        corners = apply(item.base_from_object, item.mesh.vertices)
        low, high = corners.min(axis=0), corners.max(axis=0)
        across, sideways, up = self.task.hand()[:3, 3] - (low + high) / 2
        if np.hypot(across, sideways) > BESIDE or item.there:
            return {}
        wide, height = (high - low)[1:]
        return {"step": self.task.steps, "out": -across, "sideways": sideways, "up": up, "wide": wide, "high": height}

    def measure_grasp(self) -> dict[str, Any]:
        """The hand's place relative to the handle's centre (metres: out of the front, sideways, up), and the handle."""
        env = self.task.env
        target, handle = env.target, env.target.handle
        value = target.lower + self.task.opened * (target.upper - target.lower)
        asset_from_hand = inverse(env.base_from_asset()) @ self.task.hand()
        hand = inverse(target.motions(np.array([value]))[0]) @ asset_from_hand
        out, sideways, up = hand[:3, 3] - handle.position
        across = abs(handle.axis[1]) > 0.5
        wide, high = (handle.length, handle.width) if across else (handle.width, handle.length)
        return {"step": self.task.steps, "out": out, "sideways": sideways, "up": up, "wide": wide, "high": high}


class WatchingArena(PolicyArena):
    """Its tasks are watched."""

    @cached_property
    def notes(self) -> dict[tuple[str, int], dict[str, Any]]:
        return {}

    def task(self, asset: TaskAsset) -> TaskEnv:
        return Watched(super().task(asset), self.notes)  # type: ignore[return-value]


def roll(given: argparse.Namespace) -> None:
    """Roll the policies out and write a line per episode."""
    rows = []
    for folder in given.policies:
        with WatchingArena(folder, given.assets, given.library, EvaluationConfig(), "cpu") as arena:
            network = arena.network(given.checkpoint)
            for role in given.roles:
                for episode in arena.episodes(network, list_episodes(arena.plan, role, given)):
                    asset, found = episode.asset, arena.notes.get((episode.asset.asset, episode.seed), {})
                    about = {"task": arena.plan.task, "training_set": folder.parts[-3]}
                    about |= {"policy": "/".join(folder.parts[-2:]), "role": role, "asset": asset.asset}
                    about |= {"handle": asset.handle, "state": episode.seed, "success": episode.success}
                    rows.append(about | {key: round(float(value), 4) for key, value in found.items()})
        table = pd.DataFrame(rows)
        table.to_csv(given.out, index=False)
        print(
            folder,
            table[table.policy == "/".join(folder.parts[-2:])]
            .groupby(["training_set", "role"])
            .success.sum()
            .to_dict(),
        )


def list_episodes(plan: TaskAssets, role: str, given: argparse.Namespace) -> list[Start]:
    """The episodes of `evaluation rollout` for a role or split."""
    if role in ("test", "validation"):
        settings = SkillOptions(split=role, assets=given.unseen, asset_rollouts=given.unseen_rollouts)
        return list_unseen_starts(plan, settings, given.seed)
    return share_states(plan.assets_of(role, given.assets), initial_states("roles", given.seed, given.rollouts))


def draw(given: argparse.Namespace) -> None:
    """A panel per test asset (rows) and training set (columns)."""
    table = pd.concat([pd.read_csv(path) for path in given.tables])
    shown = list(table.groupby(["task", "role"], sort=False))
    sets = list(table.training_set.unique())
    figure, panels = plt.subplots(
        len(shown), len(sets), figsize=(4.2 * len(sets), 2.6 * len(shown)), squeeze=False, layout="constrained"
    )
    for row, ((task, role), cell) in zip(panels, shown, strict=True):
        reach = np.maximum(100 * cell[["sideways", "up"]].abs().max().to_numpy(), 3) + 1
        for panel, name in zip(row, sets, strict=True):
            part = cell[cell.training_set == name]
            for wide, high in part[["wide", "high"]].dropna().drop_duplicates().to_numpy() * 100:
                panel.add_patch(Rectangle((-wide / 2, -high / 2), wide, high, color="0.78", zorder=0))
            for success in (True, False):
                some = part[part.success == success]
                label = f"{'succeeded' if success else 'failed'}: {len(some)}"
                panel.scatter(100 * some.sideways, 100 * some.up, s=9, alpha=0.6, color=COLOURS[success], label=label)
            panel.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), aspect="equal")
            panel.set_title(f"{task}, {role}: {name}", fontsize=9)
            panel.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=7, frameon=False)
            panel.tick_params(labelsize=7)
        row[0].set_ylabel("up, cm", fontsize=8)
    for panel in panels[-1]:
        panel.set_xlabel("sideways, cm", fontsize=8)
    figure.savefig(given.out, dpi=100)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    rolling = commands.add_parser("roll")
    rolling.add_argument("--policies", type=Path, nargs="+", required=True, help="folders of trained policies")
    rolling.add_argument("--assets", type=Path, required=True, help="assets.json of the experiment")
    rolling.add_argument("--library", type=Path, required=True, help="library.json")
    rolling.add_argument(
        "--roles",
        nargs="+",
        default=["dissimilar"],
        help="test assets; all: those of all_assets in turn; test, validation: the unseen assets of that split",
    )
    rolling.add_argument("--rollouts", type=int, default=50, help="episodes per policy and role")
    rolling.add_argument("--unseen", type=int, default=24, help="assets of a split (evaluation.assets)")
    rolling.add_argument("--unseen-rollouts", type=int, default=2, help="episodes on each (asset_rollouts)")
    rolling.add_argument("--checkpoint", default="last", help="best, last, or a name in config.json")
    rolling.add_argument("--seed", type=int, default=0, help="of the initial states")
    rolling.add_argument("--out", type=Path, required=True, help="table to write")
    rolling.set_defaults(run=roll)
    drawing = commands.add_parser("draw")
    drawing.add_argument("tables", type=Path, nargs="+", help="tables that `roll` wrote")
    drawing.add_argument("--out", type=Path, required=True, help="picture to write")
    drawing.set_defaults(run=draw)
    given = parser.parse_args()
    given.run(given)


if __name__ == "__main__":
    main()
