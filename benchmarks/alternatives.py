"""What Open3D replaced, and Open3D in place of what it did not replace: functions with our arguments."""

from collections.abc import Callable
from typing import Any

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import KDTree
from sklearn.cluster import DBSCAN

from stages.geometry.boxes import UprightBox
from stages.geometry.cameras import back_project
from stages.geometry.frames import wrap_angle, yaw_matrix
from stages.geometry.planes import Plane
from stages.matching.crop import View

Points = NDArray[np.float64]


def scipy_inliers(points: Points, neighbours: int, deviations: float) -> NDArray[np.bool_]:
    """As `statistical_inliers`, by a k-d tree of scipy."""
    distances, _ = KDTree(points).query(points, k=neighbours + 1)
    mean = distances[:, 1:].mean(axis=1)
    return mean <= mean.mean() + deviations * mean.std()


def sklearn_dbscan(points: Points, radius: float, min_points: int) -> NDArray[np.int64]:
    """As `dbscan`, by scikit-learn."""
    return DBSCAN(eps=radius, min_samples=min_points).fit_predict(points)


def numpy_farthest(points: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """As `farthest_points`, by numpy: the loop is over the points to choose."""
    x, y, z = np.ascontiguousarray(points.T)
    nearest = np.full(len(points), np.inf, np.float32)
    chosen = np.zeros(count, np.intp)
    for i in range(1, count):
        last = chosen[i - 1]
        dx, dy, dz = x - x[last], y - y[last], z - z[last]
        np.minimum(nearest, dx * dx + dy * dy + dz * dz, out=nearest)
        chosen[i] = nearest.argmax()
    return points[chosen]


# -- Open3D in place of our functions, with the same arguments --------------------------------------------------


def as_cloud(points: NDArray[np.floating]) -> o3d.geometry.PointCloud:
    """Points (N, 3) as Open3D wants them."""
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.asarray(points, dtype=np.float64)))


def open3d_plane(
    points: Points,
    threshold: float,
    iterations: int,
    rng: np.random.Generator,
    plausible: Callable[[Points], NDArray[np.bool_]] | None = None,
    constrained: bool = True,
) -> Plane | None:
    """As `fit_plane`. Open3D asks no normal whether it is plausible: with `constrained`, such planes are taken away."""
    o3d.utility.random.seed(int(rng.integers(2**31)))
    rest = np.arange(len(points))
    for _ in range(5):
        if len(rest) < 3:
            return None
        model, inliers = as_cloud(points[rest]).segment_plane(threshold, 3, iterations)
        normal, offset = np.asarray(model[:3]), -float(model[3])
        if not constrained or plausible is None or plausible(normal[None])[0]:
            return Plane(normal, offset, np.abs(points @ normal - offset) < threshold)
        rest = np.delete(rest, inliers)
    return None


def open3d_free_plane(*args: Any, **options: Any) -> Plane | None:
    """The plane with most points, plausible or not."""
    return open3d_plane(*args, **options, constrained=False)


def open3d_box(points: NDArray[np.floating], trim: float = 0.0) -> UprightBox:
    """As `minimum_box`: Open3D's minimal oriented box of the cloud's outline drawn up to a prism, extents as ours."""
    cloud = np.asarray(points, dtype=np.float64)
    low, high = np.quantile(cloud, [trim, 1 - trim], axis=0)
    inside = cloud[((cloud >= low) & (cloud <= high)).all(axis=1)]
    flat = inside[:, :2] if len(inside) > 3 else cloud[:, :2]
    prism = np.concatenate([np.c_[flat, np.full(len(flat), z)] for z in (0.0, 1.0)])
    axes = np.asarray(as_cloud(prism).get_minimal_oriented_bounding_box(robust=True).R)
    level = axes[:, np.argsort(np.abs(axes[2]))[0]]
    yaw = wrap_angle(float(np.arctan2(level[1], level[0])), np.pi / 2)
    turned = cloud @ yaw_matrix(yaw)
    low, high = np.quantile(turned, [trim, 1 - trim], axis=0)
    return UprightBox(yaw_matrix(yaw) @ ((low + high) / 2), high - low, yaw)


def open3d_normals(view: View, grid: int) -> NDArray[np.float64]:
    """As `patch_normals`: the mean over each patch of Open3D's normals from 30 neighbours, camera frame."""
    assert view.depth is not None and view.intrinsics is not None
    valid = view.mask & (view.depth > 0)
    points = back_project(view.depth, view.intrinsics)[valid]
    cloud = as_cloud(points)
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(30))
    cloud.orient_normals_towards_camera_location(np.zeros(3))
    cell = [index * grid // length for index, length in zip(np.nonzero(valid), valid.shape, strict=True)]
    sums = np.zeros((grid, grid, 3))
    np.add.at(sums, (cell[0], cell[1]), np.asarray(cloud.normals))
    return sums / np.maximum(np.linalg.norm(sums, axis=-1, keepdims=True), 1e-12)
