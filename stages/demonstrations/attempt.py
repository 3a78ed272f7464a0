"""One attempt at a demonstration: place, plan, run the skill, record."""

import sys
import time

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.demonstrations.clearance import Surroundings
from stages.demonstrations.film import Image, strip
from stages.demonstrations.skill import Float, OpenSkill, Outcome
from stages.demonstrations.store import Episode
from stages.simulation.target import Target
from stages.simulation.task_api import TaskEnv

PROGRESS_SECONDS = 5.0


class Recorder:
    """Runs attempts on a task. The first `film` successes are kept as strips of pictures."""

    def __init__(self, task: TaskEnv, options: DemonstrationsConfig, film: int = 0) -> None:
        self.task, self.options, self.film = task, options, film
        self.strips: list[Image] = []
        self._known: dict[str, Surroundings] = {}
        self._started = self._reported = time.monotonic()

    def attempt(self, seed: int) -> tuple[Episode, Outcome]:
        """Run the skill from the initial state of `seed`."""
        task, episode, pictures = self.task, Episode(seed), []
        task.place(seed)
        filming = len(self.strips) < self.film
        rng = np.random.default_rng((seed, 1))

        def act(action: Float, noisy: bool) -> None:
            episode.add(task.observe(), action, task.opened)
            if filming:
                pictures.append(task.picture())
            executed = action.copy()
            if noisy and self.options.noise > 0:
                executed[:3] += rng.normal(0, self.options.noise, 3) / task.options.position_step
            task.act(executed)

        outcome = OpenSkill(task, self.options, act).run(self._surroundings(task.env.target))
        if filming and outcome.success:
            pictures.append(task.picture())
            self.strips.append(strip(pictures, [*episode.point_clouds, task.observe()["point_cloud"]]))
        return episode, outcome

    def report(self, kept: int, wanted: int, attempts: int) -> None:
        """A line on stderr every few seconds, and at the end."""
        now = time.monotonic()
        if now - self._reported > PROGRESS_SECONDS or kept == wanted:
            self._reported = now
            print(f"demonstrations: {kept}/{wanted} from {attempts} attempts", file=sys.stderr)

    def _surroundings(self, target: Target) -> Surroundings:
        """Cached per scale variant: sampling the surfaces takes longer than planning."""
        key = str(self.task.env.asset_folder)
        if key not in self._known:
            self._known[key] = Surroundings(target)
        return self._known[key]
