"""Episodes of a policy, several environments in step, each with an asset of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stages.contracts.policies import TaskAsset
from stages.evaluation.states import Start
from stages.policies import ActorProtocol
from stages.simulation.recording import Moment, Recording
from stages.tasks.api import Observation, TaskEnv


@dataclass
class RolloutEpisode:
    """One rollout. `opened`: fraction of the joint's range at the end; `recording`: None if it was not recorded."""

    asset: TaskAsset
    seed: int
    success: bool = False
    official_success: bool = False
    steps: int = 0
    opened: float = 0.0
    recording: Recording | None = None
    moments: list[Moment] = field(default_factory=list)


def roll_out(
    tasks: Sequence[TaskEnv],
    folders: Mapping[str, Path],
    actor: ActorProtocol,
    starts: Sequence[Start],
    record: bool = False,
) -> list[RolloutEpisode]:
    """One episode per start, in their order; an episode ends at success or after `max_steps`.

    `folders`: of the assets, by id. An environment that is free takes the next start, whatever its asset.
    """
    episodes = [RolloutEpisode(asset, seed) for asset, seed in starts]
    waiting = list(episodes)
    running: dict[int, RolloutEpisode] = {}  # slot -> its episode
    observations: dict[int, Observation] = {}

    def start(slot: int) -> None:
        running.pop(slot, None)
        if waiting:
            running[slot] = episode = waiting.pop(0)
            tasks[slot].turn_to(folders[episode.asset.asset], episode.asset.joint, episode.asset.size)
            observations[slot] = tasks[slot].reset(episode.seed)
            actor.reset(slot, episode.seed)

    def note(slot: int) -> None:
        if record:
            running[slot].moments.append(tasks[slot].moment())

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
            note(slot)
            episode, result = running[slot], tasks[slot].step(action)
            observations[slot] = result.observation
            episode.success, episode.official_success = result.success, result.official_success
            episode.opened = result.opened
            episode.steps += 1
            if result.done:
                note(slot)
                if record:
                    episode.recording = tasks[slot].recording(episode.moments)
                start(slot)
    return episodes
