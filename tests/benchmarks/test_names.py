"""Weights of the voices that name a thing, fitted by who is right."""

import numpy as np
import pytest

from benchmarks.names import fit, likelihood
from roomkin.stages.perception.classification.propose import Exponents, combine


def test_weights_follow_who_is_right() -> None:
    rng = np.random.default_rng(0)
    right = np.eye(4, dtype=bool)[rng.integers(4, size=400)]
    told = np.where(rng.random((400, 1)) < 0.8, right, np.roll(right, 1, axis=0))
    good, noise = np.where(told, 0.5, 0.5 / 3), rng.dirichlet(np.ones(4), 400)
    said = np.stack([good, noise, *[np.full_like(noise, 0.25)] * 2], axis=1)
    fitted = fit(said, right)
    assert fitted.shape > 1 and abs(fitted.classes) < 0.2
    assert fitted.other == pytest.approx(np.log(3), abs=0.5)  # none is a fourth of them, and counts for half
    assert likelihood(combine(said, fitted), right) > likelihood(combine(said, Exponents(1, 1, 1, 1, 0)), right) + 0.1
