"""One attempt at a demonstration: place, plan, run the skill under disturbances, record (robomimic's layout).

What is executed differs from what the skill asks for, and it is the latter that is recorded: as with noise (DART,
Laskey et al. 2017), the data shows what to do in states that a policy's own mistakes lead to, never the mistakes.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import h5py
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.training import DemonstrationsConfig, RandomiseOptions
from roomkin.stages.contracts import write_atomically
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.simulation.room import Recording
from roomkin.stages.skills import FAR, Outcome
from roomkin.stages.skills.motion import CLOSE_STEPS, CLOSED, OPEN, SkillChain
from roomkin.stages.tasks.api import EnvWrapper, Observation

Float = NDArray[np.float32]


@dataclass
class RecordedEpisode:
    """What is recorded of one attempt: observations before each action, the clean action, the one that was executed
    (they differ by noise and disturbance; the executed ones replay the episode), how far the joint was open."""

    seed: int
    asset: str
    joint: str
    size: tuple[float, float, float]  # nominal
    recovery: str | None = None  # what it had to recover from
    point_clouds: list[Float] = field(default_factory=list)
    proprios: list[Float] = field(default_factory=list)
    actions: list[Float] = field(default_factory=list)
    executed: list[Float] = field(default_factory=list)
    opened: list[float] = field(default_factory=list)

    def add(self, observation: Observation, action: Float, executed: Float, opened: float) -> None:
        """Append one step."""
        self.point_clouds.append(observation["point_cloud"].astype(np.float16))
        self.proprios.append(observation["proprio"])
        self.actions.append(action)
        self.executed.append(executed)
        self.opened.append(opened)


def write_episodes(
    path: Path,
    episodes: Sequence[RecordedEpisode],
    task: str,
    environment: str,
    asset: str,
    options: TaskConfig,
    randomise: RandomiseOptions | None = None,
) -> None:
    """Write a store atomically; the same episodes give the same bytes.

    `environment` is the task's name for gym.make; `asset` that of all episodes, or 'all' if they are of several.

    Layout: `data/demo_i/{obs/point_cloud (T, P, 4) float16, obs/proprio (T, 9) float32, actions and executed (T, 7)
    float32, joint (T,) float32, rewards (T,) float32 and dones (T,) uint8: 1 at the end}`, uncompressed so that
    training can map it; attributes as in robomimic, which reads the file as it is. Each demo names its asset, joint
    and nominal size; `env_args` are those of the first; `randomise` are the ranges that a randomised object was drawn
    from, beside `task_options`, which evaluation takes over.
    """
    first = episodes[0]
    kwargs = {"asset": first.asset, "joint": first.joint, "size": list(first.size)}
    env_args = {"env_name": environment, "type": 2, "env_kwargs": kwargs}  # robomimic's EnvType.GYM_TYPE
    with write_atomically(path) as temporary, h5py.File(temporary, "w", track_order=True) as file:
        data = file.create_group("data", track_order=True)
        data.attrs["env_args"] = json.dumps(env_args, sort_keys=True)
        data.attrs["total"] = sum(len(episode.actions) for episode in episodes)
        data.attrs["task"] = task
        data.attrs["asset"] = asset
        data.attrs["task_options"] = options.model_dump_json()
        if randomise:
            data.attrs["randomise"] = randomise.model_dump_json()
        for index, episode in enumerate(episodes):
            group = data.create_group(f"demo_{index}")
            group.attrs["num_samples"] = len(episode.actions)
            group.attrs["seed"] = episode.seed
            group.attrs["asset"], group.attrs["joint"] = episode.asset, episode.joint
            group.attrs["size"] = episode.size
            group.attrs["recovery"] = episode.recovery or "none"
            last = np.arange(len(episode.actions)) == len(episode.actions) - 1
            for name, values, dtype in (
                ("obs/point_cloud", episode.point_clouds, np.float16),
                ("obs/proprio", episode.proprios, np.float32),
                ("actions", episode.actions, np.float32),
                ("executed", episode.executed, np.float32),
                ("joint", episode.opened, np.float32),
                ("rewards", last, np.float32),
                ("dones", last, np.uint8),
            ):
                group.create_dataset(name, data=np.asarray(values, dtype), track_times=False)


Kind = Literal["push", "miss"]

# Ranges of DART-like disturbances; chosen.
PUSHED_WITHIN = (0.05, 0.35)  # metres before the grasp where a push begins; farther than the path is long: at its start
MISSED_WITHIN = (0.04, 0.09)  # where a miss begins: the fingertips, 1 cm ahead of that, have not reached the handle
PUSHES = (2, 4)  # least and most steps of a push; a miss begins with at most the least aside, ends with the most back
STRENGTH = (0.5, 0.9)  # of a push or pull, of a full step; it turns by no more than the less of a full step's turn


@dataclass
class Disturbance:
    """What happens to one episode: from `begins` metres before the grasp on, `actions` (K, 7) are executed instead."""

    kind: Kind
    begins: float
    actions: Float
    done: int = 0

    def apply(self, action: Float, ahead: float) -> Float:
        """What is executed in place of `action` (7,) with `ahead` metres left to the grasp."""
        if self.done == len(self.actions) or (self.done == 0 and ahead > self.begins):
            return action
        self.done += 1
        return self.actions[self.done - 1]


def sample_disturbance(rng: np.random.Generator, share: float) -> Disturbance | None:
    """With probability `share` one of both kinds, drawn from `rng`."""
    if rng.random() >= share:
        return None
    if rng.random() < 0.5:
        steps = _make_steps(rng, int(rng.integers(PUSHES[0], PUSHES[1] + 1)), gripper=OPEN)
        return Disturbance("push", float(rng.uniform(*PUSHED_WITHIN)), steps)
    aside = _make_steps(rng, int(rng.integers(PUSHES[0] + 1)), gripper=OPEN)
    closing = np.zeros((CLOSE_STEPS, 7), np.float32)
    closing[:, 6] = CLOSED
    pull = _make_steps(rng, int(rng.integers(PUSHES[1] + 1)), gripper=CLOSED, backwards=True)
    return Disturbance("miss", float(rng.uniform(*MISSED_WITHIN)), np.concatenate([aside, closing, pull]))


def _make_steps(rng: np.random.Generator, count: int, gripper: float, backwards: bool = False) -> Float:
    """(count, 7) equal steps in one random direction; towards the robot if `backwards`, else hardly forwards."""
    direction = rng.standard_normal(3)
    direction[0] = -2.0 * abs(direction[0]) - 0.5 if backwards else min(direction[0], 0.2)
    direction *= rng.uniform(*STRENGTH) / np.linalg.norm(direction)
    turn = rng.uniform(-STRENGTH[0], STRENGTH[0], 3) / np.sqrt(3)
    return np.tile(np.array([*direction, *turn, gripper], np.float32), (count, 1))


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
        episode.recovery = disturbance.kind if disturbance else None

        def act(action: Float, noisy: bool, ahead: float = FAR) -> None:
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
