"""The base of our skills: tries once, and again after a miss while there is time."""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from roomkin.stages.config.demonstrations import DemonstrationsConfig
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.skills import Act, Outcome
from roomkin.stages.skills.motion import Motion
from roomkin.stages.tasks.api import EnvWrapper


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
        return env.sample_surroundings().with_obstacles(
            transform_points(invert_transform(env.base_from_asset()), env.obstacles())
        )

    def joint(self) -> float:
        """The value of the target joint as it stands."""
        target = self.task.env.target
        return target.lower + float(np.clip(self.task.opened, 0.0, 1.0)) * (target.upper - target.lower)
