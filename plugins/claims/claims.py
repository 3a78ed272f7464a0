"""The paper's claims about policies, one by one, and whether the rollouts support them (paper B.4).

Every claim compares one number of the policies trained on most cousins with that of a baseline's policies. It holds if
the interval of the difference lies on its side, it does not hold if it lies on the other, else it cannot be said. With
one run a side it cannot be said either: that interval is over assets and states, about these policies alone. Where its
assets are so few that even a large effect would not show (`power`), that is what is said.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from roomkin.plugins.claims import power
from roomkin.plugins.claims.assets import find_judged_set
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.tables import intervals
from roomkin.stages.tables.rows import ROW, SKILL, SPLITS, set_key
from roomkin.stages.tables.table3 import BASELINE, RANDOMISED, TRAINED, UNSEEN

NOT_WORSE = 0.10  # as well as the twin on the twin: not worse by more than this
MIN_RUNS = 2  # seeds of a method, a side; one run shows nothing about training again
MIN_SPREAD_RUNS = 3  # runs, seeds or cells that tell how such differ
COLLAPSED = 0.25  # a run is collapsed if it succeeds less often than this share of the best run of its task
HOLDS, FAILS, OPEN = "holds", "does not hold", "cannot be said"
TOO_FEW = "too few {} to decide"
POWER_SAMPLES = 200  # of the bootstrap of made-up results, of which there are many
COLUMNS = [
    *ROW, "claim", "training_set", "baseline", "over", "assets", "verdict", "difference", "low", "high", "ours",
    "theirs", "shows", "runs", "baseline_runs", "published_difference", "published_ours", "published_theirs",
]  # fmt: skip
STABILITY = [*ROW, "training_set", "runs", "collapsed", "spread"]
STABILITY += ["published_runs", "published_collapsed", "published_spread"]

Rates = Mapping[str, NDArray[np.float64]]  # `twin`, `unseen` (of the paper: test assets) -> (..., runs) rates
Sides = dict[str, intervals.Side]  # `twin`, `unseen` -> successes


def spread(rates: Rates) -> Any:
    """How runs differ: sample standard deviation over runs, pooled over what is tested; NaN of one run."""
    if next(iter(rates.values())).shape[-1] < 2:
        return np.nan
    return np.sqrt(np.mean([rate.var(axis=-1, ddof=1) for rate in rates.values()], axis=0))


class Claim(NamedTuple):
    """One claim: the number that is compared (more is better), the baseline, how little is still no less.

    plus, minus: the means that it adds and takes away; without them it compares how runs differ.
    """

    plus: str = ""
    minus: str = ""
    baseline: str = BASELINE
    margin: float = 0.0
    runs: int = MIN_RUNS

    def measure(self, rates: Rates) -> Any:
        """The number: (...) of (..., runs) rates."""
        if not self.plus:
            return -spread(rates)
        means = {name: rate.mean(axis=-1) for name, rate in rates.items()}
        return means[self.plus] - means[self.minus] if self.minus else means[self.plus]


CLAIMS = {
    "equal": Claim(BASELINE, margin=NOT_WORSE),
    "unseen": Claim(UNSEEN),
    "flat": Claim(UNSEEN, BASELINE),
    "steady": Claim(runs=MIN_SPREAD_RUNS),
    "randomised": Claim(UNSEEN, baseline=RANDOMISED),
    "all": Claim(UNSEEN, baseline="all"),
}


def judge_claim(claim: Claim, low: float, high: float, runs: int) -> str:
    """The verdict on a claim by the interval of its difference; `runs`: `times_trained` of the side that has fewer."""
    if runs < claim.runs:
        return OPEN
    return HOLDS if low > -claim.margin else FAILS if high < -claim.margin else OPEN


def score_floor(claim: Claim, ours: Sides, theirs: Sides, confidence: float) -> intervals.Interval:
    """The narrowest interval of the difference of a mean; of two means the squares of their widths add up.

    The latter is Newcombe's own way from two intervals to one of a difference.
    """

    def bound_one(name: str) -> tuple[float, intervals.Interval]:
        units = intervals.unit_rates(ours[name]), intervals.unit_rates(theirs[name])
        return float(units[0].mean() - units[1].mean()), intervals.score_interval(*units, confidence)

    middle, (low, high) = bound_one(claim.plus)
    if not claim.minus:
        return intervals.Interval(low, high)
    other, (other_low, other_high) = bound_one(claim.minus)
    down, up = np.hypot(middle - low, other_high - other), np.hypot(high - middle, other - other_low)
    return intervals.Interval(float(middle - other - down), float(middle - other + up))


def times_trained(side: intervals.Side) -> int:
    """How often a side's method was trained: the seeds of that of its hyper-parameter sets which has fewest.

    More sets, a seed each, say nothing about training one of them again.
    """
    return int(side.index.to_frame(index=False).groupby("run")["seed"].nunique().min())


def compare(name: str, ours: Sides, theirs: Sides, options: TablesConfig) -> dict[str, Any]:
    """The difference of a claim's measure, its interval and the verdict; both sides share assets and states."""
    claim = CLAIMS[name]
    ends = [claim.measure({key: np.asarray(_by_run(part)) for key, part in side.items()}) for side in (ours, theirs)]
    runs = [times_trained(next(iter(side.values()))) for side in (ours, theirs)]
    low = high = float("nan")
    if claim.plus or min(runs) >= claim.runs:
        names = [key for key in ours if not claim.plus or key in (claim.plus, claim.minus)]
        pairs = intervals.resample_rates([[ours[key], theirs[key]] for key in names], options)
        sides = [claim.measure({key: pair[side] for key, pair in zip(names, pairs, strict=True)}) for side in (0, 1)]
        found = intervals.quantiles(sides[0] - sides[1], options)
        floor = score_floor(claim, ours, theirs, options.confidence) if claim.plus else found
        low, high = min(found.low, floor.low), max(found.high, floor.high)
    return {
        "ours": float(ends[0]), "theirs": float(ends[1]), "difference": float(ends[0] - ends[1]), "low": low,
        "high": high, "runs": runs[0], "baseline_runs": runs[1], "verdict": judge_claim(claim, low, high, min(runs)),
    }  # fmt: skip


def find_shown(name: str, ours: Sides, theirs: Sides, options: TablesConfig) -> float:
    """The smallest effect that a claim can show with these policies and places, in [0, 1]; NaN: none."""
    claim, quick = CLAIMS[name], options.model_copy(update={"bootstrap_samples": POWER_SAMPLES})
    if min(times_trained(next(iter(side.values()))) for side in (ours, theirs)) < claim.runs:
        return float("nan")

    def holds(one: Sides, other: Sides) -> bool:
        return bool(compare(name, one, other, quick)["verdict"] == HOLDS)

    return power.find_smallest(ours, theirs, claim.plus, claim.margin, holds, options.seed)


def call_undecidable(row: dict[str, Any]) -> str:
    """The verdict of a row; an open one says what there is too little of if `shows` is no effect, or a large one."""
    lacks_runs = min(row["runs"], row["baseline_runs"]) < CLAIMS[row["claim"]].runs
    if row["verdict"] != OPEN or lacks_runs or row["shows"] <= power.LARGE:
        return str(row["verdict"])
    lacking = "runs" if row["claim"] == "steady" else "starts" if row["over"] == BASELINE else "assets"
    return TOO_FEW.format(lacking)


def _by_run(side: intervals.Side) -> pd.Series:
    """The rate of every run, assets alike."""
    return side.T.groupby(level=["family", "asset"]).mean().mean()


def _sides(rollouts: pd.DataFrame, ours: str, theirs: str) -> tuple[Sides, Sides]:
    """Both training sets on the twin and on unseen assets, where all their policies were tested."""
    over, tested = find_judged_set(rollouts), rollouts["test_asset"]
    roles = ~tested.isin([BASELINE, TRAINED, *SPLITS])
    rows = {BASELINE: tested == BASELINE, UNSEEN: roles if over == "roles" else tested == over}
    sides: tuple[Sides, Sides] = ({}, {})
    for name, which in rows.items():
        found = rollouts[which]
        both = (found[found["training_set"] == side] for side in (ours, theirs))
        pair = intervals.pair_sides(*map(intervals.side_of, both))
        if not pair[0].empty:
            sides[0][name], sides[1][name] = pair
    return sides


def published_cells(published: pd.DataFrame) -> dict[tuple[str, str, str], Rates]:
    """The paper's rates by target, policy and training set; `published` as `methods.join_published` gives them."""
    found: dict[tuple[str, str, str], dict[str, Any]] = {}
    for (*row, name, asset), group in published.groupby(["target", "policy", "training_set", "test_asset"]):
        found.setdefault((str(row[0]), str(row[1]), str(name)), {})[str(asset)] = group["rate"].to_numpy(dtype=float)
    return dict(found)


def most_cousins(sets: Iterable[str]) -> str | None:
    """The training set with most cousins."""
    return max((name for name in sets if name.startswith("cousins_")), key=set_key, default=None)


def published_sides(rates: Rates) -> Rates:
    """The paper's rates on the twin and, by run, their mean over the other test assets."""
    return {BASELINE: rates[BASELINE], UNSEEN: np.mean([rates[name] for name in rates if name != BASELINE], axis=0)}


def answer(rollouts: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per target, policy and claim with `COLUMNS`, for every claim whose training sets were rolled out.

    Args:
        rollouts: rows of `Rollout`.
        published: success of the paper's runs, from `methods.join_published`, for the same numbers of the paper.
    """
    paper, rows = published_cells(published), []
    rollouts = rollouts[rollouts["training_set"] != SKILL]
    for (target, task, policy), mine in rollouts.groupby(ROW, sort=False):
        sets = set(mine["training_set"])
        if (most := most_cousins(sets)) is None:
            continue
        pairs = {name: _sides(mine, most, name) for name in {claim.baseline for claim in CLAIMS.values()} & sets}
        for name, claim in CLAIMS.items():
            main = claim.plus or UNSEEN
            ours, theirs = pairs.get(claim.baseline, ({}, {}))
            if not {main, claim.minus or main} <= set(ours):
                continue
            row = {"target": target, "task": task, "policy": policy, "claim": name, "training_set": most}
            row |= {"baseline": claim.baseline, "over": BASELINE if main == BASELINE else find_judged_set(mine)}
            row["assets"] = ours[main].columns.get_level_values("asset").nunique()
            row |= compare(name, ours, theirs, options) | {"shows": find_shown(name, ours, theirs, options)}
            row["verdict"] = call_undecidable(row)
            known = [paper.get((str(target), str(policy), side)) for side in (most, claim.baseline)]
            if known[0] and known[1]:
                ends = [float(claim.measure(published_sides(side))) for side in known if side]
                row |= {"published_ours": ends[0], "published_theirs": ends[1]}
                row["published_difference"] = ends[0] - ends[1]
            rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


def _count_collapsed(gates: Mapping[str, NDArray[np.float64]]) -> dict[str, int]:
    """Runs per training set below the share of the best; `gates`: rate of every run on what it should master."""
    best = max((float(rates.max()) for rates in gates.values()), default=0.0)
    return {name: int((rates < COLLAPSED * best).sum()) for name, rates in gates.items()}


def stability(table: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Per target, policy and training set how many runs collapsed, and how runs differ, with `STABILITY`.

    A run is judged by its success on the very assets it was trained on, or on the twin if those were not tested (so
    the paper's).

    Args:
        table: as `table3.build` gives.
        published: success of the paper's runs beside ours.
    """
    paper, rows = published_cells(published), []
    ran = table[table["status"] == "run"]
    for key, mine in ran.groupby(ROW, sort=False):
        target, _, policy = map(str, key)
        gate = TRAINED if (mine["test_asset"] == TRAINED).any() else BASELINE
        rates = {
            str(name): {str(a): np.asarray(g["success_rate"], dtype=float) for a, g in group.groupby("test_asset")}
            for name, group in mine.groupby("training_set")
        }
        ours = _count_collapsed({name: cells[gate] for name, cells in rates.items() if gate in cells})
        known = {name: cells for (*of, name), cells in paper.items() if of == [target, policy]}
        theirs = _count_collapsed({name: cells[BASELINE] for name, cells in known.items()})
        for name in sorted(rates, key=set_key):
            tested = {asset: cell for asset, cell in rates[name].items() if asset != TRAINED}
            runs = max(len(cell) for cell in rates[name].values())
            row: dict[str, Any] = dict(zip(ROW, key, strict=True)) | {"training_set": name, "runs": runs}
            row["collapsed"] = ours.get(name)
            row["spread"] = float(spread(tested)) if tested and runs > 1 else float("nan")
            if name in known:
                row |= {"published_runs": len(known[name][BASELINE]), "published_collapsed": theirs[name]}
                row["published_spread"] = float(spread(known[name]))
            rows.append(row)
    stability = pd.DataFrame(rows, columns=STABILITY)
    return stability.astype(dict.fromkeys(["runs", "collapsed", "published_runs", "published_collapsed"], "Int64"))
