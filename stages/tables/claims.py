"""What the paper says of its policies, claim by claim, and whether the rollouts bear it out (paper B.4).

Every claim compares one number of the policies trained on most cousins with that of a baseline's policies. It holds if
the interval of the difference lies on its side, it does not hold if it lies on the other, else it cannot be said.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from stages.config.tables import TablesConfig
from stages.tables.difference import Successes, paired_interval
from stages.tables.order import set_key, task_key
from stages.tables.table3 import BASELINE, TRAINED

MARGIN = 0.10  # as well as the twin on the twin: not worse by more than this
MIN_RUNS = 2  # a side; one policy says nothing of training again
MIN_SPREAD_RUNS = 3  # a side, to speak of how runs differ
COLLAPSED = 0.25  # a run is collapsed if it succeeds less often than this share of the best run of its task
HOLDS, FAILS, OPEN = "holds", "does not hold", "cannot be said"
COLUMNS = [
    "task", "claim", "training_set", "baseline", "verdict", "difference", "low", "high", "ours", "theirs", "runs",
    "baseline_runs", "published_difference", "published_ours", "published_theirs",
]  # fmt: skip
STABILITY = ["task", "training_set", "runs", "collapsed", "spread"]
STABILITY += ["published_runs", "published_collapsed", "published_spread"]

Rates = Mapping[str, NDArray[np.float64]]  # test asset -> (..., runs) success rates
Cells = Mapping[str, Successes]  # test asset -> (runs, states) successes


def _mean(rates: Rates, assets: list[str]) -> Any:
    return np.mean([rates[asset].mean(axis=-1) for asset in assets], axis=0)


def _unseen(rates: Rates) -> list[str]:
    return [asset for asset in rates if asset != BASELINE]


def spread(rates: Rates) -> Any:
    """How runs differ: sample standard deviation over runs, pooled over the test assets; NaN of one run."""
    if next(iter(rates.values())).shape[-1] < 2:
        return np.nan
    return np.sqrt(np.mean([rates[asset].var(axis=-1, ddof=1) for asset in rates], axis=0))


class Claim(NamedTuple):
    """One claim: the number that is compared (more is better), the baseline, how little is still no less."""

    measure: Callable[[Rates], Any]
    baseline: str = BASELINE
    margin: float = 0.0
    runs: int = MIN_RUNS


CLAIMS = {
    "equal": Claim(lambda rates: _mean(rates, [BASELINE]), margin=MARGIN),
    "unseen": Claim(lambda rates: _mean(rates, _unseen(rates))),
    "flat": Claim(lambda rates: _mean(rates, _unseen(rates)) - _mean(rates, [BASELINE])),
    "steady": Claim(lambda rates: -spread(rates), runs=MIN_SPREAD_RUNS),
    "all": Claim(lambda rates: _mean(rates, list(rates)), baseline="all"),
}
POOLED: dict[str, Callable[[Cells], list[str]]] = {
    "equal": lambda cells: [BASELINE],
    "unseen": lambda cells: [asset for asset in cells if asset != BASELINE],
    "all": list,
}  # claims about a plain rate, over these test assets


def verdict(claim: Claim, low: float, high: float, runs: int) -> str:
    """What an interval says of a claim; `runs`: of the side that has fewer."""
    if runs < claim.runs:
        return OPEN
    return HOLDS if low > -claim.margin else FAILS if high < -claim.margin else OPEN


def resampled(sides: list[Cells], samples: int, seed: int) -> list[Rates]:
    """Bootstrap of both sides: test asset -> (samples, runs) rates, over states that they share and over their runs."""
    rng = np.random.default_rng(seed)
    picked = [rng.integers(0, runs, (samples, runs)) for runs in (len(next(iter(side.values()))) for side in sides)]
    drawn: list[dict[str, NDArray[np.float64]]] = [{} for _ in sides]
    for asset in sides[0]:
        states = sides[0][asset].shape[1]
        weights = rng.multinomial(states, np.full(states, 1 / states), size=samples) / states
        for side, runs, rates in zip(sides, picked, drawn, strict=True):
            rates[asset] = np.take_along_axis(weights @ side[asset].T, runs, axis=1)
    return list(drawn)


def compare(name: str, ours: Cells, theirs: Cells, options: TablesConfig) -> dict[str, Any]:
    """The difference of a claim's measure, its interval and the verdict; both sides share assets and states."""
    claim = CLAIMS[name]
    ends = [claim.measure({asset: part.mean(axis=1) for asset, part in side.items()}) for side in (ours, theirs)]
    runs = [len(next(iter(side.values()))) for side in (ours, theirs)]
    low = high = float("nan")
    if min(runs) >= claim.runs:
        drawn = [claim.measure(side) for side in resampled([ours, theirs], options.bootstrap_samples, options.seed)]
        tail = (1 - options.confidence) / 2
        low, high = (float(end) for end in np.quantile(drawn[0] - drawn[1], [tail, 1 - tail]))
        if name in POOLED:  # runs that agree at 0 or 1 do not close the interval
            sides = [np.concatenate([side[asset] for asset in POOLED[name](ours)], axis=1) for side in (ours, theirs)]
            score = paired_interval(sides[0], sides[1], options.confidence)
            low, high = min(low, score.low), max(high, score.high)
    return {
        "ours": float(ends[0]), "theirs": float(ends[1]), "difference": float(ends[0] - ends[1]), "low": low,
        "high": high, "runs": runs[0], "baseline_runs": runs[1], "verdict": verdict(claim, low, high, min(runs)),
    }  # fmt: skip


def _cells(rollouts: pd.DataFrame) -> dict[str, dict[str, pd.DataFrame]]:
    """Training set -> test asset -> successes, a row per policy and a column per initial state."""
    tested = rollouts[rollouts["test_asset"] != TRAINED]
    found: dict[str, dict[str, pd.DataFrame]] = {}
    for (name, asset), group in tested.groupby(["training_set", "test_asset"]):
        policies = ["run", "seed", "checkpoint"]
        table = group.pivot_table(index=policies, columns="initial_state", values="success", aggfunc="mean")
        found.setdefault(str(name), {})[str(asset)] = table.astype(float)
    return found


def _shared(ours: dict[str, pd.DataFrame], theirs: dict[str, pd.DataFrame]) -> tuple[Cells, Cells]:
    """Both sides on the assets and from the states that all their policies share."""
    sides: tuple[dict[str, Successes], dict[str, Successes]] = ({}, {})
    for asset in sorted(set(ours) & set(theirs), key=set_key):
        both = pd.concat([ours[asset], theirs[asset]], keys=["ours", "theirs"]).dropna(axis="columns")
        if both.shape[1]:
            for side, key in zip(sides, ("ours", "theirs"), strict=True):
                side[asset] = np.asarray(both.loc[key], dtype=float)
    return sides


def published_cells(published: pd.DataFrame) -> dict[tuple[str, str], Rates]:
    """The paper's rates by task and training set; `published` as `rows.published_runs` gives them."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    for (task, name, asset), group in published.groupby(["task", "training_set", "test_asset"]):
        found.setdefault((str(task), str(name)), {})[str(asset)] = group["rate"].to_numpy(dtype=float)
    return dict(found)


def most_cousins(sets: Iterable[str]) -> str | None:
    """The training set with most cousins."""
    return max((name for name in sets if name.startswith("cousins_")), key=set_key, default=None)


def answer(rollouts: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per task and claim with `COLUMNS`, for every claim whose training sets were rolled out.

    Args:
        rollouts: rows of `Rollout`.
        published: success of the paper's runs, for the same numbers of the paper.
    """
    paper, rows = published_cells(published), []
    for task in sorted(rollouts["task"].unique(), key=task_key):
        sets = _cells(rollouts[rollouts["task"] == task])
        most = most_cousins(sets)
        for name, claim in CLAIMS.items():
            if most is None or claim.baseline not in sets:
                continue
            ours, theirs = _shared(sets[most], sets[claim.baseline])
            if BASELINE not in ours or len(ours) < 2:
                continue
            row = {"task": task, "claim": name, "training_set": most, "baseline": claim.baseline}
            row |= compare(name, ours, theirs, options)
            known = [paper.get((task, side)) for side in (most, claim.baseline)]
            if known[0] and known[1]:
                ends = [float(claim.measure(side)) for side in known if side]
                row |= {"published_ours": ends[0], "published_theirs": ends[1]}
                row["published_difference"] = ends[0] - ends[1]
            rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


def _collapsed(gates: Mapping[str, NDArray[np.float64]]) -> dict[str, int]:
    """Runs per training set below the share of the best; `gates`: rate of every run on what it should master."""
    best = max((float(rates.max()) for rates in gates.values()), default=0.0)
    return {name: int((rates < COLLAPSED * best).sum()) for name, rates in gates.items()}


def stability(table: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Per task and training set how many runs collapsed, and how runs differ, with `STABILITY`.

    A run is judged by its success on the very assets it was trained on, or on the twin if those were not tested (so
    the paper's).

    Args:
        table: as `table3.build` gives.
        published: success of the paper's runs.
    """
    paper, rows = published_cells(published), []
    ran = table[table["status"] == "run"]
    for task in sorted(ran["task"].unique(), key=task_key):
        mine = ran[ran["task"] == task]
        gate = TRAINED if (mine["test_asset"] == TRAINED).any() else BASELINE
        rates = {
            str(name): {str(a): np.asarray(g["success_rate"], dtype=float) for a, g in group.groupby("test_asset")}
            for name, group in mine.groupby("training_set")
        }
        ours = _collapsed({name: cells[gate] for name, cells in rates.items() if gate in cells})
        known = {name: cells for (of, name), cells in paper.items() if of == task}
        theirs = _collapsed({name: cells[BASELINE] for name, cells in known.items()})
        for name in sorted(rates, key=set_key):
            tested = {asset: cell for asset, cell in rates[name].items() if asset != TRAINED}
            runs = max(len(cell) for cell in rates[name].values())
            row: dict[str, Any] = {"task": task, "training_set": name, "runs": runs, "collapsed": ours.get(name)}
            row["spread"] = float(spread(tested)) if tested and runs > 1 else float("nan")
            if name in known:
                row |= {"published_runs": len(known[name][BASELINE]), "published_collapsed": theirs[name]}
                row["published_spread"] = float(spread(known[name]))
            rows.append(row)
    made = pd.DataFrame(rows, columns=STABILITY)
    return made.astype(dict.fromkeys(["runs", "collapsed", "published_runs", "published_collapsed"], "Int64"))
