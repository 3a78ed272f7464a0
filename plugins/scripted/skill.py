"""Command `skill`: success of the scripted skill on the test assets of the policies, as an upper reference."""

import sys
from pathlib import Path

from roomkin.stages.config.evaluation import SkillOptions
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.files import read_options
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.evaluation.states import Start, starts_of, write_rows
from roomkin.stages.evaluation.vector_env import Acting, RolloutEpisode, VectorEnv
from roomkin.stages.skills import FAR, Float
from roomkin.stages.skills.motion import SkillChain
from roomkin.stages.tasks.api import EnvWrapper


def run(
    *,
    assets: Path,
    library: Path,
    target: str,
    out: Path,
    options: str = "",
    skill_options: str = "",
    task_options: str = "",
    seed: int = 0,
) -> None:
    """Do a task by its skills from the states of `evaluation rollout`, without noise and disturbances.

    It knows the true model. The test asset `trained` is left out.

    Args:
        assets: the experiment's assets (contract TaskAssets).
        library: library.json that they come from.
        target: what is opened, by its name in the experiment, for the rows.
        out: rollouts.csv; policy and training_set are `skill`, run `scripted`, checkpoint `none`.
        options: the `evaluation` section as JSON, or a JSON file.
        skill_options: the `demonstrations` section, likewise.
        task_options: the `task` section, likewise.
        seed: of the initial states.
    """
    settings, world = read_options(SkillOptions, options), read_options(TaskConfig, task_options)
    rows: list[Rollout] = []
    with VectorEnv(assets, library, world, settings) as envs:
        (task,) = envs.tasks(1, envs.plan.assets[0])
        skill = SkillChain(task, read_options(DemonstrationsConfig, skill_options))
        for test_asset, starts in starts_of(envs.plan, assets, settings, (), seed).items():
            episodes = [play(envs, task, skill, start) for start in starts]
            successes = sum(episode.success for episode in episodes)
            print(f"evaluation: {test_asset} {successes}/{len(starts)}", file=sys.stderr)
            rows += envs.rows(Acting(target, "skill", "skill", "scripted", 0, "none"), test_asset, episodes)
    write_rows(out, rows)


def play(envs: VectorEnv, task: EnvWrapper, skill: SkillChain, start: Start) -> RolloutEpisode:
    """One attempt; as for policies, it is over at the first success."""
    asset, seed = envs.size_asset(start[0]), start[1]
    episode = RolloutEpisode(asset, seed)
    task.turn_to(envs.folder(asset), asset.joint, asset.size)
    task.place(seed)

    def act(action: Float, noisy: bool, ahead: float = FAR) -> None:
        task.act(action)
        if not episode.success:
            episode.success, episode.official_success = task.success, task.official_success
            episode.steps, episode.opened = task.steps, task.opened

    skill.run(act)
    return episode
