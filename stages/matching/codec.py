"""Smaller feature rows: principal components of the features, learned on the snapshots, one byte for every number.

A row is read back as mean + (codes * steps) @ components, so whatever compares rows need not know. What is lost is
measured in docs/results/matching.md.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError

LEVELS = np.iinfo(np.int8).max
HEADROOM = 1.1  # numbers beyond this times the largest one of the sample are cut off; chosen


class Codec(NamedTuple):
    """mean (D,), orthonormal components (K, D), steps (K,) of the codes."""

    mean: NDArray[np.float32]
    components: NDArray[np.float32]
    steps: NDArray[np.float32]

    def encode(self, rows: NDArray[np.floating]) -> NDArray[np.int8]:
        """Codes (P, K) of rows (P, D)."""
        codes = ((rows.astype(np.float32) - self.mean) @ self.components.T) / self.steps
        return np.clip(np.round(codes), -LEVELS, LEVELS).astype(np.int8)

    def decode(self, codes: NDArray[np.int8]) -> NDArray[np.float32]:
        """Rows (P, D) of codes (P, K)."""
        rows = self.mean + (codes * self.steps) @ self.components
        return rows.astype(np.float32, copy=False)


def learn(sample: NDArray[np.floating], dimensions: int, kept: int) -> Codec:
    """A codec from sample rows (N, D): `dimensions` principal components, and the last `kept` columns as they are.

    Raises:
        InputError: the rows have no more columns than that.
    """
    features = sample.shape[1] - kept
    if dimensions >= features:
        what = f"{dimensions}: features have {features} numbers."
        raise InputError("matching.dimensions", what, "0: no compression", code="E-FEATURE-DIMENSIONS")
    rows = sample.astype(np.float64)
    mean = rows.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov(rows[:, :features].T))  # smallest first
    components = np.zeros((dimensions + kept, sample.shape[1]))
    components[:dimensions, :features] = axes[:, ::-1][:, :dimensions].T
    components[dimensions:, features:] = np.eye(kept)
    largest = np.abs((rows - mean) @ components.T).max(axis=0)
    steps = np.maximum(HEADROOM * largest, 1e-6) / LEVELS
    return Codec(mean.astype(np.float32), components.astype(np.float32), steps.astype(np.float32))
