"""Point clouds as (N, 3) arrays, by Open3D: outliers, clusters, farthest points, the upright minimum box (paper A.7).

What Open3D does not do as well as this project's own code (planes, upright boxes, patch normals): docs/extraction.md.
"""

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import SAMPLED, wrap_angle, yaw_matrix


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


COARSE_STEP = np.deg2rad(1.0)
FINE_STEP = np.deg2rad(0.1)
AREA_TIE = 1.1  # times the smallest footprint, up to which points on the sides decide; chosen
SIDE_CLIP = 0.05  # metres, beyond which a point says nothing about a side; chosen


def _extents(points: NDArray[np.float64], yaw: float, trim: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points in the axes turned by `yaw`, and their (2, d) trimmed bounds."""
    turned = points @ yaw_matrix(yaw)[: points.shape[1], : points.shape[1]]
    return turned, np.quantile(turned, [trim, 1 - trim], axis=0)


def _area_and_misfit(points: NDArray[np.float64], yaw: float, trim: float) -> tuple[float, float]:
    """Footprint area, and mean distance of the points to the nearest side of the footprint."""
    turned, (low, high) = _extents(points, yaw, trim)
    to_side = np.minimum(np.abs(turned - low), np.abs(turned - high)).min(axis=1)
    return float(np.prod(high - low)), float(np.minimum(to_side, SIDE_CLIP).mean())


def _best_yaw(points: NDArray[np.float64], yaws: NDArray[np.float64], trim: float) -> float:
    """The yaw of the smallest footprint; near-ties go to the one whose sides the points lie on.

    A box of which two side faces are seen gives an L from above, and the smallest rectangle around
    an L is not unique: the one along its hypotenuse has exactly the same area.
    """
    areas, misfits = np.array([_area_and_misfit(points, yaw, trim) for yaw in yaws]).T
    tied = areas <= AREA_TIE * areas.min() + 1e-9
    return float(yaws[tied][np.argmin(misfits[tied])])


def minimum_box(points: NDArray[np.floating], trim: float = 0.0) -> UprightBox:
    """The z-aligned box with the smallest footprint that holds the points (N, 3).

    Args:
        points: cloud in a frame with z up, at least one point.
        trim: fraction of the points left out at either end of each box axis, so that a few
            stray points do not decide the extents. 0: the true bounding box.

    Returns:
        the box, with yaw in (-pi/4, pi/4]: its x axis is the side nearest to the frame's x axis.
    """
    cloud = np.asarray(points, dtype=np.float64)
    plan = cloud[:: max(1, len(cloud) // SAMPLED), :2]
    yaw = _best_yaw(plan, np.arange(-np.pi / 4 + COARSE_STEP, np.pi / 4 + COARSE_STEP / 2, COARSE_STEP), trim)
    yaw = _best_yaw(plan, yaw + np.arange(-COARSE_STEP, COARSE_STEP + FINE_STEP / 2, FINE_STEP), trim)
    yaw = wrap_angle(yaw, np.pi / 2)
    _, (low, high) = _extents(cloud, yaw, trim)
    return UprightBox(yaw_matrix(yaw) @ ((low + high) / 2), high - low, yaw)
