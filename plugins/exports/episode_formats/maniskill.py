"""ManiSkill trajectories: the episodes done again in the environment itself, recorded by ManiSkill's own wrapper."""

import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import h5py
import numpy as np
from mani_skill.utils.wrappers.record import RecordEpisode
from numpy.typing import NDArray

from roomkin.stages.articulated.resizing import resize_asset
from roomkin.stages.contracts import InputError, write_json
from roomkin.stages.contracts.episode_store import AGAIN, EpisodeStore, read_episodes
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.plugins import load

Trajectory = tuple[int, NDArray[np.float32]]  # seed and executed actions of an episode


class Subject(NamedTuple):
    """The subject of a file of trajectories: an asset, the joint that is opened, and the asset's nominal size.

    `randomise`: JSON of the ranges that the asset was drawn from, if it was randomised.
    """

    asset: str
    joint: str
    size: tuple[float, float, float]
    randomise: str


def write(stores: Sequence[Path], out: Path, library: Path | None) -> None:
    """Write `<asset>.h5` and `<asset>.json` per asset into the folder `out`; the assets lie in `out/assets`.

    The tools are run in `out`: there the files name their assets.
    """
    if library is None:
        what = "is missing: ManiSkill trajectories name the asset's folder."
        raise InputError("--library", what, code="E-OPTION-MISSING")
    folders = AssetFolders(library)
    found: dict[Subject, tuple[EpisodeStore, list[Trajectory]]] = {}
    for path in stores:
        store = read_episodes(path)
        for subject, trajectory in trajectories(path, len(store.episodes)):
            if subject.asset not in folders:
                what = f"is of '{subject.asset}', which the library does not have."
                raise InputError(path, what, AGAIN, code="E-LIBRARY-ASSET")
            found.setdefault(subject, (store, []))[1].append(trajectory)
    for subject, (store, episodes) in found.items():
        folder = resize_asset(folders[subject.asset], subject.size, out / "assets")
        if folder == folders[subject.asset]:
            folder = shutil.copytree(folder, out / "assets" / subject.asset, dirs_exist_ok=True)
        kept = record(out, folder, subject, store, episodes)
        print(f"exported: {kept} of {len(episodes)} episodes on {subject.asset} succeed again", file=sys.stderr)


def trajectories(path: Path, count: int) -> list[tuple[Subject, Trajectory]]:
    """Seed and executed actions of every episode of a store, and what it is about."""
    found = []
    with h5py.File(path, "r") as file:
        for index in range(count):
            demo, randomise = file[f"data/demo_{index}"], str(file["data"].attrs.get("randomise", ""))
            missing = {"seed", "asset", "joint", "size"} - set(demo.attrs) | {"executed"} - set(demo)
            if missing:
                what = f"demo_{index}: has no {', '.join(sorted(missing))}."
                raise InputError(path, what, AGAIN, code="E-EPISODES-ATTRIBUTE")
            x, y, z = (float(extent) for extent in demo.attrs["size"])
            subject = Subject(str(demo.attrs["asset"]), str(demo.attrs["joint"]), (x, y, z), randomise)
            found.append((subject, (int(demo.attrs["seed"]), np.asarray(demo["executed"][()], np.float32))))
    return found


def record(out: Path, folder: Path, subject: Subject, store: EpisodeStore, episodes: Sequence[Trajectory]) -> int:
    """Do the episodes again and record them; how many succeed."""
    options: dict[str, Any] = {
        "asset_folder": str(folder),
        "joint": subject.joint,
        "options": store.task_options.model_dump(mode="json"),
        "randomise": json.loads(subject.randomise) if subject.randomise else None,
        "obs_mode": "state",
        "render_backend": "none",
    }
    name = f"roomkin.stages.tasks:{load('tasks', store.task).gym_id}"
    made = gymnasium.make(name, **options)
    made.unwrapped.spec.kwargs.pop("task")  # type: ignore[union-attr]  # known by its registration, and no JSON
    env = RecordEpisode(
        made, str(out), save_video=False, trajectory_name=subject.asset, save_on_reset=False,
        source_type="motionplanning", source_desc="scripted skills of Roomkin",
    )  # fmt: skip
    kept = 0
    for seed, executed in episodes:
        env.reset(seed=seed)
        for action in executed:
            *_, info = env.step(action)
        kept += bool(info["success"].all())
        env.flush_trajectory()
    env.close()
    path = out / f"{subject.asset}.json"
    about = json.loads(path.read_text(encoding="utf-8"))
    about.pop("commit_info", None)
    about["env_info"]["env_id"] = name
    arguments = about["env_info"]["env_kwargs"]
    arguments["asset_folder"] = folder.relative_to(out).as_posix()  # so that what was exported can be sent elsewhere
    arguments.pop("render_backend", None)  # for whoever replays to choose
    write_json(path, about)
    return kept
