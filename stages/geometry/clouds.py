"""Point clouds as (N, 3) arrays: down-sampling and outlier removal."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree


def voxel_downsample(points: NDArray[np.floating], size: float) -> NDArray[np.intp]:
    """Indices (M,) of one point per occupied voxel of edge `size` metres: the first one in order, ascending."""
    keys = np.floor(np.asarray(points) / size).astype(np.int64)
    _, first = np.unique(keys, axis=0, return_index=True)
    return np.sort(first)


def farthest_point_sample(points: NDArray[np.floating], count: int, start: int = 0) -> NDArray[np.intp]:
    """Indices (min(count, N),) of farthest point sampling from `start`: each next point is the one
    farthest from all chosen before (ties: the lowest index).
    """
    coordinates = np.ascontiguousarray(np.asarray(points, dtype=np.float32).T)
    count = min(count, coordinates.shape[1])
    chosen = np.empty(count, dtype=np.intp)
    nearest = np.full(coordinates.shape[1], np.inf, dtype=np.float32)
    step = np.empty_like(coordinates)
    index = start
    for k in range(count):
        chosen[k] = index
        np.subtract(coordinates, coordinates[:, index : index + 1], out=step)
        np.minimum(nearest, np.einsum("ij,ij->j", step, step), out=nearest)
        index = int(nearest.argmax())
    return chosen


def statistical_inliers(points: NDArray[np.floating], neighbours: int, deviations: float) -> NDArray[np.bool_]:
    """Mask (N,) of the points whose mean distance to their neighbours is at most the cloud's mean of it
    plus `deviations` standard deviations.
    """
    if len(points) <= neighbours:
        return np.ones(len(points), dtype=bool)
    distances, _ = KDTree(points).query(points, k=neighbours + 1)
    mean = distances[:, 1:].mean(axis=1)
    return mean <= mean.mean() + deviations * mean.std()
