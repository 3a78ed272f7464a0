"""Extents of a cloud along given axes: where its faces are, not where its noise ends."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d
from trimesh import Trimesh

from stages.contracts.objects import DepthError
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

BIN, SMOOTHING = 0.005, 0.015  # metres; densities are smoothed by half the noise as well
PROMINENT = 2.0  # a face is where points lie so many times denser than on average
NEAR, REACH = 0.015, 3.0  # metres, standard deviations: how far the outermost points may lie before their face
FAINT, THICK = 0.05, 4.5  # metres of noise; standard deviations in which nine of ten points of a face lie, and some
FRONT = 0.3  # least share of its outline that a front fills
STEEP = 0.35  # sine of the least angle from which a top is seen
LEVEL, SLICES, FILLED = 0.12, 6, 0.3  # share of the height that is the top; parts of its depth; least share in each
MEASURED = 6.0  # standard deviations: what is no deeper is noise
OUTSIDE, MOST = 0.7, 0.25  # standard deviations by which noise moves an end that is no face; share of the length


def near_face(values: NDArray[np.float64], sign: float, noise: float, trim: float) -> float | None:
    """Where the face is on the side `sign` (1: high, -1: low) of an axis; None if the points have none there.

    Many points lie at one coordinate, spread by the noise of depth, and the outermost ones are two or three
    standard deviations in front of it. A face is where the points are densest, not far behind their end.

    Args:
        values: (N,) coordinates.
        noise: standard deviation of their noise, metres.
        trim: share of the points left out before their end.
    """
    inward = -sign * values  # grows into the object
    low, high = np.quantile(inward, [trim, 1 - trim])
    bins = int((high - low) / BIN)
    if bins < 2:
        return None
    counts, edges = np.histogram(inward, bins, (low, high))
    density = gaussian_filter1d(counts.astype(float), max(SMOOTHING, noise / 2) / BIN, mode="constant")
    outer = density[: max(1, min(bins // 2, int(max(NEAR, REACH * noise) / BIN)))]
    peak = int(np.argmax(outer))
    if outer[peak] < PROMINENT * len(values) / bins:
        return None
    return float(-sign * (edges[peak] + edges[peak + 1]) / 2)


def beyond_front(meshes: Sequence[Trimesh]) -> float:
    """Metres by which a model's box reaches beyond the face that its front shows: its handles, the foot of a screen.

    That face is where most of what faces +x lies, in the front half, and it is what `near_face` finds of the object.
    """
    bounds = np.array([mesh.bounds for mesh in meshes])
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    depths = high[0] - np.concatenate([mesh.triangles_center[:, 0] for mesh in meshes])
    areas = np.concatenate([mesh.area_faces * np.clip(mesh.face_normals[:, 0], 0, None) for mesh in meshes])
    half = (high[0] - low[0]) / 2
    counts, edges = np.histogram(depths, max(1, round(half / BIN)), (0, half), weights=areas)
    peak = int(np.argmax(counts))
    if counts[peak] < FRONT * np.prod((high - low)[1:]):
        return 0.0
    return float(np.average(depths, weights=areas * (depths >= edges[peak]) * (depths <= edges[peak + 1])))


def only_noise(cloud: NDArray[np.floating], normal: ArrayLike, camera: ArrayLike, depth_error: DepthError) -> bool:
    """Whether the cloud (N, 3) is no thicker along a wall's normal than one face far away is made by noise."""
    ray = np.mean(cloud, axis=0) - np.asarray(camera, dtype=float)
    distance = float(np.linalg.norm(ray))
    noise = abs(float(ray @ np.asarray(normal, dtype=float))) / distance * depth_error.at(distance)
    low, high = np.quantile(np.asarray(cloud, dtype=float) @ np.asarray(normal, dtype=float), [0.05, 0.95])
    return bool(noise > FAINT and high - low < THICK * noise)


def top_seen(cloud: NDArray[np.floating], box: UprightBox, camera: ArrayLike, depth_error: DepthError) -> bool:
    """Whether the object's top is seen from its front edge to its rear one, so that its depth is measured.

    Args:
        cloud: (N, 3) in the floor frame.
        box: measured, along the asset's axes.
        camera: its position, floor frame.
        depth_error: of the cloud's depth.
    """
    ray = np.asarray(box.center, dtype=float) - np.asarray(camera, dtype=float)
    distance, size = float(np.linalg.norm(ray)), np.asarray(box.size, dtype=float)
    if ray[2] + size[2] / 2 > -STEEP * distance:
        return False
    noise = depth_error.at(distance)
    local = (np.asarray(cloud, dtype=float) - box.center) @ yaw_matrix(box.yaw)
    axis = int(np.argmax(np.abs(ray[:2] @ yaw_matrix(box.yaw)[:2, :2])))
    on_top = local[local[:, 2] > size[2] / 2 - max(LEVEL * size[2], 2 * noise), axis]
    if size[axis] < MEASURED * noise or len(on_top) < 10 * SLICES:
        return False
    counts, _ = np.histogram(on_top, SLICES, (-size[axis] / 2, size[axis] / 2))
    return bool(counts.min() > FILLED * counts.mean())


def measured_box(
    cloud: NDArray[np.floating],
    box: UprightBox,
    yaw: float,
    camera: ArrayLike,
    trim: float,
    depth_error: DepthError | None,
    beyond: float = 0.0,
    flat: bool = True,
) -> UprightBox:
    """The object's box along axes turned by `yaw`, its heights those of `box`, which reaches down to the support.

    Args:
        cloud: (N, 3) in the floor frame.
        box: the minimum box that extraction found.
        camera: its position, floor frame.
        trim: share of the points left out at an end.
        depth_error: of the cloud's depth, along the line of sight; None: ends are quantiles, as in the paper.
        beyond: metres by which the model's box reaches beyond the face that it shows towards +x (`beyond_front`).
        flat: it has faces; what is round has none, and its near end is where its points end.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    points = np.asarray(cloud, dtype=float)[:, :2] @ turn
    limits = np.quantile(points, [trim, 1 - trim], axis=0)
    if depth_error is not None:
        ray = center - np.asarray(camera, dtype=float)
        distance = float(np.linalg.norm(ray))
        for axis, along in enumerate((ray[:2] @ turn) / distance):
            noise = abs(along) * depth_error.at(distance)
            inset = min(OUTSIDE * noise, MOST * float(np.ptp(limits[:, axis])))
            limits[:, axis] += [inset, -inset]
            near = 1 if along < 0 else 0
            face = near_face(points[:, axis], 2 * near - 1, noise, trim) if flat else None
            if face is not None:
                limits[near, axis] = face + (beyond if axis == 0 and near == 1 else 0.0)
    limits.sort(axis=0)
    center[:2] = turn @ limits.mean(axis=0)
    size[:2] = limits[1] - limits[0]
    return UprightBox(center, size, yaw)
