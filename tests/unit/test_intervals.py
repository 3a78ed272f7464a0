"""Intervals over assets, initial states and runs: known answers, and how often they hold the truth."""

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.tables.intervals import (
    PLACE,
    Side,
    difference_interval,
    pair_sides,
    place_weights,
    rate_interval,
    rate_of,
    score_interval,
    wilson,
)

OPTIONS = TablesConfig(bootstrap_samples=300)


def side(successes: NDArray[np.float64], families: list[int] | None = None) -> Side:
    """A side of (runs, assets, states) successes; every asset is a family of its own unless `families` says else."""
    _, assets, states = successes.shape
    family = families or list(range(assets))
    places = [(f"f{family[a]}", f"a{a}", s) for a in range(assets) for s in range(states)]
    return pd.DataFrame(successes.reshape(len(successes), -1), columns=pd.MultiIndex.from_tuples(places, names=PLACE))


def units(both: int, ours: int, theirs: int, neither: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Units with these cells of the paired 2 x 2 table."""
    counts = (both, ours, theirs, neither)
    return np.repeat([1.0, 1, 0, 0], counts), np.repeat([1.0, 0, 1, 0], counts)


@pytest.mark.parametrize(
    ("cells", "interval"),
    [
        ((36, 12, 2, 0), (0.0569, 0.3404)),  # Newcombe 1998, table III, method 10
        ((20, 12, 2, 16), (0.0562, 0.3292)),
        ((0, 0, 0, 16), (-0.1936, 0.1936)),  # 0/16 against 0/16: as wide as Wilson's interval of 0/16
        ((16, 0, 0, 0), (-0.1936, 0.1936)),
    ],
)
def test_score_interval(cells: tuple[int, int, int, int], interval: tuple[float, float]) -> None:
    ours, theirs = units(*cells)
    assert score_interval(ours, theirs, 0.95) == pytest.approx(interval, abs=1e-4)
    mirrored = [-end for end in score_interval(theirs, ours, 0.95)]
    assert mirrored[::-1] == pytest.approx(interval, abs=1e-4)


def test_assets_weigh_alike_however_many_states_and_runs_they_have() -> None:
    made = side(np.array([[[1, 1], [0, 0]], [[1, 1], [0, 1]]], dtype=float))
    assert rate_of(made) == pytest.approx((1 + 0.25) / 2)
    assert rate_of(made.drop(columns=("f1", "a1", 0))) == pytest.approx((1 + 0.5) / 2)


def test_assets_that_agree_do_not_close_the_interval() -> None:
    all_of_24 = side(np.ones((3, 24, 2)))
    assert rate_interval(all_of_24, OPTIONS) == pytest.approx(wilson(24, 24, 0.95))
    same = difference_interval(all_of_24, all_of_24, OPTIONS)
    assert same == pytest.approx((-0.138, 0.138), abs=1e-3)
    one = side(np.ones((3, 1, 16)))
    assert rate_interval(one, OPTIONS) == pytest.approx(wilson(16, 16, 0.95))  # of a single asset states are units


def test_an_effect_of_one_asset_alone_cannot_be_told_of_others() -> None:
    theirs = np.ones((2, 3, 100))
    for asset, lost in enumerate((1, 6, 69)):
        theirs[:, asset, :lost] = 0
    ours, theirs_side = side(np.ones((2, 3, 100))), side(theirs)
    assert rate_of(ours) - rate_of(theirs_side) == pytest.approx(0.2533, abs=1e-4)
    low, high = difference_interval(ours, theirs_side, OPTIONS)
    assert low < 0 < high
    alone = [made.loc[:, ["f2"]] for made in (ours, theirs_side)]
    assert difference_interval(*alone, OPTIONS).low > 0.5  # on this asset alone


def test_families_are_resampled_whole() -> None:
    rng = np.random.default_rng(0)
    weights = place_weights(side(np.ones((1, 4, 2)), [0, 0, 1, 1]).columns, 200, rng)
    assert weights.sum(axis=1) == pytest.approx(1)
    by_asset = weights.reshape(200, 4, 2).sum(axis=2)
    assert (by_asset[:, 0] == pytest.approx(by_asset[:, 1])) and (by_asset[:, 2] == pytest.approx(by_asset[:, 3]))
    assert {round(float(value), 2) for value in by_asset[:, 0]} == {0.0, 0.25, 0.5}
    opened = np.repeat(rng.random(12) < 0.5, 2).astype(float)[None, :, None] * np.ones((1, 24, 2))
    apart = rate_interval(side(opened), OPTIONS)
    together = rate_interval(side(opened, [asset // 2 for asset in range(24)]), OPTIONS)
    assert together.high - together.low > 1.15 * (apart.high - apart.low)


def test_in_a_resample_an_asset_weighs_the_same_however_many_states_it_has() -> None:
    places = [("f0", "a0", 0), *(("f1", "a1", state) for state in range(4))]
    weights = place_weights(pd.MultiIndex.from_tuples(places, names=PLACE), 200, np.random.default_rng(0))
    assert set(weights[:, 0].round(9)) == {0, 0.5, 1}


def test_runs_are_resampled_where_there_are_several() -> None:
    opened = np.ones((2, 24, 2))
    opened[1, :12] = 0  # one run opens all, the other half of them
    assert rate_interval(side(opened), OPTIONS).low < rate_interval(side(opened[1:]), OPTIONS).high < 0.75
    nothing = side(np.zeros((2, 24, 2)))
    ends = side(np.stack([np.ones((24, 2)), np.zeros((24, 2))]))  # training again may give either
    assert difference_interval(ends, nothing, OPTIONS) == pytest.approx((0, 1))
    assert difference_interval(ends, nothing, OPTIONS) == difference_interval(ends, nothing, OPTIONS)


def test_only_places_where_all_were_tested_are_compared() -> None:
    ours, theirs = side(np.ones((2, 3, 2))), side(np.zeros((1, 2, 2)))
    ours.iloc[0, 0] = np.nan
    assert [made.shape for made in pair_sides(ours, theirs)] == [(2, 3), (1, 3)]
    assert np.isnan(rate_interval(side(np.ones((1, 0, 2))), OPTIONS).low)


def test_runs_that_share_no_asset_have_an_interval_over_all_of_them() -> None:
    """The assets of a training set that every seed draws anew."""
    apart = side(np.ones((2, 8, 1)))
    apart.iloc[0, :4] = apart.iloc[1, 4:] = np.nan
    apart.iloc[0, 4] = 0
    assert rate_interval(apart, OPTIONS) == pytest.approx(wilson(7, 8, 0.95))


def drawn(rng: np.random.Generator, runs: int, effect: float) -> tuple[Side, Side]:
    """Two sides on 24 assets, twice each: most assets are opened always or never, some by one side alone."""
    asset, sides, training = rng.normal(0, 4, 24), [], 0.5 if runs > 1 else 0.0
    for gain in (effect, 0.0):
        own, run = rng.normal(0, 2, 24), rng.normal(0, training, (runs, 1))
        chance = 1 / (1 + np.exp(-(gain + asset + own + run)))
        sides.append(side((rng.random((2, runs, 24)) < chance).astype(float).transpose(1, 2, 0)))
    return sides[0], sides[1]


@pytest.mark.parametrize("runs", [1, 2])
def test_intervals_hold_the_truth_as_often_as_they_say(runs: int) -> None:
    """About 95 % of the time where most assets are opened always or never; more often where fewer are."""
    rng = np.random.default_rng(5)
    spread = np.random.default_rng(6).normal(0, np.sqrt(16 + 4 + 0.25), 200_000)
    truth = [float((1 / (1 + np.exp(-(gain + spread)))).mean()) for gain in (2.0, 0.0)]
    held, wide, experiments = [0, 0], 0.0, 100
    for _ in range(experiments):
        ours, theirs = drawn(rng, runs, 2.0)
        rate, gain = rate_interval(ours, OPTIONS), difference_interval(ours, theirs, OPTIONS)
        held[0] += rate.low <= truth[0] <= rate.high
        held[1] += gain.low <= truth[0] - truth[1] <= gain.high
        wide += (gain.high - gain.low) / experiments
    assert all(count / experiments >= 0.91 for count in held), held
    assert wide < 0.45, wide  # and they are narrow enough to tell an effect of 25 points
