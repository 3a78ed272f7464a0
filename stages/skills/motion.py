"""What all skills are made of: primitives (pursue a path, grip, notice a miss), tries again, chains of them."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

import numpy as np

from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.clearance import CLEARANCE, Pursuit, Surroundings, make_line
from roomkin.stages.planning.rollout import TOLERANCE, measure_deviation
from roomkin.stages.plugins import load, shorten_name
from roomkin.stages.simulation.kinematics import Array, pose_error
from roomkin.stages.simulation.robot import GRIPPER_OPEN
from roomkin.stages.skills import FAR, Act, Outcome, SkillProtocol
from roomkin.stages.tasks.api import EnvWrapper

OPEN, CLOSED = 1.0, -1.0  # of the gripper's action
CLOSE_STEPS, OPEN_STEPS = 3, 2  # control steps until the gripper has closed, and until it lets go; chosen
EMPTY = 0.001  # metres of the finger joints, below which they hold nothing; chosen
LOST = 0.06  # metres that an object moved in the hand, from which on it is lost; chosen
STALL_STEPS = 8  # steps without progress that mean failure; chosen


class Stall:
    """Tells when a value no longer grows."""

    def __init__(self, least: float) -> None:
        self.least, self.best, self.steps = least, -np.inf, 0

    def __call__(self, value: float) -> bool:
        """Whether `value` has not grown by `least` for `STALL_STEPS` calls."""
        grew = value > self.best + self.least
        self.steps, self.best = (0, value) if grew else (self.steps + 1, self.best)
        return self.steps >= STALL_STEPS


class Motion:
    """Moves the hand of a task through the actions that a policy has; `act` executes (and records) one."""

    def __init__(self, task: EnvWrapper, act: Act) -> None:
        self.task, self.act = task, act

    @property
    def out_of_time(self) -> bool:
        """Whether the episode is over."""
        return self.task.steps >= self.task.max_steps

    @property
    def last_moment(self) -> bool:
        """Whether there is just time to let go."""
        return self.task.steps >= self.task.max_steps - OPEN_STEPS

    @property
    def fingers(self) -> float:
        """The wider finger joint, metres: half of what is between the fingers, if they are closed on it."""
        return float(self.task.joints()[7:].max())

    @property
    def empty(self) -> bool:
        """Whether the fingers are closed on nothing."""
        return self.fingers < EMPTY

    def step(self, aim: Array, gripper: float, ahead: float = FAR) -> None:
        """One action towards `aim` (4, 4), base frame, scaled to the limits of a step without turning aside."""
        options = self.task.options
        delta = pose_error(aim[None], self.task.reference()[None])[0]
        action = np.concatenate([delta[:3] / options.position_step, delta[3:] / options.rotation_step])
        largest = max(np.abs(action[:3]).max(), np.linalg.norm(action[3:]))
        action = action / max(1.0, largest)
        self.act(np.append(action, gripper).astype(np.float32), True, ahead)

    def hold(self, gripper: float, steps: int) -> bool:
        """Stand still while the gripper moves; False if time runs out."""
        for _ in range(steps):
            if self.out_of_time:
                return False
            self.act(np.array([0, 0, 0, 0, 0, 0, gripper], np.float32), False)
        return True

    def grasp(self) -> bool:
        """Close the gripper; whether it then holds something."""
        return self.hold(CLOSED, CLOSE_STEPS) and not self.empty

    def release(self) -> bool:
        """Open the gripper; False if time runs out."""
        return self.hold(OPEN, OPEN_STEPS)

    @property
    def holds(self) -> bool:
        """Whether the fingers may have something between them: they are neither fully open nor closed on nothing."""
        return not self.empty and self.fingers <= GRIPPER_OPEN - CLEARANCE

    @property
    def open(self) -> bool:
        """Whether the fingers are far enough apart to approach something."""
        return self.fingers > GRIPPER_OPEN / 2

    def follow(self, pursuit: Pursuit, gripper: float, watch: Callable[[Array], str], grasping: bool = False) -> str:
        """Follow a path until `watch`, given the pose (4, 4) of the hand before every step, returns a word.

        Args:
            grasping: whether the path leads to a grasp, so that demonstrations may disturb it.

        Returns:
            That word, or 'timeout'.
        """
        while not self.out_of_time:
            hand = self.task.hand()
            aim = pursuit.aim(hand)
            word = watch(hand)
            if word:
                return word
            self.step(aim, gripper, ahead=pursuit.left if grasping else FAR)
        return "timeout"

    def reach(
        self,
        path: Array,
        lookahead: float,
        gripper: float,
        watch: Callable[[Array], str] = lambda hand: "",
        grasping: bool = False,
    ) -> tuple[str, Pursuit]:
        """Follow a path (K, 4, 4) to its end, unless `watch` returns a word before.

        Returns:
            '' on arrival, that word, 'stall' or 'timeout'; and how far the hand came.
        """
        pursuit, stall = Pursuit(path, lookahead), Stall(0.002)

        def check_arrival(hand: Array) -> str:
            left = measure_deviation(path[-1:], hand[None])[0]
            if (left < TOLERANCE).all():
                return "arrived"
            return watch(hand) or ("stall" if stall(pursuit.progress - left[0]) else "")

        word = self.follow(pursuit, gripper, check_arrival, grasping)
        return "" if word == "arrived" else word, pursuit

    def retreat(self, length: float) -> str:
        """Back off by `length` metres along the fingers and open them; '', 'stall' or 'timeout'."""
        start = self.task.hand()
        end = start.copy()
        end[:3, 3] -= length * start[:3, 2]
        word, _ = self.reach(make_line(start, end), length, OPEN)
        while not self.open and not self.out_of_time:
            self.hold(OPEN, 1)
        return word


class RetryingSkill(ABC):
    """A subclass defines one attempt; `final` are the causes of failure after which no other attempt would succeed."""

    final: ClassVar[tuple[str, ...]] = ()

    def __init__(self, task: EnvWrapper, options: DemonstrationsConfig) -> None:
        self.task, self.options = task, options

    @abstractmethod
    def attempt(self, motion: Motion, number: int) -> str:
        """One go from where everything stands, after `number` others; returns what failed or ''."""

    def is_done(self) -> bool:
        """Whether the goal is reached although the attempt failed, as by a flap that swings on."""
        return False

    def run(self, act: Act) -> Outcome:
        """Try until it succeeds; `act` executes and records one action. A failure has the cause of the first try."""
        motion = Motion(self.task, act)
        causes: list[str] = []
        while True:
            cause = self.attempt(motion, len(causes))
            if not cause:
                return Outcome(True, "success", len(causes))
            causes.append(cause)
            if cause in self.final or motion.out_of_time:
                return Outcome(False, causes[0], len(causes) - 1)
            motion.retreat(self.options.pregrasp)
            if self.is_done():
                return Outcome(True, "success", len(causes))

    def surroundings(self) -> Surroundings:
        """Points on the task's object and on the obstacles around it; the object's are sampled once per size."""
        env = self.task.env
        obstacles = transform_points(invert_transform(env.base_from_asset()), env.obstacles())
        return env.sample_surroundings().with_obstacles(obstacles)

    def joint(self) -> float:
        """The value of the target joint as it stands."""
        target = self.task.env.target
        return target.lower + float(np.clip(self.task.opened, 0.0, 1.0)) * (target.upper - target.lower)


class SkillChain:
    """The skills that a task names, made once per task; they run one after the other."""

    def __init__(self, task: EnvWrapper, options: DemonstrationsConfig) -> None:
        self.task = task
        self.skills: list[SkillProtocol] = [load("skills", name)(task, options) for name in task.task.skills]

    def run(self, act: Act) -> Outcome:
        """Do the task from where everything stands; the first skill that fails names the cause."""
        outcome = Outcome(True, "success")
        for name, skill in zip(self.task.task.skills, self.skills, strict=True):
            outcome = skill.run(act)
            if not outcome.success:
                several = len(self.skills) > 1
                return replace(outcome, cause=f"{shorten_name(name)}_{outcome.cause}") if several else outcome
        return outcome if self.task.success else Outcome(False, "not_successful")
