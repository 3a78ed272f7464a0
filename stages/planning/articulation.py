"""Plans to open or close a joint by its handle (paper A.4): Approach, Converge, Articulate."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from roomkin.stages.config.demonstrations import DemonstrationsConfig
from roomkin.stages.geometry.frames import invert_transform
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.planning.handle_grasp import Grasp, grasp_pose, list_grasps, list_last_resorts
from roomkin.stages.planning.path import join_lines, make_handle_path, make_line, measure_distance
from roomkin.stages.planning.rollout import ON_THE_WAY, Stretch, find_feasible, plan_homing
from roomkin.stages.simulation.kinematics import Array, Chain
from roomkin.stages.simulation.robot import GRIPPER_OPEN, REST
from roomkin.stages.simulation.target import Target

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
