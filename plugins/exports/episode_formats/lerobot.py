"""LeRobotDataset v3.0: frames of many episodes in one parquet file, relational metadata beside it, clouds as arrays."""

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from plugins.exports.episode_formats import Demonstration, demonstrations
from stages.contracts import InputError, write_json
from stages.plugins import load

try:
    import pyarrow
    from pyarrow import parquet
except ImportError:
    what = "is missing: LeRobot data sets are parquet files."
    raise InputError("pyarrow", what, "make setup", code="E-PACKAGE-MISSING") from None

FILES_PER_CHUNK, FILE_MB = 1000, 100
DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
PROPRIO_NAMES = ["x", "y", "z", "qw", "qx", "qy", "qz", "finger_1", "finger_2"]
ACTION_NAMES = ["dx", "dy", "dz", "turn_x", "turn_y", "turn_z", "gripper"]
Columns = dict[str, NDArray[Any]]
Stats = dict[str, dict[str, NDArray[Any]]]


class FrameFiles:
    """Parquet files of at most `FILE_MB`; an episode is never cut."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.number, self.size = folder, -1, 0
        self.writer: parquet.ParquetWriter | None = None

    def add(self, columns: Columns) -> tuple[int, int]:
        """Write the frames of an episode; indices of the chunk and the file that they are in."""
        table = pyarrow.table({name: arrow(array) for name, array in columns.items()})
        if self.writer is None or self.size + table.nbytes > FILE_MB * 2**20:
            self.close()
            self.number, self.size = self.number + 1, 0
            chunk, file = divmod(self.number, FILES_PER_CHUNK)
            path = self.folder / DATA.format(chunk_index=chunk, file_index=file)
            path.parent.mkdir(parents=True, exist_ok=True)
            self.writer = parquet.ParquetWriter(path, table.schema, compression="snappy")
        self.writer.write_table(table)
        self.size += table.nbytes
        return divmod(self.number, FILES_PER_CHUNK)

    def close(self) -> None:
        """Finish the file that is open."""
        if self.writer:
            self.writer.close()


def write(stores: Sequence[Path], out: Path, library: Path | None) -> None:
    """Write the folders `data` and `meta` into `out`, in place of any that are there."""
    for name in ("data", "meta"):
        shutil.rmtree(out / name, ignore_errors=True)
    files, tasks, rows, total = FrameFiles(out), dict[str, int](), list[dict[str, Any]](), list[Stats]()
    features: dict[str, Any] = {}
    fps = frames = 0
    for number, demo in enumerate(demonstrations(stores)):
        task = instruction(demo)
        columns = columns_of(demo, number, frames, tasks.setdefault(task, len(tasks)))
        found, frequency = features_of(columns), demo.store.task_options.control_frequency
        if number and (found, frequency) != (features, fps):
            what = "has clouds of another size, or another frequency, than the first store."
            raise InputError(demo.asset, what, code="E-EPISODES-MIXED")
        features, fps = found, frequency
        chunk, file = files.add(columns)
        total.append(statistics(columns))
        rows.append(
            {"episode_index": number, "tasks": [task], "length": len(demo.actions), "data/chunk_index": chunk,
             "data/file_index": file, "dataset_from_index": frames, "dataset_to_index": frames + len(demo.actions),
             "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0, "asset": demo.asset}
            | {f"stats/{key}/{name}": x.tolist() for key, each in total[-1].items() for name, x in each.items()}
        )  # fmt: skip
        frames += len(demo.actions)
    files.close()
    (out / EPISODES).parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pyarrow.Table.from_pylist(rows), out / EPISODES)
    pd.DataFrame({"task_index": list(tasks.values())}, index=list(tasks)).to_parquet(out / "meta/tasks.parquet")
    write_json(out / "meta/stats.json", merge_statistics(total))
    write_json(
        out / "meta/info.json",
        {
            "codebase_version": "v3.0",
            "robot_type": "panda",
            "total_episodes": len(rows),
            "total_frames": frames,
            "total_tasks": len(tasks),
            "chunks_size": FILES_PER_CHUNK,
            "data_files_size_in_mb": FILE_MB,
            "video_files_size_in_mb": 200,
            "fps": fps,
            "splits": {"train": f"0:{len(rows)}"},
            "data_path": DATA,
            "video_path": None,
            "features": features,
        },
    )


def instruction(demo: Demonstration) -> str:
    """The task in words, from its name for `gym.make`: ACDC-OpenDoor-v1 -> open door."""
    name = load("tasks", demo.store.task).gym_id.split("-")
    return " ".join(re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+", name[1] if len(name) > 1 else name[0])).lower()


def columns_of(demo: Demonstration, episode: int, first: int, task: int) -> Columns:
    """The columns of an episode's frames; `first` is the index of its first frame in the whole data set."""
    frame = np.arange(len(demo.actions))
    return {
        "observation.state": demo.proprio,
        "observation.point_cloud": demo.clouds.astype(np.float32),
        "action": demo.actions,
        "next.reward": (frame == frame[-1]).astype(np.float32),
        "next.done": frame == frame[-1],
        "timestamp": (frame / demo.store.task_options.control_frequency).astype(np.float32),
        "frame_index": frame,
        "episode_index": np.full_like(frame, episode),
        "index": first + frame,
        "task_index": np.full_like(frame, task),
    }


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
