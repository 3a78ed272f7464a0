"""The steps of Open and Close (paper A.4): Approach, Converge, Grasp, Articulate, Ungrasp, and again after a miss."""

from abc import abstractmethod
from collections import Counter
from collections.abc import Collection

import numpy as np

from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.planning.articulation import Grasp, Plan, plan_articulation
from roomkin.stages.planning.clearance import Pursuit, Surroundings
from roomkin.stages.simulation.kinematics import Array, pose_error
from roomkin.stages.simulation.target import Target
from roomkin.stages.skills.motion import CLOSED, LOST, OPEN, Motion, RetryingSkill, Stall
from roomkin.stages.tasks.api import EnvWrapper


class ArticulateSkill(RetryingSkill):
    """Moves the target joint of a task, by its handle, as far as a subclass says; tries again while there is time."""

    final = ("no_handle", "no_plan", "timeout", "ungrasp")

    def __init__(self, task: EnvWrapper, options: DemonstrationsConfig) -> None:
        super().__init__(task, options)
        self.missed: list[tuple[Grasp, str]] = []  # of this run, with the cause

    @property
    def spare(self) -> float:
        """Radians that the arm's joints are to keep to their limits."""
        return 0.0

    @abstractmethod
    def goals(self, target: Target) -> tuple[float, ...]:
        """Joint values to move towards, the first that the arm can follow."""

    @abstractmethod
    def has_moved_enough(self, goal: float) -> bool:
        """Whether the joint has been moved far enough towards `goal` to let go."""

    @abstractmethod
    def is_done(self) -> bool:
        """Whether the joint is, after letting go, where it was to be."""

    def attempt(self, motion: Motion, number: int) -> str:
        """One go from where everything stands; returns what failed or ''."""
        surroundings = self.surroundings()
        if surroundings.target.handle is None:
            return "no_handle"
        if number == 0:
            self.missed.clear()
        plan, goal = self._plan(surroundings)
        if plan is None:
            return "no_plan"
        cause = self._approach(motion, plan) or self._articulate(motion, plan.articulate, goal) or self._let_go(motion)
        if cause:
            self.missed.append((plan.grasp, cause))
        return cause

    def _plan(self, surroundings: Surroundings) -> tuple[Plan | None, float]:
        """The plan for the first goal that the arm can follow, and that goal. By chance a good grasp may miss once; one
        that missed twice gives way to others, if there are any."""
        task = self.task
        where = (task.chain, task.joints()[:7], task.env.base_from_asset(), surroundings, self.joint())
        worn = {grasp for grasp, times in Counter(grasp for grasp, _ in self.missed).items() if times > 1}
        choices: list[Collection[Grasp]] = [worn, ()] if worn else [()]
        for without in choices:
            for goal in self.goals(surroundings.target):
                plan = plan_articulation(*where, goal, self.options, self.spare, without)
                if plan is not None:
                    return plan, goal
        return None, self.joint()

    def _approach(self, motion: Motion, plan: Plan) -> str:
        """Approach and Converge as one motion, then Grasp."""
        path = np.concatenate([plan.approach, plan.converge[1:]])

        def watch(hand: Array) -> str:
            return "" if motion.open else "closed"

        cause, pursuit = motion.reach(path, self.options.approach_lookahead, OPEN, watch, grasping=True)
        if cause == "stall":
            return "approach" if pursuit.nearest < len(plan.approach) else "converge"
        return cause or ("" if motion.grasp() else "grasp")

    def _articulate(self, motion: Motion, path: Array, goal: float) -> str:
        """Along the path of the handle until the joint has moved far enough towards `goal`."""
        # A flap is heavy: were it pulled at full speed from the first step, it would stay behind and leave the fingers.
        heavy = self.task.env.target.flap or any(cause == "grasp_slip" for _, cause in self.missed)
        before, pace, full = self.task.opened, 0, 3 if heavy else 1
        pursuit, stall = Pursuit(path, self.options.articulate_lookahead / full), Stall(0.003)

        def watch(hand: Array) -> str:
            nonlocal pace
            pace = min(pace + 1, full)
            pursuit.lookahead = self.options.articulate_lookahead * min(pace + 1, full) / full
            if self.has_moved_enough(goal) or (motion.last_moment and self.is_done()):
                return "enough"
            off = pose_error(path[pursuit.nearest][None], hand[None])[0, :3]
            if motion.empty or np.linalg.norm(off) > LOST:
                return "enough" if self.is_done() else "grasp_slip"
            return "articulate" if stall(abs(self.task.opened - before)) else ""

        word = motion.follow(pursuit, CLOSED, watch)
        return "" if word == "enough" else word

    def _let_go(self, motion: Motion) -> str:
        if not motion.release():
            return "ungrasp"
        return "" if self.is_done() else "moved_back"
