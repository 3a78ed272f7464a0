"""The base of our skills: tries once, and again after a miss while there is time."""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.geometry.frames import apply, inverse
from stages.planning.clearance import Surroundings
from stages.skills import Act, Outcome
from stages.skills.motion import Motion
from stages.tasks.api import TaskEnv


class RetryingSkill(ABC):
    """A subclass says what one attempt is; `final` are the causes after which another is no use."""

    final: ClassVar[tuple[str, ...]] = ()

    def __init__(self, task: TaskEnv, options: DemonstrationsConfig) -> None:
        self.task, self.options = task, options

    @abstractmethod
    def attempt(self, motion: Motion, number: int) -> str:
        """One go from where everything stands, after `number` others; returns what failed or ''."""

    def done(self) -> bool:
        """Whether it has come about after all, though an attempt failed: a flap that goes on by itself."""
        return False

    def run(self, act: Act) -> Outcome:
        """Do it; `act` executes one action (and records it). The cause of a failure is that of the first miss."""
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
            if self.done():
                return Outcome(True, "success", len(causes))

    def surroundings(self) -> Surroundings:
        """Of the task's object as it is now; its surfaces are sampled once per size."""
        env = self.task.env
        return env.around().beside(apply(inverse(env.base_from_asset()), env.obstacles()))

    def joint(self) -> float:
        """The value of the target joint as it stands."""
        target = self.task.env.target
        return target.lower + float(np.clip(self.task.opened, 0.0, 1.0)) * (target.upper - target.lower)
