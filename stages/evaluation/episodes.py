"""Episodes of a policy, several environments in step, each with an asset of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.evaluation.states import Start
from roomkin.stages.policies.base import RolloutPolicy
from roomkin.stages.simulation.recording import Moment, Recording
from roomkin.stages.tasks.api import EnvWrapper, Observation


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
    tasks: Sequence[EnvWrapper],
    folders: Mapping[str, Path],
    policy: RolloutPolicy,
    starts: Sequence[Start],
    record: bool = False,
) -> list[RolloutEpisode]:
    """One episode per start, in their order; an episode ends at success or after `max_steps`.

    `folders`: of the assets, by id. An environment that is free takes the next start, whatever its asset.
    """
    episodes = [RolloutEpisode(asset, seed) for asset, seed in starts]
    waiting = list(episodes)
    running: dict[int, RolloutEpisode] = {}  # by environment
    observations: dict[int, Observation] = {}

    def start(env_id: int) -> None:
        running.pop(env_id, None)
        if waiting:
            running[env_id] = episode = waiting.pop(0)
            tasks[env_id].turn_to(folders[episode.asset.asset], episode.asset.joint, episode.asset.size)
            observations[env_id] = tasks[env_id].reset(episode.seed)
            policy.start_episode(env_id, episode.seed)

    def note(env_id: int) -> None:
        if record:
            running[env_id].moments.append(tasks[env_id].env.moment())

    for env_id in range(len(tasks)):
        start(env_id)
    while running:
        env_ids = list(running)
        actions = policy.get_action(
            env_ids,
            [observations[env_id]["point_cloud"] for env_id in env_ids],
            [observations[env_id]["proprio"] for env_id in env_ids],
        )
        for env_id, action in zip(env_ids, actions, strict=True):
            note(env_id)
            episode, result = running[env_id], tasks[env_id].step(action)
            observations[env_id] = result.observation
            episode.success, episode.official_success = result.success, result.official_success
            episode.opened = result.opened
            episode.steps += 1
            if result.done:
                note(env_id)
                if record:
                    episode.recording = tasks[env_id].env.recording(episode.moments)
                start(env_id)
    return episodes
