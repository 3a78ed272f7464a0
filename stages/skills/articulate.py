"""What Open and Close share (paper A.4): Approach, Converge, Grasp, Articulate, Ungrasp, and again after a miss."""

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.geometry.frames import inverse
from stages.simulation.kinematics import Array, Chain, pose_error
from stages.simulation.robot import GRIPPER_OPEN, REST
from stages.simulation.target import Target
from stages.skills.attempts import RetryingSkill
from stages.skills.clearance import Surroundings
from stages.skills.handle_grasp import Grasp, from_the_hinge, grasp_pose, grasps
from stages.skills.motion import CLOSED, OPEN, Motion, Stall
from stages.skills.path import Pursuit, along, articulation, distance, straight
from stages.skills.rollout import ON_THE_WAY, Stretch, first_feasible, homing

ABOVE = 0.05  # metres that the hand is higher than a handle at which it may have to come down to it
ELSEWHERE = 0.15  # path length from the rest pose at which the hand may have to go back there first
LOST = 0.06  # hand this far off the path of the handle has lost it, metres
LESS = 0.6  # of the margin; half of it counts as enough
GENTLE = 3  # steps until the pull of a flap has its full speed: being heavy it would stay behind, and leave the fingers


@dataclass(frozen=True)
class Plan:
    """Paths of the hand in the robot base frame, (K, 4, 4) each."""

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
) -> Plan | None:
    """The first grasp by which the arm can take the target joint from `start` to `goal` without touching anything.

    Args:
        joints: (7,) of the arm as it stands.
        start, goal: of the target joint; it stands at `start`.
        spare: radians that the arm's joints are to keep to their limits, if some grasp does.

    Returns:
        None if there is none.
    """
    target = surroundings.target
    assert target.handle is not None
    for choice in (grasps(target, target.handle), from_the_hinge(target, target.handle)):
        plans = list(_plans(chain, joints, base_from_asset, target, choice, start, goal, options))
        candidates = [
            (
                Stretch(plan.approach, GRIPPER_OPEN, (start, start), slack=slack),
                Stretch(plan.converge, GRIPPER_OPEN, (start, start)),
                Stretch(plan.articulate, None, (start, goal)),
            )
            for plan, slack in plans
        ]
        index = first_feasible(chain, joints, candidates, base_from_asset, surroundings, spare)
        if index is not None:
            return plans[index][0]
    return None


def opened_to(target: Target, opening: float, margin: float) -> tuple[float, ...]:
    """The values to which a joint is moved to open it by a fraction of its range: further by a margin; where the arm
    cannot follow it so far, as of a wide door, by `LESS` of that.
    """
    fractions = (min(1.0, opening + share * margin) for share in (1.0, LESS))
    return tuple(target.lower + fraction * (target.upper - target.lower) for fraction in fractions)


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
    asset_hand = inverse(base_from_asset) @ chain.pose(joints[None])[0]
    for grasp in choice:
        pose = grasp_pose(target.handle, grasp, asset_hand)
        motion = base_from_asset @ articulation(target, pose, start, goal, grasp.follow)
        before = motion[0].copy()
        before[:3, 3] -= options.pregrasp * before[:3, 2]
        for approach, slack in approaches(chain, joints, before):
            yield Plan(approach, straight(before, motion[0]), motion), slack


def approaches(chain: Chain, joints: Array, before: Array) -> list[tuple[Array, float]]:
    """Ways (K, 4, 4) from where the arm is to a pose of the hand, with their slack: straight; from where a skill before
    has left the hand also from above, and through the rest pose."""
    hand, rest = chain.pose(np.stack([joints, REST]))
    ways = [(straight(hand, before), 1.0)]
    if hand[2, 3] > before[2, 3] + ABOVE:
        over = before.copy()
        over[2, 3] = hand[2, 3]
        ways.append((along([hand, over, before]), 1.0))
    if distance(hand[None], rest[None])[0] > ELSEWHERE:
        to_rest = homing(chain, joints, hand)
        ways.append((np.concatenate([to_rest, straight(to_rest[-1], before)[1:]]), ON_THE_WAY))
    return ways


class ArticulateSkill(RetryingSkill):
    """Moves the target joint of a task, by its handle, as far as a subclass says; tries again while there is time."""

    final = ("no_handle", "no_plan", "timeout", "ungrasp")

    @property
    def spare(self) -> float:
        """Radians that the arm's joints are to keep to their limits."""
        return 0.0

    @abstractmethod
    def goals(self, target: Target) -> tuple[float, ...]:
        """Joint values to move towards, the first that the arm can follow."""

    @abstractmethod
    def enough(self) -> bool:
        """Whether the joint has been moved far enough to let go."""

    @abstractmethod
    def done(self) -> bool:
        """Whether the joint is, after letting go, where it was to be."""

    def attempt(self, motion: Motion, number: int) -> str:
        """One go from where everything stands; returns what failed or ''."""
        task, surroundings = self.task, self.surroundings()
        target = surroundings.target
        if target.handle is None:
            return "no_handle"
        stands, base_from_asset = task.joints()[:7], task.env.base_from_asset()
        for goal in self.goals(target):
            plan = plan_articulation(
                task.chain, stands, base_from_asset, surroundings, self.joint(), goal, self.options, self.spare
            )
            if plan is not None:
                break
        if plan is None:
            return "no_plan"
        return self._approach(motion, plan) or self._articulate(motion, plan.articulate) or self._let_go(motion)

    def _approach(self, motion: Motion, plan: Plan) -> str:
        """Approach and Converge as one motion, then Grasp."""
        path = np.concatenate([plan.approach, plan.converge[1:]])

        def watch(hand: Array) -> str:
            return "" if motion.open else "closed"

        cause, pursuit = motion.reach(path, self.options.approach_lookahead, OPEN, watch, grasping=True)
        if cause == "stall":
            return "approach" if pursuit.nearest < len(plan.approach) else "converge"
        return cause or ("" if motion.grasp() else "grasp")

    def _articulate(self, motion: Motion, path: Array) -> str:
        """Along the path of the handle until the joint has moved far enough."""
        before, pace, full = self.task.opened, 0, GENTLE if self.task.env.target.flap else 1
        pursuit, stall = Pursuit(path, self.options.articulate_lookahead / full), Stall(0.003)

        def watch(hand: Array) -> str:
            nonlocal pace
            pace = min(pace + 1, full)
            pursuit.lookahead = self.options.articulate_lookahead * min(pace + 1, full) / full
            if self.enough():
                return "enough"
            off = pose_error(path[pursuit.nearest][None], hand[None])[0, :3]
            if motion.empty or np.linalg.norm(off) > LOST:
                return "enough" if self.done() else "grasp_slip"
            return "articulate" if stall(abs(self.task.opened - before)) else ""

        word = motion.follow(pursuit, CLOSED, watch)
        return "" if word == "enough" else word

    def _let_go(self, motion: Motion) -> str:
        if not motion.release():
            return "ungrasp"
        return "" if self.done() else "moved_back"
