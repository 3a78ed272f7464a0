"""Does the distance to what training shows forecast success? Fits `plugins.studies.coverage.CURVES` anew, in seconds:

    mkdir study && tar -xJf docs/results/registered/rollouts.tar.xz -C study
    python -m benchmarks.forecast --results study --assets config/study/assets/registered

Printed are, by task: the curve; the share of the variance between pairs of asset and training set that it accounts for,
fitted on all, with each family or each room left out; measured success by distance; each training set of each room,
measured and forecast with that room left out; the sets of Table 3, another study. Training sets that no curve is fitted
on are forecast, too.
"""

import argparse
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.tables import table
from plugins.report.roles import list_demonstrated_assets
from plugins.studies.coverage import CURVES, Curve, forecast_mean, measure_nearest
from stages.config.experiment import ExperimentConfig
from stages.contracts import TaskAssets, read_json
from stages.contracts.policies import TaskAsset
from stages.tables.order import SKILL

FITTED = ("twin", "twin_randomised", "cousins_8")
EDGES = (0, 0.5, 1.5, 2, 3, np.inf)
Numbers = NDArray[np.float64]


def read_pairs(results: Path, assets: Path, task: str) -> pd.DataFrame:
    """A row per room, training set and unseen asset: family, distance to the nearest training asset, success.

    Seeds that learned from the same assets are pooled; where every seed has a draw of its own, each has a row.
    """
    runs = []
    for file in sorted(assets.glob(f"{task}_room_*.json")):
        plan, room = read_json(TaskAssets, file), file.stem
        for path in sorted((results / "evaluation/policies" / room / "lite").glob("*/lite/seed_*/rollouts.csv")):
            rows = pd.read_csv(path, usecols=["training_set", "seed", "test_asset", "asset", "family", "success"])
            rows = rows[rows.test_asset == "test"].assign(room=room)
            shown = assets_shown(plan, rows.training_set.iat[0], rows.seed.iat[0])
            away = zip(plan.test_assets, measure_nearest(plan.test_assets, shown), strict=True)
            runs.append(rows.assign(distance=rows.asset.map({asset.asset: far for asset, far in away})))
    key = ["room", "training_set", "family", "asset", "distance"]
    return pd.concat(runs).groupby(key, sort=False).success.mean().reset_index()


def assets_shown(plan: TaskAssets, training_set: str, seed: int) -> list[TaskAsset]:
    """The assets that the policies of a training set and seed learn from."""
    experiment = ExperimentConfig(held_out=plan.held_out, draws=plan.draws)
    return list_demonstrated_assets(plan, experiment.roles(training_set, seed))


def fit_curve(distances: Numbers, shares: Numbers) -> Curve:
    """The logistic curve of the greatest likelihood, by Newton's method."""
    points, weights = np.stack([np.ones_like(distances), -distances], axis=1), np.zeros(2)
    for _ in range(20):
        expected = Curve(*weights).predict(distances)
        bends = points.T @ (points * (expected * (1 - expected))[:, None])
        weights += np.linalg.solve(bends, points.T @ (shares - expected))
    return Curve(*np.round(weights, 4).tolist())


def predict_left_out(pairs: pd.DataFrame, groups: Iterable[str]) -> Numbers:
    """Expected success of every pair, by a curve that is fitted on the pairs of other groups."""
    groups, expected = np.asarray(list(groups)), np.empty(len(pairs))
    for group in np.unique(groups):
        rest = pairs[(groups != group) & pairs.training_set.isin(FITTED)]
        curve = fit_curve(rest.distance.to_numpy(), rest.success.to_numpy())
        expected[groups == group] = curve.predict(pairs.distance[groups == group])
    return expected


def measure_r_squared(shares: Numbers, expected: Numbers) -> float:
    """The share of the variance that is accounted for; below 0: the mean would do better."""
    return float(1 - np.sum((shares - expected) ** 2) / np.sum((shares - shares.mean()) ** 2))


def percent(share: float) -> str:
    """As a whole number."""
    return f"{100 * share:.0f} %"


def report(task: str, pairs: pd.DataFrame) -> None:
    """Print the tables of a task."""
    fitted = pairs[pairs.training_set.isin(FITTED)]
    curve = fit_curve(fitted.distance.to_numpy(), fitted.success.to_numpy())
    print(f"\n## {task}: {curve}, {len(fitted)} pairs, {fitted.family.nunique()} families")
    shares = fitted.success.to_numpy()
    ways: dict[str, Callable[[], Numbers]] = {
        "none": lambda: curve.predict(fitted.distance),
        "families": lambda: predict_left_out(fitted, fitted.family),
        "rooms": lambda: predict_left_out(fitted, fitted.room),
    }
    table(
        ["left out", "variance accounted for"],
        ([name, percent(measure_r_squared(shares, way()))] for name, way in ways.items()),
    )
    cuts = pd.cut(fitted.distance, EDGES, right=False)
    table(
        ["distance", "pairs", "measured", "curve"],
        (
            [cut, len(part), percent(part.success.mean()), percent(curve.predict(part.distance).mean())]
            for cut, part in fitted.groupby(cuts, observed=True)
        ),
    )
    sets = of_sets(pairs)
    table(
        ["room", "training set", "measured", "forecast without that room"],
        ([*key, *map(percent, shares)] for key, shares in zip(sets.index, sets.to_numpy(), strict=True)),
    )
    print(f"\nroot mean square error: {percent(error(sets))}")
    table(["Table 3", "measured", "forecast"], read_table3_sets(task))


def of_sets(pairs: pd.DataFrame) -> pd.DataFrame:
    """Mean success of each room and training set, measured and expected by a curve that is fitted on other rooms."""
    expected = pairs.assign(expected=predict_left_out(pairs, pairs.room))
    return expected.groupby(["room", "training_set"])[["success", "expected"]].mean()


def error(sets: pd.DataFrame) -> float:
    """Root mean square error of `of_sets`, over the training sets that curves are fitted on."""
    fitted = sets[sets.index.isin(FITTED, level="training_set")]
    return float(np.sqrt(np.mean((fitted.success - fitted.expected) ** 2)))


def read_table3_sets(task: str) -> Iterator[list[str]]:
    """The training sets of Table 3, a study of another library and another twin: success measured and forecast."""
    plan = read_json(TaskAssets, Path(f"config/study/assets/{task}.json"))
    rows = pd.read_csv("docs/results/assets.csv")
    for row in rows[(rows.task == task) & (rows.training_set != SKILL)].itertuples():
        shown = assets_shown(plan, str(row.training_set), 0)
        yield [str(row.training_set), percent(row.mean), percent(forecast_mean(task, plan.test_assets, shown))]


def main() -> None:
    """Read the archive and print the tables of each task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, required=True, help="where the archive is unpacked")
    parser.add_argument("--assets", type=Path, default=Path("config/study/assets/registered"))
    given = parser.parse_args()
    for task in CURVES:
        report(task, read_pairs(given.results, given.assets, task))


if __name__ == "__main__":
    main()
