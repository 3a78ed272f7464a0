"""How many test assets a claim about policies needs, drawn from rollouts that exist: docs/results/how-many-assets.md.

    mkdir study && tar -xJf docs/results/registered/rollouts.tar.xz -C study
    python -m benchmarks.how_many_assets --rollouts study/evaluation/policies --figure docs/results/how_many_assets.svg

The effect is the success of policies trained on eight cousins minus that of the twin's, on unseen assets in the usual
condition. A small study is drawn from the large one: objects, of each so many assets (each with its four starts), and
training runs of either side, all with replacement. Prints the tables of the page.
"""

import argparse
import math
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import table
from stages.contracts.policies import Rollout
from stages.tables.drawing import plt, save, style
from stages.tables.rows import ONE_TEST, published_policies, read_rows, records
from stages.tables.statistics import mean, t_interval

ASSETS, OBJECTS, RUNS = (1, 3, 5, 10, 20, 40), (1, 2, 3), (1, 2, 5)
PAPERS, OURS, BASELINE = (1, 3, 100, 6), "cousins_8", "twin"  # objects, assets, starts, runs of the paper
ROLES = ("cousin_2", "cousin_6", "dissimilar")  # its unseen assets
DRAWS, SEED = 20_000, 0
Float = NDArray[np.float64]


def successes(folder: Path, task: str, training_set: str, run: str = "lite") -> Float:
    """Successes (objects, assets, starts, runs) on the unseen assets of a task."""
    files = sorted(folder.glob(f"{task}_room_?/{run}/{training_set}/{run}/seed_*/rollouts.csv"))
    rows = read_rows(Rollout, files, ONE_TEST)
    rows = rows[rows["test_asset"] == "test"]
    keys = ["target", "asset", "initial_state", "seed"]
    shape = [rows["target"].nunique(), -1, rows.groupby(["target", "asset"])["initial_state"].nunique().max()]
    return rows.sort_values(keys)["success"].to_numpy(float).reshape(*shape, rows["seed"].nunique())


def draw_weights(random: np.random.Generator, among: int, count: int, draws: tuple[int, ...]) -> Float:
    """Weights (*draws, among) of `count` that are drawn with replacement."""
    return random.multinomial(count, np.full(among, 1 / among), draws) / count


def draw_effects(ours: Float, theirs: Float, objects: int, assets: int, runs: int) -> Float:
    """Effects (DRAWS,) that studies of so many objects, assets of each and training runs read."""
    random = np.random.default_rng(SEED)
    places = random.integers(len(ours), size=(DRAWS, objects))
    of_assets = draw_weights(random, ours.shape[1], assets, places.shape)
    means = []
    for rates in (ours, theirs):
        of_runs = draw_weights(random, rates.shape[3], runs, places.shape)
        means.append(np.einsum("doa,doar,dor->d", of_assets, rates.mean(2)[places], of_runs))
    return (means[0] - means[1]) / objects


def variances(effects: Float) -> dict[str, float]:
    """Variance of the effect by source, of one object, asset, start, run, from effects (objects, assets, starts, runs).

    Expected mean squares; starts lie within assets, assets and runs cross within objects (each has policies of its
    own). `asset x run` is how assets differ from run to run; `rollout` is what is left of one.
    """
    objects, assets, starts, runs = effects.shape
    whole = effects.mean((1, 2, 3), keepdims=True)
    of_asset, of_run = effects.mean((2, 3), keepdims=True), effects.mean((1, 2), keepdims=True)
    of_start, of_both = effects.mean(3, keepdims=True), effects.mean(2, keepdims=True)
    between_starts = of_start - of_asset
    crossed = of_both - of_asset - of_run + whole
    left = effects - of_start - of_both + of_asset

    def square(parts: Float, times: int, freedom: int) -> float:
        return float(times * (parts**2).sum() / (objects * freedom))

    rollout = square(left, 1, assets * (starts - 1) * (runs - 1))
    both = square(crossed, starts, (assets - 1) * (runs - 1))
    start = square(between_starts, runs, assets * (starts - 1))
    asset = square(of_asset - whole, starts * runs, assets - 1)
    run = square(of_run - whole, assets * starts, runs - 1)
    found = {
        "asset": (asset - start - both + rollout) / (starts * runs),
        "run": (run - both) / (assets * starts),
        "asset x run": (both - rollout) / starts,
        "start": (start - rollout) / runs,
        "rollout": rollout,
    }
    within = errors(found, 1, assets, starts, runs)
    return {"object": float(whole.var(ddof=1)) - sum(part**2 for part in within.values())} | found


def errors(found: dict[str, float], objects: int, assets: int, starts: int, runs: int) -> dict[str, float]:
    """Standard error of the effect by source in a study of so many objects, assets of each, starts of those, runs."""
    times = {
        "object": objects, "asset": objects * assets, "run": objects * runs, "asset x run": objects * assets * runs,
        "start": objects * assets * starts, "rollout": objects * assets * starts * runs,
    }  # fmt: skip
    return {name: (max(0.0, part) / times[name]) ** 0.5 for name, part in found.items()}


def points(value: float) -> str:
    """A difference of rates in points: '+13', '0'."""
    return f"{round(100 * value):+d}".replace("+0", "0")


def summarise_effects(effects: Float) -> str:
    """The range of 95 % of what is read, and how often that is zero or of the wrong sign."""
    low, high = np.quantile(effects, [0.025, 0.975])
    return f"{points(low)} to {points(high)}, {100 * (effects <= 0).mean():.0f} %"


def papers_table(published: Path) -> list[list[str]]:
    """The paper's Table 3: training sets minus the twin on its three unseen assets; t interval over these."""
    rows = records(published_policies(published))
    cells = {(row["task"], row["test_asset"], row["training_set"]): row["mean"] for row in rows}
    lines = []
    for task, name in dict.fromkeys((task, name) for task, _, name in cells if name != BASELINE):
        gains = [cells[task, role, name] - cells[task, role, BASELINE] for role in ROLES if (task, role, name) in cells]
        low, high = t_interval(gains, 0.95)
        interval = f"[{math.floor(100 * low)}, {math.ceil(100 * high)}]"
        lines.append([task, name, *map(points, gains), f"{points(mean(gains))} {interval}"])
    return lines


def draw(effects: dict[tuple[str, int, int], Float], means: dict[str, float], path: Path) -> None:
    """The range of what is read against the number of assets, a panel per task, a line per number of objects."""
    with style():
        figure, panels = plt.subplots(1, len(means), figsize=(7.2, 2.9), sharey=True, layout="constrained")
        for axes, (task, effect) in zip(panels, means.items(), strict=True):
            for place, objects in enumerate(OBJECTS):
                at = np.arange(len(ASSETS)) + 0.22 * (place - 1)
                low, high = (
                    100 * np.array([np.quantile(effects[task, objects, assets], [0.025, 0.975]) for assets in ASSETS]).T
                )
                colour = ("#D55E00", "#0072B2", "#009E73")[place]
                label = f"{objects} object{'s' * (objects > 1)}"
                axes.vlines(at, low, high, color=colour, linewidth=3, label=label)
            axes.axhline(0, color="#22252a", linewidth=0.8)
            axes.axhline(100 * effect, color="#6a6d70", linewidth=0.8, linestyle="--")
            axes.set_xticks(range(len(ASSETS)), [str(assets) for assets in ASSETS])
            axes.set_title(f"{task.capitalize()}s: {points(effect)} points over all")
            axes.set_xlabel("test assets of each object")
        panels[0].set_ylabel("effect that is read (points)")
        panels[0].legend(loc="lower right")
        save(figure, path.parent, path.stem, ("svg",))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rollouts", type=Path, required=True)
    parser.add_argument("--published", type=Path, default=Path("report/published"))
    parser.add_argument("--figure", type=Path)
    flags = parser.parse_args()
    means, effects, sources = {}, {}, {}
    for task in ("door", "drawer"):
        ours, theirs = (successes(flags.rollouts, task, name) for name in (OURS, BASELINE))
        means[task], sources[task] = float((ours - theirs).mean()), variances(ours - theirs)
        runs = ours.shape[3]
        for objects, assets in product(OBJECTS, ASSETS):
            effects[task, objects, assets] = draw_effects(ours, theirs, objects, assets, runs)
        print(f"\n{task}: {ours.shape} objects, assets, starts, runs; effect {points(means[task])}")
        by_object = (ours - theirs).mean((1, 2, 3))
        print("by object", *map(points, by_object))
        lines = [[n, *(summarise_effects(effects[task, objects, n]) for objects in OBJECTS)] for n in ASSETS]
        table(["assets", *(f"{objects} objects" for objects in OBJECTS)], lines)
        table(
            ["assets, one object", *(f"{count} runs" for count in RUNS)],
            [[n, *(summarise_effects(draw_effects(ours, theirs, 1, n, count)) for count in RUNS)] for n in (3, 10, 40)],
        )
    designs = {"paper's": PAPERS, "3 x 40": (3, 40, 4, 5), "16 x 40": (16, 40, 1, 2)}
    for task, found in sources.items():
        parts = {name: errors(found, *design) for name, design in designs.items()}
        lines = [
            [name, f"{100 * max(0.0, part) ** 0.5:.0f}", *(f"{100 * part_of[name]:.1f}" for part_of in parts.values())]
            for name, part in found.items()
        ]
        total = [f"{100 * sum(part**2 for part in part_of.values()) ** 0.5:.1f}" for part_of in parts.values()]
        table([f"{task}: source", "deviation of one", *designs], [*lines, ["all", "", *total]])
    table(["task", "training set", *ROLES, "mean"], papers_table(flags.published))
    if flags.figure:
        draw(effects, means, flags.figure)


if __name__ == "__main__":
    main()
