"""One attempt at a demonstration: place, plan, run the skill, record."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.demonstrations import DemonstrationsConfig
from roomkin.stages.demonstrations.recovery import sample_disturbance
from roomkin.stages.demonstrations.store import RecordedEpisode
from roomkin.stages.simulation.recording import Recording
from roomkin.stages.skills import FAR, Float, Outcome
from roomkin.stages.skills.chain import SkillChain
from roomkin.stages.tasks.api import EnvWrapper


@dataclass(frozen=True)
class FilmedAttempt:
    """A success to be filmed, and the clouds that were seen at its moments."""

    seed: int
    asset: str
    opened: float
    recording: Recording
    clouds: Sequence[NDArray[np.floating]]


class Recorder:
    """Runs attempts on a task by the skills of its chain; with `film` the first success is recorded for a film."""

    def __init__(self, task: EnvWrapper, options: DemonstrationsConfig, film: bool = False) -> None:
        self.task, self.options, self.film = task, options, film
        self.filmed: list[FilmedAttempt] = []
        self.chain = SkillChain(task, options)

    def attempt(self, seed: int) -> tuple[RecordedEpisode, Outcome]:
        """Run the skills from the initial state of `seed`."""
        task, moments = self.task, []
        episode = RecordedEpisode(seed, task.asset, task.joint, task.size)
        task.place(seed)
        filming = self.film and not self.filmed
        rng = np.random.default_rng((seed, 1))
        disturbance = sample_disturbance(np.random.default_rng((seed, 2)), self.options.recovery)
        speed = draw_approach_speed(seed, self.options)
        episode.recovery = disturbance.kind if disturbance else None

        def act(action: Float, noisy: bool, ahead: float = FAR) -> None:
            if ahead < FAR:
                action = np.append(action[:6] * np.float32(speed), action[6:])
            executed = action.copy()
            if noisy and self.options.noise > 0:
                executed[:3] += rng.normal(0, self.options.noise, 3) / task.options.position_step
            if disturbance:
                executed = disturbance.apply(executed, ahead)
            episode.add(task.observe(), action, executed, task.opened)
            if filming:
                moments.append(task.env.moment())
            task.act(executed)

        outcome = self.chain.run(act)
        if filming and outcome.success:
            moments.append(task.env.moment())
            clouds = [*episode.point_clouds, task.observe()["point_cloud"]]
            self.filmed.append(FilmedAttempt(seed, task.asset, task.opened, task.env.recording(moments), clouds))
        return episode, outcome


def draw_approach_speed(seed: int, options: DemonstrationsConfig) -> float:
    """The share of the full speed at which the hand approaches in the attempt `seed`."""
    return float(np.random.default_rng((seed, 3)).uniform(*options.approach_speed))
