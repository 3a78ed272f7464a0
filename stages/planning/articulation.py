"""Grasps of a handle, preferred ones first, and plans to move its joint: Approach, Converge, Articulate (paper A.4)."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.handle import Handle
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.geometry.frames import invert_transform, make_transform, yaw_matrix
from roomkin.stages.planning.clearance import (
    CLEARANCE,
    Surroundings,
    join_lines,
    make_handle_path,
    make_line,
    measure_distance,
)
from roomkin.stages.planning.rollout import ON_THE_WAY, Stretch, find_feasible, plan_homing
from roomkin.stages.simulation.kinematics import Array, Chain
from roomkin.stages.simulation.robot import GRIPPER_OPEN, REST
from roomkin.stages.simulation.target import Target

HALF_PAD = 0.009  # from the middle of a finger's pad, which is the tool center point, to the fingertip, metres

# Tilt and pitch for the horizontal bar of a drawer where nothing else will do, or only with the arm at its limits: from
# above, with the fingertips, as the upper finger comes near the panel.
FROM_ABOVE = ((0.7, 0.35), (-0.7, 0.35), (0.35, 0.5))


@dataclass(frozen=True)
class Grasp:
    """A way to hold a handle. Angles in radians.

    tilt: turn of the approach about the closing axis. pitch: turn from above, about a horizontal handle. follow: share
    of a door's turn that the hand makes. depth: of the tool center point behind the foremost surface, metres. over:
    fingers above and below a knob, not at its sides. swing: turn of the approach about the vertical.
    """

    tilt: float
    pitch: float
    follow: float
    depth: float = HALF_PAD
    over: bool = False
    swing: float = 0.0


def list_grasps(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates, the preferred ones first: always in the same order, so that demonstrations are consistent."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    tilts = (0.7, 1.0, 0.35, 0.0) if upright else (0.0, 0.35, -0.35, 0.7, -0.7)
    follows = (1.0, 0.5, 0.0) if target.revolute else (1.0,)
    if target.flap:  # it comes down towards the robot; the less its bar turns between the fingers, the less it slips
        yield from (Grasp(0.0, pitch, follow) for follow in follows for pitch in (0.0, 0.35, 0.7))
    yield from (Grasp(tilt, 0.0, follow) for follow in follows for tilt in tilts)
    if not target.revolute and not upright:
        yield from (Grasp(tilt, pitch, 1.0, 0.0) for tilt, pitch in FROM_ABOVE)
    if not handle.elongated:  # another knob next to it leaves no room for a finger
        yield from (Grasp(tilt, 0.0, follow, over=True) for follow in follows for tilt in (0.0, 0.35, -0.35, 0.7, -0.7))


def list_last_resorts(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates for a wide door that no other grasp opens: the hand comes from the side of the hinge, where the front
    stays near the robot as it turns; to a horizontal bar from above, so that the arm need not turn with the front."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    for follow in (0.5, 1.0, 0.0) if target.side else ():
        if upright:
            for swing in (0.35, 0.7):
                yield from (Grasp(tilt, 0.0, follow, swing=-target.side * swing) for tilt in (0.7, 0.35, 1.0, 0.0))
        else:
            for pitch in (0.35, 0.7):
                yield from (Grasp(tilt, pitch, follow) for tilt in (0.0, 0.35, -0.35, 0.7, -0.7))


def grasp_pose(handle: Handle, grasp: Grasp, hand: Array) -> Array:
    """(4, 4) pose of the tool center point on a handle, asset frame, closed.

    The fingers close across the handle's long direction (on a knob sideways, or from above and below). Of the two
    ways it is the one nearer to the present pose `hand` (4, 4); for a horizontal bar, which is equally far from both,
    always the one that takes the last joint away from its limit. A tilt raises the wrist (for a horizontal bar: turns
    it sideways).
    """
    closing = np.array([0.0, 0.0, 1.0] if grasp.over else [0.0, 1.0, 0.0])
    if handle.elongated:
        closing = np.cross(handle.axis, [1.0, 0.0, 0.0])
    if (closing[2] if abs(closing[2]) > 0.5 else closing @ hand[:3, 1]) < 0:
        closing = -closing
    straight_in = np.array([-1.0, 0.0, 0.0])
    up = np.cross(closing, straight_in)
    lift = np.sign(up[2]) if abs(up[2]) > 0.5 else 1.0
    approach = Rotation.from_rotvec(-closing * grasp.tilt * lift).apply(straight_in)
    thick = handle.elongated and handle.width > 2 * HALF_PAD
    depth = max(grasp.depth, handle.width / 2) if thick else grasp.depth  # nearer to its front the pads slip off
    depth = float(np.clip(handle.protrusion - HALF_PAD - CLEARANCE, 0.0, depth))
    rotation = np.stack([np.cross(closing, approach), closing, approach], axis=1)
    from_above = Rotation.from_rotvec([0.0, -grasp.pitch, 0.0]).as_matrix()
    return make_transform(yaw_matrix(grasp.swing) @ from_above @ rotation, handle.position + depth * straight_in)


SHARES = (1.0, 0.6, 0.3)  # of the margin, tried in turn where the arm cannot follow a wide door so far; chosen
LAG = 0.1  # of the margin by which a door may lag behind the hand when it is let go; chosen


@dataclass(frozen=True)
class Plan:
    """A grasp, and the paths of the hand in the robot base frame, (K, 4, 4) each."""

    grasp: Grasp
    approach: Array
    converge: Array
    articulate: Array


def plan_articulation(
    chain: Chain,
    joints: Array,
    base_from_asset: Array,
    surroundings: Surroundings,
    start: float,
    goal: float,
    options: DemonstrationsConfig,
    spare: float = 0.0,
    without: Collection[Grasp] = (),
) -> Plan | None:
    """The first grasp by which the arm can take the target joint from `start` to `goal` without touching anything.

    Args:
        joints: (7,) of the arm as it stands.
        start, goal: of the target joint; it stands at `start`.
        spare: radians that the arm's joints should keep from their limits, where some grasp allows it.
        without: grasps that are left out.

    Returns:
        None if there is none.
    """
    target = surroundings.target
    assert target.handle is not None
    for offered in (list_grasps(target, target.handle), list_last_resorts(target, target.handle)):
        choice = [grasp for grasp in offered if grasp not in without]
        tried: list[Plan] = []

        def candidates(choice: Sequence[Grasp] = choice, tried: list[Plan] = tried) -> Iterator[Sequence[Stretch]]:
            for plan, slack in _plans(chain, joints, base_from_asset, target, choice, start, goal, options):
                tried.append(plan)
                yield (
                    Stretch(plan.approach, GRIPPER_OPEN, (start, start), slack=slack),
                    Stretch(plan.converge, GRIPPER_OPEN, (start, start)),
                    Stretch(plan.articulate, None, (start, goal)),
                )

        index = find_feasible(chain, joints, candidates(), base_from_asset, surroundings, spare)
        if index is not None:
            return tried[index]
    return None


def choose_open_goals(target: Target, opening: float, margin: float) -> tuple[float, ...]:
    """The values to which a joint is moved to open it by a fraction of its range: further by `SHARES` of a margin, a
    fraction of the range as well. In a range of 180 degrees all of it may be 36 degrees more than success needs.
    """
    fractions = (min(1.0, opening + share * margin) for share in SHARES)
    return tuple(target.lower + fraction * (target.upper - target.lower) for fraction in fractions)


def choose_release_opening(target: Target, opening: float, margin: float, goal: float) -> float:
    """The fraction of its range at which a joint on its way to `goal` (see `choose_open_goals`) is let go."""
    moved_to = (goal - target.lower) / (target.upper - target.lower)
    return min(opening + margin / 2, moved_to - LAG * margin)


def _plans(
    chain: Chain,
    joints: Array,
    base_from_asset: Array,
    target: Target,
    choice: Iterable[Grasp],
    start: float,
    goal: float,
    options: DemonstrationsConfig,
) -> Iterator[tuple[Plan, float]]:
    """The paths by each grasp and way to it, with the slack of that way."""
    assert target.handle is not None
    asset_hand = invert_transform(base_from_asset) @ chain.pose(joints[None])[0]
    for grasp in choice:
        pose = grasp_pose(target.handle, grasp, asset_hand)
        motion = base_from_asset @ make_handle_path(target, pose, start, goal, grasp.follow)
        before = motion[0].copy()
        before[:3, 3] -= options.pregrasp * before[:3, 2]
        for approach, slack in list_approaches(chain, joints, before, options.pregrasp):
            yield Plan(grasp, approach, make_line(before, motion[0]), motion), slack


def list_approaches(chain: Chain, joints: Array, before: Array, pregrasp: float) -> Iterator[tuple[Array, float]]:
    """Ways (K, 4, 4) from where the arm is to a pose of the hand, with their slack: straight; where the hand is higher
    also from above; where it is farther than `pregrasp` from its rest pose (path length) also through that."""
    hand, rest = chain.pose(np.stack([joints, REST]))
    yield make_line(hand, before), 1.0
    if hand[2, 3] > before[2, 3]:
        over = before.copy()
        over[2, 3] = hand[2, 3]
        yield join_lines([hand, over, before]), 1.0
    if measure_distance(hand[None], rest[None])[0] > pregrasp:
        to_rest = plan_homing(chain, joints, hand)
        yield np.concatenate([to_rest, make_line(to_rest[-1], before)[1:]]), ON_THE_WAY
