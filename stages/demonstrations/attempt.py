"""One attempt at a demonstration: place, plan, run the skill, record."""

import sys
import time

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.demonstrations.film import Taken
from stages.demonstrations.store import RecordedEpisode
from stages.plugins import load
from stages.skills import Float, Outcome, SkillProtocol
from stages.tasks.api import TaskEnv

PROGRESS_SECONDS = 5.0


class Recorder:
    """Runs attempts on a task by the skills of its chain; the first `film` successes are filmed."""

    def __init__(self, task: TaskEnv, options: DemonstrationsConfig, film: int = 0) -> None:
        self.task, self.options, self.film = task, options, film
        self.taken: list[Taken] = []
        self.skills: list[SkillProtocol] = [load("skills", name)(task, options) for name in task.task.skills]
        self._started = self._reported = time.monotonic()

    def attempt(self, seed: int) -> tuple[RecordedEpisode, Outcome]:
        """Run the skills from the initial state of `seed`."""
        task, episode, moments = self.task, RecordedEpisode(seed), []
        task.place(seed)
        filming = len(self.taken) < self.film
        rng = np.random.default_rng((seed, 1))

        def act(action: Float, noisy: bool) -> None:
            executed = action.copy()
            if noisy and self.options.noise > 0:
                executed[:3] += rng.normal(0, self.options.noise, 3) / task.options.position_step
            episode.add(task.observe(), action, executed, task.opened)
            if filming:
                moments.append(task.moment())
            task.act(executed)

        outcome = Outcome(True, "success")
        for skill in self.skills:
            outcome = skill.run(act)
            if not outcome.success:
                break
        if outcome.success and not task.success:
            outcome = Outcome(False, "not_successful")
        if filming and outcome.success:
            moments.append(task.moment())
            clouds = [*episode.point_clouds, task.observe()["point_cloud"]]
            self.taken.append(Taken(seed, task.opened, task.recording(moments), clouds))
        return episode, outcome

    def report(self, kept: int, wanted: int, attempts: int) -> None:
        """A line on stderr every few seconds, and at the end."""
        now = time.monotonic()
        if now - self._reported > PROGRESS_SECONDS or kept == wanted:
            self._reported = now
            print(f"demonstrations: {kept}/{wanted} from {attempts} attempts", file=sys.stderr)
