"""A URDF in memory with its meshes: what importing and stretching work on. Metres; link frames as in the URDF."""

from dataclasses import dataclass, field, replace

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Trimesh

from stages.geometry.frames import apply, rigid

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """A body: visual meshes and convex collision pieces in its own frame, mass, centre of mass, inertia about it."""

    name: str
    visuals: list[Trimesh]
    collisions: list[Trimesh]
    mass: float
    center: Matrix
    inertia: Matrix


@dataclass(frozen=True)
class JointModel:
    """A joint (fixed, revolute or prismatic). `origin` is parent_from_child, 4x4, at position 0; closed at `lower`."""

    name: str
    type: str
    parent: str
    child: str
    origin: Matrix
    axis: Matrix
    lower: float = 0.0
    upper: float = 0.0


@dataclass(frozen=True)
class RobotModel:
    """Links and joints; the root is the one link that is no joint's child."""

    name: str
    links: dict[str, Link]
    joints: list[JointModel] = field(default_factory=list)

    @property
    def root(self) -> str:
        """Name of the root link."""
        children = {joint.child for joint in self.joints}
        return next(name for name in self.links if name not in children)


def link_frames(robot: RobotModel, opened: float = 0.0) -> dict[str, Matrix]:
    """root_from_link, 4x4, of every link, every joint at `opened` of its range (0: closed)."""
    frames = {robot.root: np.eye(4)}
    waiting = list(robot.joints)
    while waiting:
        ready = [joint for joint in waiting if joint.parent in frames]
        for joint in ready:
            value = joint.lower + opened * (joint.upper - joint.lower)
            frames[joint.child] = frames[joint.parent] @ joint.origin @ motion(joint, value)
        waiting = [joint for joint in waiting if joint not in ready]
    return frames


def motion(joint: JointModel, value: float) -> Matrix:
    """Transform of the child in the joint frame at a joint position."""
    if joint.type == "revolute":
        return np.asarray(trimesh.transformations.rotation_matrix(value, joint.axis))
    if joint.type == "prismatic":
        return rigid(np.eye(3), value * joint.axis)
    return np.eye(4)


def closed_box(robot: RobotModel) -> Matrix:
    """Lowest and highest corner (2, 3), in the root frame, of all that is visible, every joint closed."""
    frames = link_frames(robot)
    points = [apply(frames[link.name], mesh.vertices) for link in robot.links.values() for mesh in link.visuals]
    corners = np.concatenate(points)
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def rebased(robot: RobotModel, new_from_root: Matrix) -> RobotModel:
    """The same thing seen from another root frame (a rigid transform)."""
    root = robot.links[robot.root]
    rotation = new_from_root[:3, :3]
    links = robot.links | {
        root.name: replace(
            root,
            visuals=[moved(mesh, new_from_root) for mesh in root.visuals],
            collisions=[moved(mesh, new_from_root) for mesh in root.collisions],
            center=apply(new_from_root, root.center),
            inertia=rotation @ root.inertia @ rotation.T,
        )
    }
    joints = [replace(j, origin=new_from_root @ j.origin) if j.parent == root.name else j for j in robot.joints]
    return replace(robot, links=links, joints=joints)


def stretched(robot: RobotModel, scale: tuple[float, float, float]) -> RobotModel:
    """The closed thing stretched along the root's axes: meshes, joint origins, sliding directions and ranges, and
    masses and inertias at constant density. Angles of hinges stay."""
    S = np.diag(np.asarray(scale, dtype=float))
    frames = link_frames(robot)
    local = {name: frame[:3, :3].T @ S @ frame[:3, :3] for name, frame in frames.items()}
    links = {name: _stretched_link(link, local[name]) for name, link in robot.links.items()}
    joints = []
    for joint in robot.joints:
        # the child's closed frame keeps its rotation and its origin is stretched; take the closed motion off again
        closed = motion(joint, joint.lower)
        parent_from_child = joint.origin @ closed
        parent_from_child[:3, 3] = local[joint.parent] @ parent_from_child[:3, 3]
        if joint.type == "prismatic":
            slide = local[joint.child] @ joint.axis
            ratio = float(np.linalg.norm(slide))
            joint = replace(joint, axis=slide / ratio, lower=joint.lower * ratio, upper=joint.upper * ratio)
        origin = parent_from_child @ np.linalg.inv(motion(joint, joint.lower))
        joints.append(replace(joint, origin=origin))
    return replace(robot, links=links, joints=joints)


def _stretched_link(link: Link, A: Matrix) -> Link:
    """A link under a linear map of its frame; inertia through the second moments of mass."""
    transform = rigid(A, np.zeros(3))
    volume = abs(float(np.linalg.det(A)))
    moments = 0.5 * np.trace(link.inertia) * np.eye(3) - link.inertia
    moments = volume * A @ moments @ A.T
    return replace(
        link,
        visuals=[moved(mesh, transform) for mesh in link.visuals],
        collisions=[moved(mesh, transform) for mesh in link.collisions],
        mass=link.mass * volume,
        center=A @ link.center,
        inertia=np.trace(moments) * np.eye(3) - moments,
    )


def moved(mesh: Trimesh, transform: Matrix) -> Trimesh:
    """A transformed copy, with its looks."""
    copy = mesh.copy()
    copy.apply_transform(transform)
    return copy
