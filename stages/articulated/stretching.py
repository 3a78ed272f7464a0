"""An articulation at another size: every extent scaled by its own factor, at constant density."""

from dataclasses import replace

import numpy as np

from roomkin.stages.articulated.forward_kinematics import link_frames
from roomkin.stages.articulated.model import Link, Matrix, RobotModel
from roomkin.stages.geometry.frames import make_transform


def stretch_model(robot: RobotModel, scale: tuple[float, float, float]) -> RobotModel:
    """The closed thing stretched along the root's axes: meshes, joint origins, sliding directions and ranges, and
    masses and inertias at constant density. Angles of hinges stay."""
    stretch = np.diag(np.asarray(scale, dtype=float))
    frames = link_frames(robot)
    local = {name: frame[:3, :3].T @ stretch @ frame[:3, :3] for name, frame in frames.items()}
    links = {name: _stretched_link(link, local[name]) for name, link in robot.links.items()}
    joints = []
    for joint in robot.joints:
        # the child's closed frame keeps its rotation and its origin is stretched; take the closed motion off again
        parent_from_child = joint.origin @ joint.motion(joint.lower)
        parent_from_child[:3, 3] = local[joint.parent] @ parent_from_child[:3, 3]
        if joint.type == "prismatic":
            slide = local[joint.child] @ joint.axis
            ratio = float(np.linalg.norm(slide))
            joint = replace(joint, axis=slide / ratio, lower=joint.lower * ratio, upper=joint.upper * ratio)
        origin = parent_from_child @ np.linalg.inv(joint.motion(joint.lower))
        joints.append(replace(joint, origin=origin))
    return replace(robot, links=links, joints=joints)


def _stretched_link(link: Link, A: Matrix) -> Link:
    """A link under a linear map of its frame; inertia through the second moments of mass."""
    volume = abs(float(np.linalg.det(A)))
    moments = 0.5 * np.trace(link.inertia) * np.eye(3) - link.inertia
    moments = volume * A @ moments @ A.T
    inertia = np.trace(moments) * np.eye(3) - moments
    return replace(link.map_linearly(make_transform(A, np.zeros(3))), mass=link.mass * volume, inertia=inertia)
