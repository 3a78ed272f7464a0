"""Where the links are: frames, the closed box, and the same thing seen from another root frame."""

from dataclasses import replace

import numpy as np
from trimesh import Trimesh

from stages.articulated.model import JointModel, Matrix, RobotModel, Visual
from stages.geometry.frames import transform_points

SMALLER = 0.9  # share of the volume of the box around all, chosen: handles that turn away make less


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


def shut_where_smallest(robot: RobotModel) -> RobotModel:
    """The model with every joint turned round whose other end makes the whole much smaller: it is drawn open at 0.

    Followers are turned round with what they follow. What was turned is in the remarks.
    """
    for joint in robot.joints:
        if joint.type == "fixed" or joint.follows or joint.part_type == "button":
            continue
        turned = [_shut_at_upper(one) if joint.name in (one.name, one.follows) else one for one in robot.joints]
        other = replace(robot, joints=turned)
        if _volume(other) < SMALLER * _volume(robot):
            where = f"at {joint.upper:.3g}, where the model is smallest, not at {joint.lower:.3g}"
            robot = replace(other, remarks=(*robot.remarks, f"'{joint.name}' is taken to be shut {where}"))
    return robot


def _shut_at_upper(joint: JointModel) -> JointModel:
    """The same joint turned round: shut at 0, which was its upper limit."""
    origin = joint.origin @ joint.motion(joint.upper)
    return replace(joint, origin=origin, axis=-joint.axis, lower=0.0, upper=joint.upper - joint.lower)


def _volume(robot: RobotModel) -> float:
    return float(np.prod(np.ptp(measure_closed_box(robot), axis=0)))


def change_root(robot: RobotModel, new_from_root: Matrix) -> RobotModel:
    """The same thing seen from another root frame (a rigid transform)."""
    root, rotation = robot.links[robot.root], new_from_root[:3, :3]
    turned = replace(root.map_linearly(new_from_root), inertia=rotation @ root.inertia @ rotation.T)
    joints = [replace(j, origin=new_from_root @ j.origin) if j.parent == root.name else j for j in robot.joints]
    return replace(robot, links=robot.links | {root.name: turned}, joints=joints)
