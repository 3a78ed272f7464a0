"""Episodes of a policy on one asset, several environments in step."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stages.policies import ActorProtocol
from stages.tasks.api import Observation, TaskEnv

Image = NDArray[np.uint8]

FILMED = 6  # episodes per asset that are filmed: mostly enough for a success and a failure


@dataclass
class RolloutEpisode:
    """One rollout. `opened`: fraction of the joint's range at the end; `pictures`: empty if it was not filmed."""

    seed: int
    success: bool = False
    steps: int = 0
    opened: float = 0.0
    pictures: list[Image] = field(default_factory=list)


def roll_out(
    tasks: Sequence[TaskEnv], actor: ActorProtocol, seeds: Sequence[int], film_every: int
) -> list[RolloutEpisode]:
    """One episode per seed, in their order; an episode ends at success or after `max_steps`.

    `film_every`: steps between pictures of the first `FILMED` episodes, 0 for none.
    """
    episodes = [RolloutEpisode(seed) for seed in seeds]
    waiting = list(enumerate(episodes))
    running: dict[int, tuple[RolloutEpisode, bool]] = {}  # slot -> its episode, and whether it is filmed
    observations: dict[int, Observation] = {}

    def start(slot: int) -> None:
        running.pop(slot, None)
        if waiting:
            index, episode = waiting.pop(0)
            running[slot] = episode, film_every > 0 and index < FILMED
            observations[slot] = tasks[slot].reset(episode.seed)
            actor.reset(slot, episode.seed)

    for slot in range(len(tasks)):
        start(slot)
    while running:
        slots = list(running)
        actions = actor.act(
            slots,
            [observations[slot]["point_cloud"] for slot in slots],
            [observations[slot]["proprio"] for slot in slots],
        )
        for slot, action in zip(slots, actions, strict=True):
            episode, filmed = running[slot]
            if filmed and episode.steps % film_every == 0:
                episode.pictures.append(tasks[slot].picture())
            result = tasks[slot].step(action)
            observations[slot] = result.observation
            episode.success, episode.opened = result.success, result.opened
            episode.steps += 1
            if result.done:
                if filmed:
                    episode.pictures.append(tasks[slot].picture())
                start(slot)
    return episodes
