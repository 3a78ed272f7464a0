"""Plans the Open skill (paper A.4): grasps are rolled out through the very IK that will execute them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from stages.config.demonstrations import DemonstrationsConfig
from stages.geometry.frames import inverse, rigid
from stages.simulation.handle import Handle
from stages.simulation.kinematics import Array, Chain, pose_error, track
from stages.simulation.robot import GRIPPER_OPEN
from stages.simulation.target import Target
from stages.skills.clearance import Surroundings, arm_spheres
from stages.skills.path import distance, opening, straight

ROLLOUT_STEP = 0.03  # path length between rolled-out poses
POSITION_TOLERANCE, ROTATION_TOLERANCE = 0.01, 0.1  # metres and radians the rollout may miss a pose by
FINGERTIP = 0.0145  # pad centre to fingertip, and 5 mm of air between fingertip and panel
MAX_DEPTH = 0.009  # pad centre behind the foremost surface: pads of 18 mm then cover a bar


@dataclass(frozen=True)
class Plan:
    """Paths of the hand in the robot base frame, (K, 4, 4) each."""

    approach: Array
    converge: Array
    articulate: Array
    goal: float  # joint value to reach


@dataclass(frozen=True)
class Grasp:
    """A way to hold a handle: turn of the approach about the closing axis, and the share of a door's turn to make."""

    tilt: float
    follow: float


def grasps(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates, the preferred ones first: always the same order, so that demonstrations look alike."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    tilts = (0.7, 1.0, 0.35, 0.0) if upright else (0.0, 0.35, -0.35, 0.7, -0.7)
    for follow in (1.0, 0.5, 0.0) if target.revolute else (1.0,):
        for tilt in tilts:
            yield Grasp(tilt, follow)


def grasp_pose(handle: Handle, tilt: float, hand: Array) -> Array:
    """(4, 4) pose of the tool centre point on a handle, asset frame.

    The fingers close across the handle's long direction (sideways on a knob), of the two ways the one nearer to
    the present pose `hand` (4, 4). `tilt` raises the wrist (for a horizontal bar: turns it sideways).
    """
    closing = np.array([0.0, 1.0, 0.0])
    if handle.elongated:
        closing = np.cross(handle.axis, [1.0, 0.0, 0.0])
    if closing @ hand[:3, 1] < 0:
        closing = -closing
    straight_in = np.array([-1.0, 0.0, 0.0])
    up = np.cross(closing, straight_in)
    lift = np.sign(up[2]) if abs(up[2]) > 0.5 else 1.0
    approach = Rotation.from_rotvec(-closing * tilt * lift).apply(straight_in)
    depth = float(np.clip(handle.protrusion - FINGERTIP, 0.0, MAX_DEPTH))
    rotation = np.stack([np.cross(closing, approach), closing, approach], axis=1)
    return rigid(rotation, handle.position + depth * straight_in)


def plan_open(
    chain: Chain,
    joints: Array,
    base_from_asset: Array,
    target: Target,
    surroundings: Surroundings,
    goal: float,
    options: DemonstrationsConfig,
) -> Plan | None:
    """The first candidate that the arm can follow from `joints` (7,) without touching the object; None if none."""
    assert target.handle is not None
    hand = chain.pose(joints[None])[0]
    asset_hand = inverse(base_from_asset) @ hand
    plans = []
    for grasp in grasps(target, target.handle):
        pose = grasp_pose(target.handle, grasp.tilt, asset_hand)
        before = pose.copy()
        before[:3, 3] -= options.pregrasp * pose[:3, 2]
        pull = opening(target, pose, goal, grasp.follow)
        plans.append(
            Plan(
                straight(hand, base_from_asset @ before),
                straight(base_from_asset @ before, base_from_asset @ pose),
                base_from_asset @ pull,
                goal,
            )
        )
    sketches = [[_thin(path) for path in (plan.approach, plan.converge, plan.articulate)] for plan in plans]
    rollouts, reached = _roll_out(chain, joints, sketches)
    for plan, sketch, rollout, good in zip(plans, sketches, rollouts, reached, strict=True):
        if good and _is_clear(chain, rollout, len(sketch[0]) + len(sketch[1]), base_from_asset, surroundings, goal):
            return plan
    return None


def _thin(path: Array) -> Array:
    """Every `ROLLOUT_STEP` of a path, the last pose included, the first one not."""
    length = np.concatenate([[0.0], np.cumsum(distance(path[1:], path[:-1]))])
    count = max(1, int(np.ceil(length[-1] / ROLLOUT_STEP)))
    return np.asarray(path[np.searchsorted(length, np.linspace(0, length[-1], count + 1)[1:] - 1e-9)])


def _roll_out(chain: Chain, joints: Array, sketches: list[list[Array]]) -> tuple[list[Array], list[bool]]:
    """Track all candidates at once: per candidate (K, 7) joints, and whether every pose was reached."""
    poses = [np.concatenate(sketch) for sketch in sketches]
    longest = max(len(pose) for pose in poses)
    padded = np.stack([np.concatenate([pose, np.tile(pose[-1:], (longest - len(pose), 1, 1))]) for pose in poses])
    q = np.tile(joints, (len(poses), 1))
    reached = np.ones(len(poses), bool)
    history = []
    for step in range(longest):
        q = track(chain, q, padded[:, step])
        error = pose_error(padded[:, step], chain.pose(q))
        reached &= np.linalg.norm(error[:, :3], axis=1) < POSITION_TOLERANCE
        reached &= np.linalg.norm(error[:, 3:], axis=1) < ROTATION_TOLERANCE
        history.append(q)
    joined = np.stack(history, axis=1)
    return [joined[i, : len(pose)] for i, pose in enumerate(poses)], reached.tolist()


def _is_clear(
    chain: Chain, rollout: Array, grasped: int, base_from_asset: Array, surroundings: Surroundings, goal: float
) -> bool:
    """Whether arm, hand and (until the grasp) open fingers stay clear of the object along a rollout (K, 7)."""
    frames = inverse(base_from_asset) @ chain.frames(rollout)
    target = surroundings.target
    pull = len(rollout) - grasped
    for step, pose in enumerate(frames):
        holding = step >= grasped
        value = target.lower + (goal - target.lower) * (step - grasped + 1) / pull if holding else target.lower
        if not surroundings.clear(*arm_spheres(pose, None if holding else GRIPPER_OPEN), value):
            return False
    return True
