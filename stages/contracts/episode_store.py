"""Demonstrations as files: attempts.jsonl, a document a line, and episodes.h5, in robomimic's layout."""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from roomkin.stages.contracts.arrays import check_array, check_within, dataset, explain_unreadable
from roomkin.stages.contracts.errors import InputError, first_error
from roomkin.stages.contracts.files import read_lines
from roomkin.stages.contracts.policies import Attempt
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.trained import MetricsLine
from roomkin.stages.contracts.types import LARGEST

AGAIN, TRAIN = "collect the demonstrations again", "train the policy again"
disordered = partial(InputError, code="E-LEDGER-ORDER")


def read_attempts(path: Path) -> list[Attempt]:
    """attempts.jsonl: numbered from 0 without gaps, and so are the episodes that were kept.

    Raises:
        InputError: it is missing or empty, or a line is broken or out of order.
    """
    attempts = read_lines(Attempt, path, AGAIN)
    kept = 0
    for number, attempt in enumerate(attempts):
        if attempt.attempt != number:
            raise disordered(f"{path}:{number + 1}", f"attempt: is {attempt.attempt}, not {number}.", AGAIN)
        if attempt.episode is not None:
            if attempt.episode != kept or not attempt.success:
                why = f"{kept} successes were kept before" if attempt.success else "the attempt did not succeed"
                raise disordered(f"{path}:{number + 1}", f"episode: is {attempt.episode}, but {why}.", AGAIN)
            kept += 1
    return attempts


def read_metrics(path: Path) -> list[dict[str, float | None]]:
    """The lines of metrics.jsonl: finite numbers by name, among them a growing `step`.

    Raises:
        InputError: it is missing or empty, or a line is broken (file and line named).
    """
    lines = [line.root for line in read_lines(MetricsLine, path, TRAIN)]
    for number, (one, next) in enumerate(pairwise(lines), 2):
        if next["step"] <= one["step"]:  # type: ignore[operator]
            raise disordered(f"{path}:{number}", f"step: {next['step']} comes after {one['step']}.", TRAIN)
    return lines


ACTION, PROPRIO = 7, 9
QUATERNION, UNIT = slice(3, 7), 0.01  # columns of proprioception, and how far their norm may be off 1
LIMIT = 1.001  # actions are within [-1, 1], but for rounding
Float = NDArray[np.float32]
broken = partial(InputError, fix=AGAIN, code="E-EPISODES-BROKEN")


@dataclass(frozen=True)
class EpisodeStore:
    """Per episode (T, P, 4) float16 clouds, (T, 9) proprioception and (T, 7) actions, float32; robot frame, metres.

    asset: that of all episodes, or 'all'. assets: of each.
    """

    task: str
    asset: str
    assets: list[str]
    task_options: TaskConfig
    episodes: list[tuple[NDArray[np.float16], Float, Float]]


def read_episodes(path: Path, count: int | None = None) -> EpisodeStore:
    """The first `count` episodes of a store (None: all).

    Raises:
        InputError: it is missing or broken, has too few episodes, arrays of another shape or of unequal lengths, or
            values that are not finite or out of bounds.
    """
    with explain_unreadable(path, "episode store", AGAIN), h5py.File(path, "r") as file:
        data = file.get("data")
        if not isinstance(data, h5py.Group):
            raise broken(path, "has no group 'data'.")
        about = {name: _attribute(path, "data", data, name) for name in ("task", "asset", "task_options")}
        try:
            options = TaskConfig.model_validate_json(about["task_options"])
        except ValidationError as error:
            raise broken(path, f"task_options: {first_error(error)}.") from None
        if count is not None and len(data) < count:
            what = f"has {len(data)} episodes, {count} are asked for."
            raise InputError(path, what, "collect more demonstrations", code="E-EPISODES-FEW")
        if not len(data):
            raise InputError(path, "has no episodes.", AGAIN, code="E-EPISODES-FEW")
        names = [f"demo_{i}" for i in range(count or len(data))]
        episodes = [_episode(path, data, name, options.points) for name in names]
        assets = [_attribute(path, name, data[name], "asset") for name in names]
    return EpisodeStore(about["task"], about["asset"], assets, options, episodes)


def _attribute(path: Path, where: str, group: h5py.Group, name: str) -> str:
    value = group.attrs.get(name)
    if not isinstance(value, str) or not value:
        raise broken(path, f"{where}: has no text attribute '{name}'.")
    return value


def _episode(path: Path, data: h5py.Group, name: str, points: int) -> tuple[NDArray[np.float16], Float, Float]:
    demo = data.get(name)
    if not isinstance(demo, h5py.Group):
        raise broken(path, f"has no episode '{name}'.")
    actions = dataset(path, demo, "actions", AGAIN)
    steps = actions.shape[0] if actions.shape else 0
    if not steps:
        raise broken(path, f"{name}/actions: is empty.")
    arrays: list[Any] = []
    for key, shape, bound in (
        ("obs/point_cloud", (steps, points, 4), LARGEST),
        ("obs/proprio", (steps, PROPRIO), LARGEST),
        ("actions", (steps, ACTION), LIMIT),
    ):
        found = dataset(path, demo, key, AGAIN)
        check_array(path, f"{name}/{key}", found, shape, "f", AGAIN)
        arrays.append(found[()])
        check_within(path, f"{name}/{key}", arrays[-1], -bound, bound, AGAIN)
    clouds, proprio, actions = arrays
    if (np.abs(np.linalg.norm(proprio[:, QUATERNION], axis=1) - 1) > UNIT).any():
        raise broken(path, f"{name}/obs/proprio: holds quaternions (columns 3 to 6) that are no turns.")
    return clouds.astype(np.float16), proprio.astype(np.float32), actions.astype(np.float32)


def check_episodes(path: Path) -> None:
    """All episodes, and that attempts.jsonl beside them, if it is there, counts as many."""
    store = read_episodes(path)
    ledger = path.with_name("attempts.jsonl")
    if ledger.is_file():
        kept = sum(attempt.episode is not None for attempt in read_attempts(ledger))
        if kept != len(store.episodes):
            raise broken(path, f"has {len(store.episodes)} episodes, {ledger.name} counts {kept}.")
