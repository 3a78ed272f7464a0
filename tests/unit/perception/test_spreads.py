"""How sure a camera is, and when its lines and its things disagree."""

from dataclasses import replace

import numpy as np
import pytest

from roomkin.stages.perception.layout import room as spreads
from tests.unit.perception.test_room import layout_of


def test_a_spread_is_that_of_the_deviations_and_the_heights_is_wider() -> None:
    own = np.array([0.1, 0.02, 0.1, 0.05, 0.2])
    found = spreads.measure_spread(lambda state: state / own, np.zeros(5))
    assert found == pytest.approx((0.02, spreads.TOGETHER * 0.2, 0.05)) and spreads.TOGETHER > 1


def test_a_picture_without_lines_disagrees_with_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spreads, "measure_spread", lambda *_: spreads.Spread(1e-6, 0.1, 0.1))
    layout, state = layout_of()
    assert "by its lines" in spreads.compare_tilts(layout, state)
    layout.camera = replace(layout.camera, given=layout.camera.given.model_copy(update={"guides": []}))
    assert spreads.compare_tilts(layout, state) == ""
