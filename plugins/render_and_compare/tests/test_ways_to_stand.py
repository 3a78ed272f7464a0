"""The ways to stand that are tried: those that a model's symmetry makes equal are one."""

import numpy as np
import pytest

from roomkin.plugins.render_and_compare.fits import leave_out_equal
from roomkin.stages.geometry.frames import SYMMETRY_PERIOD

QUARTERS = [k * np.pi / 2 for k in range(4)]


@pytest.mark.parametrize(
    ("symmetry", "kept"), [("none", [0, 1, 2, 3, 5]), ("half_turn", [0, 1, 5]), ("quarter_turn", [0, 5]), ("full", [0])]
)
def test_what_looks_alike_is_tried_once(symmetry: str, kept: list[int]) -> None:
    yaws = [*QUARTERS, 2 * np.pi - 0.01, 0.7]  # the fifth is the first, a little off
    assert leave_out_equal(yaws, SYMMETRY_PERIOD[symmetry]) == [yaws[number] for number in kept]
