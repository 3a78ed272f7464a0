"""`objects`: what cousins add at each of many objects, and over objects: the unit of docs/results/objects_design.md."""

from pathlib import Path

import numpy as np
import pandas as pd

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.tables.intervals import t_interval
from roomkin.stages.tables.rows import ONE_TEST, read_rows

ASKED = (("cousins_8", "twin"), ("random_8", "cousins_8"))  # ours minus theirs: cousins or the twin, chance or nearness
CONFIDENCE = 0.95
NEAR = 0.10  # two sets are as good if they lie no farther apart
ROLLED = "evaluation/policies/*/lite/*/rollouts.csv"  # below a folder of results: target, training set
# Deviations that a forecast supposes: of the gain over objects, of a policy over trainings; docs/results/registered.md
OVER_OBJECTS, OVER_TRAININGS = 0.10, 0.10


def run(*, results: tuple[Path, ...]) -> None:
    """Print the difference at each object, and its mean over objects with the t interval.

    Args:
        results: folders of runs, one for each library seed: a target of each is an object.
    """
    rates = read_rates(results)
    for ours, theirs in ASKED:
        found = compare(rates, ours, theirs)
        for name, difference in found.items():
            print(f"{ours} minus {theirs}, {name}: {100 * difference:+.0f} points")
        low, high = t_interval(found, CONFIDENCE)
        span = f"[{100 * low:.0f}, {100 * high:.0f}]"
        print(f"{ours} minus {theirs}: {100 * found.mean():+.1f} points {span}, {len(found)} objects")


def read_rates(results: tuple[Path, ...]) -> pd.DataFrame:
    """Success over unseen assets, in [0, 1], of every object (rows) by training set (columns), assets alike.

    Raises:
        InputError: there are no rollouts.
    """
    rates: dict[str, dict[str, float]] = {}
    for folder in results:
        for path in sorted(folder.glob(ROLLED)):
            rows = read_rows(Rollout, [path], ONE_TEST)
            rows = rows[rows["test_asset"] == "test"]
            place = rates.setdefault(f"{folder.parent.name}/{path.parts[-4]}", {})
            place[path.parts[-2]] = float(rows.groupby("asset")["success"].mean().mean())
    if not rates:
        raise InputError("--results", f"no {ROLLED} in there.", "run the study first", code="E-ROLLOUTS-MISSING")
    return pd.DataFrame.from_dict(rates, orient="index")


def compare(rates: pd.DataFrame, ours: str, theirs: str) -> pd.Series:
    """The difference at every object where both sets were rolled out."""
    return (rates.get(ours, pd.Series(dtype=float)) - rates.get(theirs, pd.Series(dtype=float))).dropna()


def forecast(
    gain: float, objects: int, assets: int, rate: float = 0.45, tries: int = 2000, seed: int = 0
) -> tuple[float, float]:
    """Shares of made-up studies whose interval lies above 0, and which lie within 10 points of 0.

    Args:
        gain: the true mean difference over objects; it differs by `OVER_OBJECTS` from object to object.
        objects: how many.
        assets: unseen ones an object, one start each, the same for both sets.
        rate: success of theirs.
    """
    rng = np.random.default_rng(seed)
    gains = gain + OVER_OBJECTS * rng.standard_normal((tries, objects))
    drift = OVER_TRAININGS * rng.standard_normal((2, tries, objects))
    ours, theirs = (np.clip(rate + one, 0, 1) for one in (gains + drift[0], drift[1]))
    found = (rng.binomial(assets, ours) - rng.binomial(assets, theirs)) / assets
    ends = [t_interval(pd.Series(one), CONFIDENCE) for one in found]
    within = [low > -NEAR and high < NEAR for low, high in ends]
    return float(np.mean([low > 0 for low, _ in ends])), float(np.mean(within))
