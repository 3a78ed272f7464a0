"""Success of the last run's policies over the unseen assets of one category, e.g. the fridges of first-policy.md.

python -m benchmarks.of_category --category fridge
"""

import argparse
from pathlib import Path

import pandas as pd

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts import TaskAssets, read_json
from roomkin.stages.tables.intervals import Interval, difference_interval, pair_sides, rate_interval, rate_of, side_of


def in_percent(rate: float, interval: Interval, sign: str = "") -> str:
    """A rate with its interval."""
    return f"{100 * rate:{sign}.0f} [{100 * interval.low:.0f}, {100 * interval.high:.0f}]"


def main() -> None:
    """Print a line per policy, and one for what cousins gain over the twin."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--target", default="door")
    parser.add_argument("--category", required=True)
    given = parser.parse_args()
    plan = read_json(TaskAssets, given.results / f"experiment/default/{given.target}/assets.json")
    named = {asset.asset for asset in plan.test_assets if asset.category == given.category}
    options = TablesConfig()
    files = [*given.results.glob(f"evaluation/policies/{given.target}/*/*/rollouts.csv")]
    files += given.results.glob(f"evaluation/skill/{given.target}/rollouts.csv")
    rollouts = pd.concat([pd.read_csv(file) for file in sorted(files)])
    rollouts = rollouts[(rollouts["test_asset"] == "test") & rollouts["asset"].isin(named)]
    for policy, rows in rollouts.groupby("policy"):
        sides = {name: side_of(some) for name, some in rows.groupby("training_set")}
        for name, side in sides.items():
            some = rows[rows["training_set"] == name]
            rate = in_percent(rate_of(side), rate_interval(side, options))
            print(f"{policy}, {name}: {rate} % of {some['asset'].nunique()}, {len(some)} rollouts")
        for name in [name for name in sides if "twin" in sides and name != "twin"]:
            ours, theirs = pair_sides(sides[name], sides["twin"])
            gain = in_percent(rate_of(ours) - rate_of(theirs), difference_interval(ours, theirs, options), "+")
            print(f"{policy}, {name} - twin: {gain} points")


if __name__ == "__main__":
    main()
