"""Where the links are: frames, the closed box, and the same thing seen from another root frame."""

from dataclasses import replace

import numpy as np
from trimesh import Trimesh

from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel, Visual
from roomkin.stages.geometry.frames import transform_points


def link_frames(robot: RobotModel, opened: float = 0.0) -> dict[str, Matrix]:
    """root_from_link, 4x4, of every link, every joint at `opened` of its range (0: closed)."""
    return frames_of(robot.root, robot.joints, opened)


def frames_of(root: str, joints: list[JointModel], opened: float = 0.0) -> dict[str, Matrix]:
    """`link_frames` from the joints alone, parents before children."""
    frames = {root: np.eye(4)}
    for joint in joints:
        value = joint.lower + opened * (joint.upper - joint.lower)
        frames[joint.child] = frames[joint.parent] @ joint.origin @ joint.motion(value)
    return frames


def list_collisions(robot: RobotModel) -> list[Trimesh]:
    """The convex pieces that collide, in the root frame, every joint closed."""
    frames = link_frames(robot)
    return [
        piece.copy().apply_transform(frames[link.name]) for link in robot.links.values() for piece in link.collisions
    ]


def visual_bounds(visuals: list[Visual], frame: Matrix) -> Matrix | None:
    """Lowest and highest corner (2, 3) of what is seen of a link that stands at `frame`; None if that is nothing."""
    if not visuals:
        return None
    corners = np.concatenate([transform_points(frame, visual.mesh.vertices) for visual in visuals])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def measure_closed_box(robot: RobotModel) -> Matrix:
    """Lowest and highest corner (2, 3), in the root frame, of all that is visible, every joint closed."""
    frames = link_frames(robot)
    boxes = (visual_bounds(link.visuals, frames[link.name]) for link in robot.links.values())
    corners = np.concatenate([box for box in boxes if box is not None])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def change_root(robot: RobotModel, new_from_root: Matrix) -> RobotModel:
    """The same thing seen from another root frame (a rigid transform)."""
    root, rotation = robot.links[robot.root], new_from_root[:3, :3]
    turned = replace(root.map_linearly(new_from_root), inertia=rotation @ root.inertia @ rotation.T)
    joints = [replace(j, origin=new_from_root @ j.origin) if j.parent == root.name else j for j in robot.joints]
    return replace(robot, links=robot.links | {root.name: turned}, joints=joints)
