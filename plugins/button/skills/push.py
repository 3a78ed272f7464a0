"""The Push skill: Approach with the gripper closed, and push along the way of the joint."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.stages.geometry.frames import invert_transform, make_transform
from roomkin.stages.planning.articulation import HALF_PAD, list_approaches
from roomkin.stages.planning.clearance import Pursuit, make_line
from roomkin.stages.planning.rollout import Stretch, find_feasible
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.target import Target
from roomkin.stages.skills.motion import CLOSED, Motion, RetryingSkill, Stall

BEFORE = 0.06  # metres before the face, from where on the hand goes straight; chosen
TILTS = (0.0, 0.35, -0.35, 0.7, -0.7)  # radians of the fingers to the joint's axis, about either axis; chosen


def list_pushes(target: Target, hand: Array) -> Iterator[Array]:
    """(4, 4) poses of a hand whose fingertips touch the middle of the face, asset frame, turned as little as possible
    from its present pose `hand` (4, 4); the straight one first."""
    middle, nearest = target.moving.bounds.mean(axis=0), (target.moving.vertices @ target.axis).min()
    face = middle + target.axis * (nearest - middle @ target.axis)
    turn, _ = Rotation.align_vectors(target.axis[None], hand[None, :3, 2])
    straight = turn.as_matrix() @ hand[:3, :3]
    for axis in (0, 1):
        for tilt in TILTS[axis:]:  # 0 once
            rotation = straight @ Rotation.from_rotvec(tilt * np.eye(3)[axis]).as_matrix()
            yield make_transform(rotation, face - HALF_PAD * rotation[:, 2])


class Skill(RetryingSkill):
    """Pushes the target joint of a task somewhat further than success needs."""

    final = ("no_plan", "timeout")

    def attempt(self, motion: Motion, number: int) -> str:
        """One go from where everything stands; returns what failed or ''."""
        plan = self._plan()
        if plan is None:
            return "no_plan"
        approach, push = plan
        cause, _ = motion.reach(approach, self.options.approach_lookahead, CLOSED)
        if cause:
            return "approach" if cause == "stall" else cause
        stall = Stall(0.003)
        enough = min(1.0, self.task.success_opening + self.options.goal_margin)

        def watch(hand: Array) -> str:
            if self.task.opened >= enough or (motion.last_moment and self.task.success):
                return "enough"
            return "push" if stall(pursuit.progress + self.task.opened) else ""

        pursuit = Pursuit(push, self.options.articulate_lookahead)
        word = motion.follow(pursuit, CLOSED, watch)
        return "" if word == "enough" else word

    def is_done(self) -> bool:
        return self.task.success

    def _plan(self) -> tuple[Array, Array] | None:
        """Paths (K, 4, 4) of the hand to before the face and on to where the joint ends; None: the arm cannot."""
        task, around, start = self.task, self.surroundings(), self.joint()
        target, chain, joints, base = around.target, self.task.chain, self.task.joints()[:7], task.env.base_from_asset()
        plans, candidates = [], []
        for touch in list_pushes(target, invert_transform(base) @ task.hand()):
            end, before = touch.copy(), touch.copy()
            end[:3, 3] += target.axis * (target.upper - target.lower)
            before[:3, 3] -= BEFORE * target.axis
            push = base @ make_line(before, end)
            for approach, slack in list_approaches(chain, joints, push[0], self.options.pregrasp):
                plans.append((approach, push))
                way = Stretch(approach, 0.0, (start, start), slack=slack)
                candidates.append((way, Stretch(push, None, (start, target.upper))))
        index = find_feasible(chain, joints, candidates, base, around)
        return None if index is None else plans[index]
