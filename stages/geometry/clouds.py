"""Point clouds as (N, 3) arrays: outlier removal."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree


def statistical_inliers(points: NDArray[np.floating], neighbours: int, deviations: float) -> NDArray[np.bool_]:
    """Mask (N,) of the points whose mean distance to their neighbours is at most the cloud's mean of it
    plus `deviations` standard deviations.
    """
    if len(points) <= neighbours:
        return np.ones(len(points), dtype=bool)
    distances, _ = KDTree(points).query(points, k=neighbours + 1)
    mean = distances[:, 1:].mean(axis=1)
    return mean <= mean.mean() + deviations * mean.std()
