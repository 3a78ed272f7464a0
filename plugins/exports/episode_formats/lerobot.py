"""LeRobotDataset v3.0: the frames of all episodes in one parquet file, relational metadata beside it."""

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError, write_json
from roomkin.stages.contracts.episode_store import EpisodeStore, read_episodes
from roomkin.stages.plugins import load

try:
    import pyarrow
    from pyarrow import parquet
except ImportError:
    what = "is missing: LeRobot data sets are parquet files."
    raise InputError("pyarrow", what, "make setup", code="E-PACKAGE-MISSING") from None

DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
PROPRIO_NAMES = ["x", "y", "z", "qw", "qx", "qy", "qz", "finger_1", "finger_2"]
ACTION_NAMES = ["dx", "dy", "dz", "turn_x", "turn_y", "turn_z", "gripper"]
Columns = dict[str, NDArray[Any]]
Episode = tuple[NDArray[np.float16], NDArray[np.float32], NDArray[np.float32]]  # clouds, proprioception, actions
Stats = dict[str, dict[str, NDArray[Any]]]


def write(stores: Sequence[Path], out: Path, library: Path | None) -> None:
    """Write the folders `data` and `meta` into `out`, in place of any that are there."""
    for name in ("data", "meta"):
        shutil.rmtree(out / name, ignore_errors=True)
    for name in (DATA, EPISODES):
        (out / name).parent.mkdir(parents=True)
    tasks, rows, total = dict[str, int](), list[dict[str, Any]](), list[Stats]()
    writer, frames = None, 0
    try:
        for path in stores:
            store = read_episodes(path)
            task = instruction(store)
            for asset, episode in zip(store.assets, store.episodes, strict=True):
                columns = columns_of(store, episode, len(rows), frames, tasks.setdefault(task, len(tasks)))
                table = pyarrow.table({name: arrow(array) for name, array in columns.items()})
                if writer is None:
                    features, fps = features_of(columns), store.task_options.control_frequency
                    writer = parquet.ParquetWriter(out / DATA, table.schema, compression="snappy")
                if (features_of(columns), store.task_options.control_frequency) != (features, fps):
                    what = "has clouds of another size, or another frequency, than the first store."
                    raise InputError(path, what, code="E-EPISODES-MIXED")
                writer.write_table(table)
                total.append(statistics(columns))
                rows.append(
                    {"episode_index": len(rows), "tasks": [task], "length": len(table), "data/chunk_index": 0,
                     "data/file_index": 0, "dataset_from_index": frames, "dataset_to_index": frames + len(table),
                     "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0, "asset": asset}
                    | {f"stats/{key}/{name}": x.tolist() for key, each in total[-1].items() for name, x in each.items()}
                )  # fmt: skip
                frames += len(table)
    finally:
        if writer:
            writer.close()
    parquet.write_table(pyarrow.Table.from_pylist(rows), out / EPISODES)
    pd.DataFrame({"task_index": list(tasks.values())}, index=list(tasks)).to_parquet(out / "meta/tasks.parquet")
    write_json(out / "meta/stats.json", merge_statistics(total))
    write_json(
        out / "meta/info.json",
        {
            "codebase_version": "v3.0", "robot_type": "panda", "total_episodes": len(rows), "total_frames": frames,
            "total_tasks": len(tasks), "chunks_size": 1000, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200,
            "fps": fps, "splits": {"train": f"0:{len(rows)}"},
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet", "video_path": None,
            "features": features,
        },
    )  # fmt: skip


def instruction(store: EpisodeStore) -> str:
    """The task in words, from its name for `gym.make`: ACDC-OpenDoor-v1 -> open door."""
    name = load("tasks", store.task).gym_id.split("-")
    return " ".join(re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+", name[1] if len(name) > 1 else name[0])).lower()


def columns_of(store: EpisodeStore, arrays: Episode, episode: int, first: int, task: int) -> Columns:
    """The columns of an episode's frames; `first` is the index of its first frame in the whole data set."""
    clouds, proprio, actions = arrays
    frame = np.arange(len(actions))
    return {
        "observation.state": proprio, "observation.point_cloud": clouds.astype(np.float32), "action": actions,
        "next.reward": (frame == frame[-1]).astype(np.float32), "next.done": frame == frame[-1],
        "timestamp": (frame / store.task_options.control_frequency).astype(np.float32), "frame_index": frame,
        "episode_index": np.full_like(frame, episode), "index": first + frame, "task_index": np.full_like(frame, task),
    }  # fmt: skip


def features_of(columns: Columns) -> dict[str, Any]:
    """The `features` of info.json."""
    names = {
        "observation.state": PROPRIO_NAMES,
        "action": ACTION_NAMES,
        "observation.point_cloud": ["point", "x_y_z_finger"],
    }
    return {
        key: {"dtype": str(array.dtype), "shape": list(array.shape[1:]) or [1], "names": names.get(key)}
        for key, array in columns.items()
    }


def arrow(array: NDArray[Any]) -> pyarrow.Array:
    """(T,) as numbers, (T, n) as lists of fixed length, (T, P, 4) as lists of lists."""
    if array.ndim == 1:
        return pyarrow.array(array)
    values = pyarrow.array(array.reshape(-1))
    if array.ndim == 2:
        return pyarrow.FixedSizeListArray.from_arrays(values, array.shape[1])
    for length in array.shape[:0:-1]:
        ends = np.arange(0, len(values) + 1, length, dtype=np.int32)
        values = pyarrow.ListArray.from_arrays(ends, values)
    return values


def statistics(columns: Columns) -> Stats:
    """Of an episode, per number of a vector and per coordinate of a cloud."""
    stats = {}
    for key, array in columns.items():
        flat = array.reshape(-1, array.shape[-1] if array.ndim > 1 else 1).astype(np.float64)
        values = {"min": flat.min(0), "max": flat.max(0), "mean": flat.mean(0), "std": flat.std(0)}
        stats[key] = values | {"count": np.array([len(array)])}
    return stats


def merge_statistics(episodes: Sequence[Stats]) -> dict[str, dict[str, list[float]]]:
    """Statistics of all episodes, as JSON."""
    stats = {}
    for key in episodes[0]:
        each = {name: np.stack([stats[key][name] for stats in episodes]) for name in episodes[0][key]}
        share = each["count"] / each["count"].sum()
        mean = (share * each["mean"]).sum(0)
        spread = (share * (each["std"] ** 2 + (each["mean"] - mean) ** 2)).sum(0)
        values = {"min": each["min"].min(0), "max": each["max"].max(0), "mean": mean, "std": np.sqrt(spread)}
        stats[key] = {name: x.tolist() for name, x in values.items()} | {"count": each["count"].sum(0).tolist()}
    return stats
