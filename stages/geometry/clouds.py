"""Point clouds as (N, 3) arrays, by Open3D: outliers, clusters, farthest points. Same points, same answer.

What Open3D does not do as well as this project's own code (planes, upright boxes, patch normals): docs/extraction.md.
"""

import numpy as np
import open3d as o3d
from numpy.typing import NDArray


def _open3d_cloud(points: NDArray[np.floating]) -> o3d.geometry.PointCloud:
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.asarray(points, dtype=np.float64)))


def statistical_inliers(points: NDArray[np.floating], neighbours: int, deviations: float) -> NDArray[np.bool_]:
    """Mask (N,) of the points whose mean distance to their neighbours is below the cloud's mean of it
    plus `deviations` standard deviations.
    """
    if len(points) <= neighbours:
        return np.ones(len(points), dtype=bool)
    _, kept = _open3d_cloud(points).remove_statistical_outlier(neighbours + 1, deviations)  # it counts the point itself
    mask = np.zeros(len(points), dtype=bool)
    mask[np.asarray(kept, dtype=int)] = True
    return mask


def dbscan(points: NDArray[np.floating], radius: float, min_points: int) -> NDArray[np.int32]:
    """Cluster (N,) of each point by DBSCAN (Ester et al. 1996), -1 for noise."""
    return np.asarray(_open3d_cloud(points).cluster_dbscan(radius, min_points), dtype=np.int32)


def farthest_points(points: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """(N, 3 or 4) -> (count, 3 or 4) by farthest point sampling from the first point on, in the cloud's order.

    A fourth column goes with its point. Points are repeated if N is smaller; an empty cloud gives zeros.
    """
    if len(points) == 0:
        return np.zeros((count, points.shape[1]), np.float32)
    if len(points) <= count:
        return points[np.resize(np.arange(len(points)), count)]
    cloud = _open3d_cloud(points[:, :3])
    if points.shape[1] == 4:  # Open3D keeps colors with their points
        cloud.colors = o3d.utility.Vector3dVector(np.repeat(points[:, 3:].astype(np.float64), 3, axis=1))
    chosen = cloud.farthest_point_down_sample(count)
    columns = (np.asarray(chosen.points), np.asarray(chosen.colors)[:, :1])
    return np.concatenate(columns if points.shape[1] == 4 else columns[:1], axis=1).astype(np.float32)
