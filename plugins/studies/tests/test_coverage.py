"""How far unseen assets are from what training shows, and the forecast of success from that."""

import math
from itertools import combinations

import numpy as np
import pytest

from plugins.studies.coverage import (
    CURVES,
    distances,
    find_isolated,
    forecast,
    forecast_mean,
    measure_coverage,
    measure_nearest,
    most_covered,
)
from stages.contracts.policies import TaskAsset
from tests.unit.demo_assets import an_asset

SHOWN = [an_asset("near", panel_size=(0.4, 0.6), handle_height=0.5), an_asset("far", panel_size=(0.8, 0.6))]


def test_distance_is_in_ratio_of_widths_and_height_of_the_handle() -> None:
    wider = an_asset("wider", panel_size=(0.4 * math.exp(0.35), 2.0))
    higher = an_asset("higher", panel_size=(0.4, 0.1), handle_height=0.5 + 0.18)
    both = an_asset("both", panel_size=(0.4 * math.exp(0.35 * 3), 0.6), handle_height=0.5 - 0.18 * 4)
    to_near, to_far = distances([SHOWN[0], wider, higher, both], SHOWN).T
    assert to_near == pytest.approx([0, 1, 1, 5])
    assert to_far[:2] == pytest.approx([math.log(2) / 0.35, math.log(2) / 0.35 - 1])


def test_the_nearest_training_asset_counts() -> None:
    unseen = [an_asset("a", panel_size=(0.4, 0.6)), an_asset("b", panel_size=(0.7, 0.6))]
    assert measure_nearest(unseen, SHOWN) == pytest.approx([0, math.log(0.8 / 0.7) / 0.35])
    assert measure_nearest(unseen, SHOWN[:1])[1] == pytest.approx(math.log(0.7 / 0.4) / 0.35)


@pytest.mark.parametrize("task", CURVES)
def test_success_is_expected_to_fall_with_distance(task: str) -> None:
    widths = [0.4 * math.exp(0.35 * gap) for gap in (0, 0.5, 1, 2, 4, 8)]
    unseen = [an_asset(f"u{width:.3f}", panel_size=(width, 0.6)) for width in widths]
    shares = forecast(task, unseen, SHOWN[:1])
    assert (np.diff(shares) < 0).all() and shares[0] > 0.8 and 0 < shares[-1] < 0.05
    assert shares[2] == pytest.approx(1 / (1 + math.exp(CURVES[task].slope - CURVES[task].level)))
    assert forecast_mean(task, unseen, SHOWN[:1]) == pytest.approx(shares.mean())
    assert forecast_mean(task, unseen, SHOWN) > shares.mean(), "a set that shows more is expected to reach more"


def line(*widths: float) -> list[TaskAsset]:
    """Assets whose fronts are so many distances wider than 40 cm."""
    return [an_asset(f"w{number}", panel_size=(0.4 * math.exp(0.35 * at), 0.6)) for number, at in enumerate(widths)]


def test_covered_is_the_share_within_reach_and_alone_what_only_its_family_shows() -> None:
    assets = line(0, 0.5, 0.9, 2.1, 5)
    assert measure_coverage(assets, assets[:1], 1) == 0.6 and measure_coverage(assets, assets[1:2], 2) == 0.8
    assert [asset.asset for asset in find_isolated(assets, 1)] == ["w3", "w4"]
    kin = [an_asset("w3_2", panel_size=assets[3].panel_size), *assets]  # of another family by its name's beginning
    assert kin[0].family == "w3" == kin[4].family
    assert [asset.asset for asset in find_isolated(kin, 1)] == ["w3_2", "w3", "w4"]


def test_no_set_covers_more_than_the_bound_and_a_greedy_one_no_less_than_it_says() -> None:
    rng = np.random.default_rng(0)
    for count in (1, 2, 3):
        for _ in range(20):
            assets = line(*rng.uniform(0, 8, 9))
            greedy, bound = most_covered(assets, count, 1)
            best = max(measure_coverage(assets, some, 1) for some in combinations(assets, count))
            assert greedy <= best <= bound <= 1
            if count == 1:
                assert greedy == best == bound


def test_a_set_as_large_as_the_library_covers_it() -> None:
    assert most_covered(line(0, 3, 6), 3, 1) == (1, 1) and most_covered(line(0, 3, 6), 2, 1) == pytest.approx(
        (2 / 3, 2 / 3)
    )
