"""`collect`: run the skills until enough attempts succeed (paper A.5: rejection sampling)."""

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from importlib import import_module
from itertools import cycle
from pathlib import Path

import numpy as np

from roomkin.stages.cli import pacer
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import InputError, TaskAssets, read_json, read_options, write_text
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.policies import Attempt, TaskAsset
from roomkin.stages.contracts.policy_config import TaskConfig, is_randomised
from roomkin.stages.demonstrations.attempt import RecordedEpisode, Recorder, write_episodes
from roomkin.stages.tasks.api import EnvWrapper

TRIES = 3  # attempts on an asset before it is the next one's turn; chosen
FAILED_LEDGER = "attempts.failed.jsonl"  # not an output of the rule: Snakemake deletes those of a failed job


def run(
    *,
    assets: Path,
    library: Path,
    role: str,
    episodes: int,
    out: Path,
    options: str = "",
    task_options: str = "",
    films: tuple[str, ...] = (),
    seed: int = 0,
) -> None:
    """Write `episodes.h5` with as many successes as asked, with attempts.jsonl beside it.

    Several assets take turns of one success or `TRIES` failures, so that the first n episodes are spread evenly.

    If too few attempts succeed, only their ledger is kept, as attempts.failed.jsonl.

    Args:
        assets: the experiment's assets (contract TaskAssets).
        library: library.json that they come from.
        role: twin, cousin_1, ...; random_1, ..., cover_1, ...: of the assets that were drawn; all: the assets of
            `all_assets` take turns, nearest to the twin first. If it ends in _randomised, extents, friction and mass
            are drawn per attempt.
        episodes: successes to collect.
        out: episodes.h5 to write.
        options: the `demonstrations` section as JSON.
        task_options: the `task` section as JSON; stored in the episodes for evaluation.
        films: modules whose `film_demonstrations` films the first success, e.g. roomkin.plugins.films.writing.
        seed: of the first attempt; attempts and evaluation use disjoint seeds.
    """
    settings = read_options(DemonstrationsConfig, options)
    world = read_options(TaskConfig, task_options)
    plan, models = read_json(TaskAssets, assets), AssetFolders(library)
    wanted = plan.assets_of(role, assets)
    if gone := [entry.asset for entry in wanted if entry.asset not in models]:
        fix = "was the library rebuilt? run the stages after it again"
        raise InputError(library, f"has no asset {gone[0]!r}.", fix, code="E-LIBRARY-ASSET")
    chosen = [(models[entry.asset], entry) for entry in wanted]
    folder, entry = chosen[0]
    name = entry.asset if len(chosen) == 1 else role
    randomise = settings.randomise if is_randomised(role) else None
    task = EnvWrapper(plan.task, folder, entry.joint, entry.size, world, randomise=randomise)
    recorder = Recorder(task, settings, film=bool(films))
    seeds = list(attempt_seeds(seed, role, int(np.ceil(episodes * settings.max_attempts_factor))))
    kept, ledger = take_turns(recorder, chosen, seeds, episodes)
    for module in films if len(kept) == episodes else ():
        import_module(module).film_demonstrations(out.parent, recorder.filmed, role, world.control_frequency)
    task.close()
    lines = "".join(line.model_dump_json() + "\n" for line in ledger)
    failed = out.parent / FAILED_LEDGER
    if len(kept) < episodes:
        write_text(failed, lines)
        causes = ", ".join(f"{cause} {count}" for cause, count in Counter(a.cause for a in ledger).most_common())
        what = f"only {len(kept)} of {episodes} demonstrations after {len(ledger)} attempts on {name} ({causes}); "
        what += f"{failed} lists them."
        fix = "raise demonstrations.max_attempts_factor, narrow the ranges of `task`, or choose another object"
        raise InputError(out, what, fix, code="E-DEMONSTRATIONS-FEW")
    failed.unlink(missing_ok=True)
    write_text(out.parent / "attempts.jsonl", lines)
    write_episodes(out, kept, plan.task, task.task.gym_id, name, world, randomise)


def take_turns(
    recorder: Recorder, chosen: Sequence[tuple[Path, TaskAsset]], seeds: Sequence[int], episodes: int
) -> tuple[list[RecordedEpisode], list[Attempt]]:
    """Attempts on the chosen assets in turn, until there are as many successes as asked or no seeds left."""
    kept: list[RecordedEpisode] = []
    ledger: list[Attempt] = []
    due = pacer()
    for folder, entry in cycle(chosen):
        recorder.task.turn_to(folder, entry.joint, entry.size)
        for attempt_seed in seeds[len(ledger) : len(ledger) + TRIES]:
            episode, outcome = recorder.attempt(attempt_seed)
            line = Attempt(
                attempt=len(ledger), asset=entry.asset, seed=attempt_seed, success=outcome.success, cause=outcome.cause,
                recovery=episode.recovery, retries=outcome.retries, steps=len(episode.actions),
                opened=round(recorder.task.opened, 4), episode=len(kept) if outcome.success else None,
            )  # fmt: skip
            ledger.append(line)
            if outcome.success:
                kept.append(episode)
                if due() or len(kept) == episodes:
                    print(f"demonstrations: {len(kept)}/{episodes} from {len(ledger)} attempts", file=sys.stderr)
                break
        if len(kept) == episodes or len(ledger) == len(seeds):
            break
    return kept, ledger


def attempt_seeds(seed: int, role: str, count: int) -> Iterator[int]:
    """Seeds of the attempts, different for every role: below 2**31, as evaluation's are not (they start there)."""
    entropy = (seed, *role.encode())
    yield from np.random.default_rng(np.random.SeedSequence(entropy)).integers(0, 2**31, count).tolist()
