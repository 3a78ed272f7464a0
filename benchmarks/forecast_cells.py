"""What the forecast expects of every policy of a study, before any of them is rolled out, in seconds:

    python -m benchmarks.forecast_cells --configs config.yaml config/study/second.yaml --out forecast.csv

Written is a row per policy: the mean distance of its unseen assets to the nearest that its training shows, and the mean
of the success to be expected of them (`plugins.studies.coverage`). Printed are the means by task and training set.
"""

import argparse
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pandas as pd

from benchmarks.tables import table
from plugins.studies.coverage import forecast_mean, measure_nearest
from plugins.studies.forecasts import FORECAST
from stages.config.model import Config, read_files
from stages.contracts import TaskAssets, read_json
from stages.tables.writing import write_csv


def forecast_cells(config: Config) -> pd.DataFrame:
    """A policy a row, `FORECAST` and `distance`; targets have committed files of assets and one policy that counts."""
    return pd.DataFrame(_rows(config), columns=[*FORECAST, "distance"])


def _rows(config: Config) -> Iterator[tuple[object, ...]]:
    experiment, tests = config.experiment, config.evaluation
    for name, target in experiment.targets.items():
        file, task = Path(target.assets or ""), experiment.task(name)
        chosen, (plan, *_) = read_json(TaskAssets, file), experiment.plans(name).values()
        unseen = chosen.split(tests.split, tests.assets)
        for training_set, seed in product(plan.training_sets, plan.seeds):
            shown = [asset for role in experiment.roles(training_set, seed) for asset in chosen.assets_of(role, file)]
            forecast = forecast_mean(task, unseen, shown)
            yield task, name, training_set, seed, forecast, float(measure_nearest(unseen, shown).mean())


def main() -> None:
    """Write the file and print the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--configs", type=Path, nargs="+", required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    cells = forecast_cells(read_files(tuple(given.configs)))
    write_csv(given.out, cells)
    means = cells.groupby(["task", "training_set"], sort=False)[["forecast", "distance"]].mean()
    rows = (
        [*key, f"{100 * forecast:.0f} %", f"{gap:.2f}"]
        for key, (forecast, gap) in zip(means.index, means.to_numpy(), strict=True)
    )
    table(["task", "training set", "forecast", "distance"], rows)


if __name__ == "__main__":
    main()
