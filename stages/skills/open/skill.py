"""The Open skill (paper A.4), closed-loop through the actions a policy has: Approach ... Ungrasp."""

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.simulation.kinematics import Array, pose_error
from stages.skills import Act, Outcome
from stages.skills.clearance import Surroundings
from stages.skills.open.plan import plan_open
from stages.skills.path import Pursuit
from stages.tasks.api import TaskEnv

OPEN, CLOSED = 1.0, -1.0
ARRIVED = (0.008, 0.1)  # metres and radians at which the hand is in place to grasp
GRASP_STEPS, UNGRASP_STEPS = 3, 2
STALL_STEPS = 8  # steps without progress that mean failure
EMPTY = 0.001  # finger joints below this hold nothing, metres
LOST = 0.06  # hand this far off the path of the handle has lost it, metres


class OpenSkill:
    """Opens the target joint of a task as it stands after `place`."""

    def __init__(self, task: TaskEnv, options: DemonstrationsConfig) -> None:
        self.task, self.options = task, options
        self._surroundings: dict[str, Surroundings] = {}

    def run(self, act: Act) -> Outcome:
        """Open it; `act` executes one action (and records it)."""
        self.act, task = act, self.task
        surroundings = self.surroundings()
        target = surroundings.target
        if target.handle is None:
            return Outcome(False, "no_handle")
        fraction = min(1.0, task.options.success_fraction + self.options.goal_margin)
        goal = target.lower + fraction * (target.upper - target.lower)
        base_from_asset = task.env.base_from_asset()
        plan = plan_open(task.chain, task.joints()[:7], base_from_asset, target, surroundings, goal, self.options)
        if plan is None:
            return Outcome(False, "no_plan")
        approach = np.concatenate([plan.approach, plan.converge[1:]])
        enough = task.options.success_fraction + self.options.goal_margin / 2
        cause = self._reach(approach, len(plan.approach)) or self._grasp() or self._articulate(plan.articulate, enough)
        cause = cause or self._hold(OPEN, UNGRASP_STEPS, "ungrasp")
        if not cause and task.opened < task.options.success_fraction:
            cause = "closed_again"
        return Outcome(not cause, cause or "success")

    def surroundings(self) -> Surroundings:
        """Of the task's object; kept per size, as sampling the surfaces takes longer than planning."""
        key = str(self.task.env.asset_folder)
        if key not in self._surroundings:
            self._surroundings[key] = Surroundings(self.task.env.target)
        return self._surroundings[key]

    def _move(self, aim: Array, hand: Array, gripper: float, noisy: bool = True) -> None:
        """One action towards `aim` (4, 4), scaled to the limits of a step without turning aside."""
        options = self.task.options
        delta = pose_error(aim[None], hand[None])[0]
        action = np.concatenate([delta[:3] / options.position_step, delta[3:] / options.rotation_step])
        largest = max(np.abs(action[:3]).max(), np.linalg.norm(action[3:]))
        action = action / max(1.0, largest)
        self.act(np.append(action, gripper).astype(np.float32), noisy)

    def _out_of_time(self) -> bool:
        return self.task.steps >= self.task.max_steps

    def _reach(self, path: Array, pregrasp: int) -> str:
        """Approach and Converge as one motion; returns what failed or ''."""
        pursuit = Pursuit(path, self.options.approach_lookahead)
        stall, best = 0, np.inf
        while not self._out_of_time():
            hand = self.task.hand()
            aim = pursuit.aim(hand)
            error = pose_error(path[-1:], hand[None])[0]
            position, angle = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
            if position < ARRIVED[0] and angle < ARRIVED[1]:
                return ""
            remaining = pursuit.length[-1] - pursuit.progress + position
            stall, best = (0, remaining) if remaining < best - 0.002 else (stall + 1, best)
            if stall >= STALL_STEPS:
                return "approach" if pursuit.nearest < pregrasp else "converge"
            self._move(aim, self.task.reference(), OPEN)
        return "timeout"

    def _grasp(self) -> str:
        failed = self._hold(CLOSED, GRASP_STEPS, "grasp")
        return failed or ("grasp" if self.task.joints()[7:].max() < EMPTY else "")

    def _articulate(self, path: Array, enough: float) -> str:
        """Pull along the path of the handle until the joint is open `enough`, short of the path's end."""
        pursuit = Pursuit(path, self.options.articulate_lookahead)
        stall, best = 0, -np.inf
        while not self._out_of_time():
            hand = self.task.hand()
            aim = pursuit.aim(hand)
            opened = self.task.opened
            if opened >= enough:
                return ""
            nearest = pose_error(path[pursuit.nearest][None], hand[None])[0]
            if self.task.joints()[7:].max() < EMPTY or np.linalg.norm(nearest[:3]) > LOST:
                return "grasp_slip"
            stall, best = (0, opened) if opened > best + 0.003 else (stall + 1, best)
            if stall >= STALL_STEPS:
                return "articulate"
            self._move(aim, self.task.reference(), CLOSED)
        return "timeout"

    def _hold(self, gripper: float, steps: int, name: str) -> str:
        """Stand still while the gripper moves; returns `name` if time runs out."""
        for _ in range(steps):
            if self._out_of_time():
                return name
            self.act(np.array([0, 0, 0, 0, 0, 0, gripper], np.float32), False)
        return ""
