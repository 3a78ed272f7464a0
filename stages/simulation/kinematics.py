"""Forward kinematics and damped-least-squares IK of a serial arm, batched over configurations.

The controller that executes an action and the planner that rolls a candidate out call the same `track`,
so that what was planned is what happens.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.urdf_tree import UrdfTree
from roomkin.stages.contracts.errors import InputError

Array = NDArray[np.float64]

IK_DAMPING = 0.03  # of the least squares: 3 cm or 0.03 rad of task space per radian; chosen
LIMIT_MARGIN = 0.02  # radians kept to every joint limit; chosen
MAX_JOINT_STEP = 0.25  # radians in one iteration; chosen


@dataclass(frozen=True)
class Chain:
    """A chain of revolute joints about their local z axes.

    origins: (J, 4, 4) joint frame in the frame of the joint before it; tip: (4, 4) end effector in the last one.
    lower, upper: (J,) limits in radians.
    """

    origins: Array
    tip: Array
    lower: Array
    upper: Array

    def frames(self, q: Array) -> Array:
        """(N, J) joints -> (N, J + 1, 4, 4) poses of the joint frames and, last, of the end effector, in the base."""
        count, joints = q.shape
        turn = np.zeros((count, joints, 4, 4))
        cos, sin = np.cos(q), np.sin(q)
        turn[:, :, 0, 0], turn[:, :, 0, 1] = cos, -sin
        turn[:, :, 1, 0], turn[:, :, 1, 1] = sin, cos
        turn[:, :, 2, 2] = turn[:, :, 3, 3] = 1.0
        steps = self.origins @ turn
        result = np.empty((count, joints + 1, 4, 4))
        result[:, 0] = steps[:, 0]
        for joint in range(1, joints):
            result[:, joint] = result[:, joint - 1] @ steps[:, joint]
        result[:, joints] = result[:, joints - 1] @ self.tip
        return result

    def pose(self, q: Array) -> Array:
        """(N, J) joints -> (N, 4, 4) end-effector poses in the base."""
        return self.frames(q)[:, -1]

    def margin(self, q: Array) -> Array:
        """(N, J) joints -> (N, J) radians to the nearer limit."""
        return np.minimum(q - self.lower, self.upper - q)


def jacobian(frames: Array) -> Array:
    """(N, J + 1, 4, 4) frames -> (N, 6, J) geometric Jacobian: velocity, then angular velocity, base axes."""
    axes = frames[:, :-1, :3, 2]
    arms = frames[:, -1:, :3, 3] - frames[:, :-1, :3, 3]
    (a, b, c), (x, y, z) = axes.transpose(2, 0, 1), arms.transpose(2, 0, 1)
    result = np.empty((*axes.shape[:2], 6))  # np.cross takes twice as long
    result[..., 0], result[..., 1], result[..., 2] = b * z - c * y, c * x - a * z, a * y - b * x
    result[..., 3:] = axes
    return result.transpose(0, 2, 1)


def pose_error(target: Array, pose: Array) -> Array:
    """(N, 6) translation and rotation vector, base axes, that take `pose` (N, 4, 4) to `target` (N, 4, 4)."""
    turn = target[:, :3, :3] @ pose[:, :3, :3].transpose(0, 2, 1)
    return np.concatenate(
        [target[:, :3, 3] - pose[:, :3, 3], Rotation.from_matrix(turn, assume_valid=True).as_rotvec()], axis=1
    )


def track(chain: Chain, q: Array, target: Array, iterations: int = 3) -> Array:
    """Joints near `q` (N, J) that bring the end effector towards `target` (N, 4, 4).

    Damped least squares (Nakamura & Hanafusa 1986) from `q`: the minimum-norm step, clamped to the joint limits.
    A pose out of reach is approached.
    """
    lower, upper = chain.lower + LIMIT_MARGIN, chain.upper - LIMIT_MARGIN
    for _ in range(iterations):
        frames = chain.frames(q)
        J = jacobian(frames)
        error = pose_error(target, frames[:, -1])
        gram = J @ J.transpose(0, 2, 1) + IK_DAMPING**2 * np.eye(6)
        step = (J.transpose(0, 2, 1) @ np.linalg.solve(gram, error[..., None]))[..., 0]
        largest = np.abs(step).max(axis=1, keepdims=True)
        q = np.clip(q + step * np.minimum(1.0, MAX_JOINT_STEP / np.maximum(largest, 1e-9)), lower, upper)
    return q


def read_chain(urdf: Path, tip: str) -> Chain:
    """The chain from the root of a URDF to the link `tip`; fixed joints are folded into their neighbours.

    Raises:
        InputError: the URDF is broken, or no hinge moves `tip`.
    """
    joints = {joint.child: joint for joint in UrdfTree(urdf).joints}
    end = tip
    path = []
    while tip in joints:
        path.append(joints[tip])
        tip = joints[tip].parent
    origins, limits, offset = [], [], np.eye(4)
    for joint in reversed(path):
        offset = offset @ joint.origin
        if joint.type == "revolute":
            origins.append(offset)
            limits.append([joint.lower, joint.upper])
            offset = np.eye(4)
    if not origins:
        raise InputError(urdf, f"has no hinge that moves a link '{end}'.", code="E-ARM-HINGES")
    lower, upper = np.array(limits).T
    return Chain(np.array(origins), offset, lower, upper)
