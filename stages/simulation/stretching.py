"""A parsed asset at another size, in memory: SAPIEN's builder with every extent scaled, as the official code does.

Building it takes milliseconds, as nothing is written and SAPIEN keeps the meshes it has read.
"""

from copy import copy
from typing import Any

import numpy as np
import sapien
from numpy.typing import NDArray

from roomkin.stages.contracts.types import RIGID_TOLERANCE
from roomkin.stages.geometry.frames import quaternion_from_matrix

Array = NDArray[np.float64]

SCALED = ("box", "file", "convex_mesh", "nonconvex_mesh", "multiple_convex_meshes")


def stretch_builder(builder: Any, scale: Array) -> Any | None:
    """A copy of a body's builder, stretched in its closed state along the root's axes by `scale` (3,).

    Shapes, joint frames, sliding ranges, masses and inertias at constant density, as `articulated.stretching` does it
    with files. Angles of hinges stay.

    Returns:
        None if a shape or a slide is askew to the root's axes, so that scaling it would be a shear.
    """
    if not hasattr(builder, "link_builders"):
        return _link(builder, np.diag(scale))
    frames = _find_closed_frames(builder)
    local = [frame.T @ np.diag(scale) @ frame for frame in frames]
    links = []
    for link, A in zip(builder.link_builders, local, strict=True):
        other = _link(link, A)
        joint = _joint(link, A, local[link.parent.index] if link.parent else A)
        if other is None or joint is None:
            return None
        other.joint_record = joint
        links.append(other)
    result = copy(builder)
    result.link_builders = links
    return result


def _find_closed_frames(builder: Any) -> list[Array]:
    """(3, 3) rotation of every link in the root with all joints at their lower limits."""
    frames: list[Array] = []
    for link in builder.link_builders:
        joint = link.joint_record
        turn = np.eye(3)
        if joint.joint_type.startswith("revolute") and len(joint.limits):
            lower = float(np.ravel(joint.limits)[0])
            cos, sin = np.cos(lower), np.sin(lower)
            turn = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
        parent = frames[link.parent.index] if link.parent else np.eye(3)
        frames.append(parent @ _rotation(joint.pose_in_parent) @ turn @ _rotation(joint.pose_in_child).T)
    return frames


def _rotation(pose: sapien.Pose) -> Array:
    return np.asarray(pose.to_transformation_matrix()[:3, :3], dtype=float)


def _move(pose: sapien.Pose, A: Array) -> sapien.Pose:
    return sapien.Pose(A @ np.asarray(pose.p, dtype=float), pose.q)


def _link(link: Any, A: Array) -> Any | None:
    """A link, or a body without joints, under the linear map `A` (3, 3) of its frame."""
    other = copy(link)
    other.collision_records = [_record(record, A) for record in link.collision_records]
    other.visual_records = [_record(record, A) for record in link.visual_records]
    if any(record is None for record in (*other.collision_records, *other.visual_records)):
        return None
    if not link._auto_inertial:
        _weigh(other, A)
    return other


def _record(record: Any, A: Array) -> Any | None:
    """A shape under the linear map `A` (3, 3) of its link's frame; None if that is more than scaling its axes."""
    axes = _rotation(record.pose)
    own = axes.T @ A @ axes
    if record.type not in SCALED or np.abs(own - np.diag(np.diag(own))).max() > RIGID_TOLERANCE * np.abs(own).max():
        return None
    other = copy(record)
    other.scale = tuple((np.asarray(record.scale, dtype=float) * np.diag(own)).tolist())
    other.pose = _move(record.pose, A)
    return other


def _joint(link: Any, A: Array, parent: Array) -> Any | None:
    other = copy(link.joint_record)
    other.pose_in_parent = _move(other.pose_in_parent, parent)
    other.pose_in_child = _move(other.pose_in_child, A)
    if other.joint_type == "prismatic":
        axis = _rotation(other.pose_in_child)[:, 0]
        ratio = float(axis @ A @ axis)
        if np.abs(A @ axis - ratio * axis).max() > RIGID_TOLERANCE:
            return None
        other.limits = (np.asarray(other.limits, dtype=float) * ratio).tolist()
    return other


def _weigh(link: Any, A: Array) -> None:
    """Mass and inertia at constant density, through the second moments of mass."""
    axes = _rotation(link._cmass_local_pose)
    inertia = axes @ np.diag(np.asarray(link._inertia, dtype=float)) @ axes.T
    moments = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    volume = float(np.linalg.det(A))
    moments = volume * A @ moments @ A.T
    values, turned = np.linalg.eigh(np.trace(moments) * np.eye(3) - moments)
    turned[:, 2] *= np.linalg.det(turned)
    center = A @ np.asarray(link._cmass_local_pose.p, dtype=float)
    link._mass, link._inertia = link._mass * volume, np.maximum(values, 1e-9).astype(np.float32)
    link._cmass_local_pose = sapien.Pose(center, quaternion_from_matrix(turned))
