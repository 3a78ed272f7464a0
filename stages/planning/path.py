"""Paths of the hand: straight lines, the path that opens or closes a joint, and pursuit of a path by progress."""

import itertools
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.stages.simulation.kinematics import Array, pose_error
from roomkin.stages.simulation.target import Target

ANGLE_WEIGHT = 0.15  # metres that a radian counts for in the length of a path; chosen
POSE_SPACING = 0.005  # metres between the poses of a path, in that length; chosen


def measure_distance(a: Array, b: Array) -> Array:
    """(N,) path length between poses (N, 4, 4): metres, with radians at `ANGLE_WEIGHT`."""
    error = pose_error(a, b)
    return np.asarray(np.linalg.norm(error[:, :3], axis=1) + ANGLE_WEIGHT * np.linalg.norm(error[:, 3:], axis=1))


def make_line(start: Array, end: Array) -> Array:
    """(K, 4, 4) poses from `start` to `end`, both included; rotation about one axis."""
    count = max(2, 1 + int(np.ceil(measure_distance(start[None], end[None])[0] / POSE_SPACING)))
    error = pose_error(end[None], start[None])[0]
    fraction = np.linspace(0, 1, count)[:, None]
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 3] = start[:3, 3] + fraction * error[:3]
    poses[:, :3, :3] = Rotation.from_rotvec(fraction * error[3:]).as_matrix() @ start[:3, :3]
    return poses


def join_lines(way: Sequence[Array]) -> Array:
    """(K, 4, 4) poses straight from each pose to the next one."""
    legs = [make_line(a, b) for a, b in itertools.pairwise(way)]
    return np.concatenate([legs[0], *[leg[1:] for leg in legs[1:]]])


def make_handle_path(target: Target, grasp: Array, start: float, goal: float, follow: float) -> Array:
    """(K, 4, 4) poses of a hand that holds the handle while the joint goes from `start` to `goal`, asset frame.

    Args:
        grasp: (4, 4) pose of the hand when the joint is closed.
        follow: share of the door's rotation that the hand makes; at 0 the handle turns between the fingers.
    """
    ends = target.motions(np.array([start, goal])) @ grasp
    count = max(2, 1 + int(np.ceil(measure_distance(ends[:1], ends[1:])[0] / POSE_SPACING)))
    values = np.linspace(start, goal, count)
    poses = target.motions(values) @ grasp
    if target.revolute:
        turns = Rotation.from_rotvec(follow * (values - target.lower)[:, None] * target.axis)
        poses[:, :3, :3] = turns.as_matrix() @ grasp[:3, :3]
    return np.asarray(poses)


class Pursuit:
    """Follows a path by progress: aims at the pose `lookahead` past the nearest one, never backwards.

    Aiming by progress and not by time keeps the aim on the arc when the hand lags behind; an aim that runs ahead
    cuts the arc of a door and pulls the handle out of the fingers.
    """

    def __init__(self, path: Array, lookahead: float) -> None:
        self.path = path
        steps = measure_distance(path[1:], path[:-1])
        self.length = np.concatenate([[0.0], np.cumsum(steps)])
        self.lookahead = lookahead
        self.nearest = 0

    def aim(self, pose: Array) -> Array:
        """(4, 4) pose to move to from `pose`."""
        window = self.path[self.nearest : self.nearest + 1 + int(2 * self.lookahead / POSE_SPACING)]
        gaps = measure_distance(window, np.broadcast_to(pose, window.shape))
        self.nearest += int(gaps.argmin())
        ahead = np.searchsorted(self.length, self.length[self.nearest] + self.lookahead)
        return np.asarray(self.path[min(int(ahead), len(self.path) - 1)])

    @property
    def progress(self) -> float:
        """Length of the path already behind the hand."""
        return float(self.length[self.nearest])

    @property
    def left(self) -> float:
        """Length of the path still ahead of the hand."""
        return float(self.length[-1]) - self.progress
