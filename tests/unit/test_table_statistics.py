"""How the figures of tables weigh what they are made of: assets, states, runs and the two ends of an interval."""

import numpy as np
import pandas as pd
import pytest

from stages.tables import claims
from stages.tables.associations import _correlation
from stages.tables.intervals import PLACE, Side, place_weights


def test_worse_than_the_twin_within_the_margin_is_not_shown_to_be_worse() -> None:
    equal, unseen = claims.CLAIMS["equal"], claims.CLAIMS["unseen"]
    assert claims.verdict(equal, -0.2, -0.05, 6) == "cannot be said"
    assert claims.verdict(unseen, -0.2, -0.05, 6) == "does not hold"


def test_of_a_runs_own_task_the_best_says_what_is_collapsed() -> None:
    rates = {"twin": np.array([0.4, 0.2]), "cousins_8": np.array([0.12, 0.05])}
    assert claims._collapsed(rates) == {"twin": 0, "cousins_8": 1}


def on_assets(*opened: int) -> Side:
    """One run on 20 assets, of which so many of the first are opened; asset by asset one state."""
    places = pd.MultiIndex.from_tuples([(f"f{n}", f"a{n}", n) for n in range(20)], names=PLACE)
    return pd.DataFrame([[float(n < count) for n in range(20)] for count in opened], columns=places)


def test_what_is_lost_has_the_interval_of_what_is_gained() -> None:
    """Taken the other way round a difference of differences has the same interval, mirrored."""
    ours = {"twin": on_assets(20), "unseen": on_assets(18)}
    theirs = {"twin": on_assets(19), "unseen": on_assets(6)}
    low, high = claims.score_floor(claims.Claim("unseen", "twin"), ours, theirs, 0.95)
    mirrored = claims.score_floor(claims.Claim("twin", "unseen"), ours, theirs, 0.95)
    middle = (18 - 6) / 20 - (20 - 19) / 20
    assert (-mirrored.high, -mirrored.low) == pytest.approx((low, high))
    assert low < middle < high and abs(high + low - 2 * middle) > 0.05  # 0.55 is nearer to the end of what can be


def test_an_asset_with_more_states_weighs_no_more() -> None:
    places = pd.MultiIndex.from_tuples([("f", "often", n) for n in range(4)] + [("f", "once", 0)], names=PLACE)
    weights = place_weights(places, 50, np.random.default_rng(0))
    assert weights[:, :4].sum(axis=1) == pytest.approx(0.5) and weights[:, 4] == pytest.approx(0.5)


def test_a_correlation_under_weights_is_that_of_so_many_assets() -> None:
    pairs = np.array([[1.0, 2], [2, 1], [3, 5], [4, 3], [9, 0]])
    weights = np.array([[1, 1, 1, 1, 0], [0, 3, 1, 2, 1], [2, 0, 0, 0, 3]])
    expected = [np.corrcoef(np.repeat(pairs, times, axis=0).T)[0, 1] for times in weights]
    assert _correlation(pairs, weights.astype(float)) == pytest.approx(expected)
