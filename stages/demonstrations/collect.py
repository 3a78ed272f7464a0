"""`collect`: run the Open skill until enough attempts succeed (paper A.5: rejection sampling)."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stages.config.demonstrations import DemonstrationsConfig
from stages.config.task import TaskConfig
from stages.contracts import InputError, Library, TaskAssets, read_json, read_options, write_text
from stages.contracts.policies import Attempt
from stages.demonstrations.attempt import Recorder
from stages.demonstrations.film import write_demonstration_films
from stages.demonstrations.store import RecordedEpisode, StoreHeader, write_episodes
from stages.tasks.api import make_task

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
    seed: int = 0,
) -> None:
    """Write `episodes.h5` with as many successes as asked, and beside it attempts.jsonl, film.png and films/.

    If there are too few, the ledger alone is left, as attempts.failed.jsonl.

    Args:
        assets: the experiment's assets (contract TaskAssets).
        library: library.json that they come from.
        role: twin, cousin_1, ...
        episodes: successes to collect.
        out: episodes.h5 to write.
        options: the `demonstrations` section as JSON.
        task_options: the `task` section as JSON; stored in the episodes for evaluation.
        seed: of the first attempt; attempts and evaluation use disjoint seeds.
    """
    settings = read_options(DemonstrationsConfig, options)
    world = read_options(TaskConfig, task_options)
    plan = read_json(TaskAssets, assets)
    chosen = plan.playing(role, assets)
    folder = asset_folder(read_json(Library, library), chosen.asset, library)
    task = make_task(plan.task, folder, chosen.joint, chosen.size, world)
    recorder = Recorder(task, settings, film=settings.film_episodes)
    kept: list[RecordedEpisode] = []
    ledger: list[Attempt] = []
    allowed = int(np.ceil(episodes * settings.max_attempts_factor))
    for attempt_seed in attempt_seeds(seed, role, allowed):
        if len(kept) == episodes:
            break
        episode, outcome = recorder.attempt(attempt_seed)
        if outcome.success:
            kept.append(episode)
        ledger.append(
            Attempt(
                attempt=len(ledger),
                seed=attempt_seed,
                success=outcome.success,
                cause=outcome.cause,
                recovery=episode.recovery,
                retries=outcome.retries,
                steps=len(episode.actions),
                opened=round(task.opened, 4),
                episode=len(kept) - 1 if outcome.success else None,
            )
        )
        recorder.report(len(kept), episodes, len(ledger))
    if len(kept) == episodes:
        write_demonstration_films(out.parent, recorder.taken, role, chosen.asset, world.control_frequency)
    task.close()
    lines = "".join(line.model_dump_json() + "\n" for line in ledger)
    failed = out.parent / FAILED_LEDGER
    if len(kept) < episodes:
        write_text(failed, lines)
        causes = ", ".join(f"{cause} {count}" for cause, count in Counter(a.cause for a in ledger).most_common())
        raise InputError(
            out,
            f"only {len(kept)} of {episodes} demonstrations after {len(ledger)} attempts on {chosen.asset} ({causes}); "
            f"{failed} tells of each.",
            "raise demonstrations.max_attempts_factor, narrow the ranges of `task`, or choose another object",
        )
    failed.unlink(missing_ok=True)
    write_text(out.parent / "attempts.jsonl", lines)
    write_episodes(out, StoreHeader(plan.task, task.task.gym_id, chosen.asset, chosen.joint, chosen.size, world), kept)


def asset_folder(library: Library, asset: str, where: Path) -> Path:
    """Folder of an asset of a library."""
    for entry in library.assets:
        if entry.id == asset:
            return where.parent / entry.folder
    raise InputError(where, f"has no asset {asset!r}.", "was the library rebuilt? run the stages after it again")


def attempt_seeds(seed: int, role: str, count: int) -> Iterator[int]:
    """Seeds of the attempts, different for every role: below 2**31, as evaluation's are not (they start there)."""
    entropy = (seed, *role.encode())
    yield from np.random.default_rng(np.random.SeedSequence(entropy)).integers(0, 2**31, count).tolist()
