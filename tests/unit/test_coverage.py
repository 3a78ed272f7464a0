"""How far unseen assets are from what training shows, and the forecast of success from that."""

import math

import numpy as np
import pytest

from stages.experiment.coverage import CURVES, distances, forecast, forecast_mean, nearest
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
    assert nearest(unseen, SHOWN) == pytest.approx([0, math.log(0.8 / 0.7) / 0.35])
    assert nearest(unseen, SHOWN[:1])[1] == pytest.approx(math.log(0.7 / 0.4) / 0.35)


@pytest.mark.parametrize("task", CURVES)
def test_success_is_expected_to_fall_with_distance(task: str) -> None:
    widths = [0.4 * math.exp(0.35 * gap) for gap in (0, 0.5, 1, 2, 4, 8)]
    unseen = [an_asset(f"u{width:.3f}", panel_size=(width, 0.6)) for width in widths]
    shares = forecast(task, unseen, SHOWN[:1])
    assert (np.diff(shares) < 0).all() and shares[0] > 0.8 and 0 < shares[-1] < 0.05
    assert shares[2] == pytest.approx(1 / (1 + math.exp(CURVES[task].slope - CURVES[task].level)))
    assert forecast_mean(task, unseen, SHOWN[:1]) == pytest.approx(shares.mean())
    assert forecast_mean(task, unseen, SHOWN) > shares.mean(), "a set that shows more is expected to reach more"
