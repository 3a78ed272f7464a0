"""Snapshots of a library beside raw SAPIEN: the same pictures of the same models, nothing done with them.

    python -m benchmarks.snapshots --library results/assets/library/library.json

Raw: load the model, turn it, update the scene, take the picture, fetch color and position. Ours: `Turntable`, which
also cleans and scales them, and the file they are packed into. CPU seconds of one thread, model by model in turn.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import math
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from benchmarks.tables import table
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.assets.snapshots import PACKED, Turntable, largest_extent
from roomkin.stages.config.assets import SnapshotOptions
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.simulation.loading import load_visual, move, remove, root_pose

PARTS = ["SAPIEN: loading", "SAPIEN: pictures", "ours: `photograph`", "ours: packing"]


def time_sapien(turntable: Turntable, folder: Path, yaws: list[float]) -> dict[str, float]:
    """CPU seconds of what SAPIEN alone does: loading, rendering."""
    asset, clock = read_asset(folder), time.process_time
    started = clock()
    body = load_visual(turntable.scene, folder, turntable.unit / largest_extent(asset))
    loaded = clock()
    camera = turntable.camera._component
    for yaw in yaws:
        move(body, root_pose(asset, (0.0, 0.0, 0.0), yaw, turntable.unit / largest_extent(asset)))
        turntable.scene.update_render()
        camera.take_picture()
        camera.get_picture("Color")
        camera.get_picture("PositionSegmentation")
    rendered = clock()
    remove(turntable.scene, body)
    return {"SAPIEN: loading": loaded - started, "SAPIEN: pictures": rendered - loaded}


def time_turntable(turntable: Turntable, folder: Path, yaws: list[float], file: h5py.File) -> dict[str, float]:
    """CPU seconds of `Turntable.photograph` and of packing."""
    clock = time.process_time
    started = clock()
    rgb, depth = turntable.photograph(folder, yaws)
    taken = clock()
    for name, pictures in (("rgb", rgb), ("depth", depth)):
        file.create_dataset(f"{folder.name}/{name}", data=pictures, chunks=(1, *pictures.shape[1:]), **PACKED)
    return {"ours: `photograph`": taken - started, "ours: packing": clock() - taken}


def time_parts(folders: list[Path], size: int) -> dict[str, float]:
    """Seconds in all, by part."""
    turntable = Turntable(SnapshotOptions(image_size=size))
    yaws = [2 * math.pi * k / 24 for k in range(24)] + [-0.5]
    time_sapien(turntable, folders[0], yaws)  # shaders are compiled
    seconds: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as scratch, h5py.File(Path(scratch) / "shard.h5", "w") as file:
        for number, folder in enumerate(folders):
            parts: list[Callable[[], dict[str, float]]] = [
                lambda: time_sapien(turntable, folder, yaws),  # noqa: B023
                lambda: time_turntable(turntable, folder, yaws, file),  # noqa: B023
            ]
            for part in parts[:: 1 if number % 2 else -1]:
                for name, spent in part().items():
                    seconds[name] = seconds.get(name, 0.0) + spent
    return seconds


def rows(folders: list[Path], sizes: list[int]) -> Iterator[list[Any]]:
    """One row per size of the pictures."""
    for size in sizes:
        seconds = time_parts(folders, size)
        pictures = 25 * len(folders)
        theirs = seconds["SAPIEN: loading"] + seconds["SAPIEN: pictures"]
        whole = seconds["ours: `photograph`"] + seconds["ours: packing"]
        each = [f"{1000 * seconds[part] / pictures:.2f}" for part in PARTS]
        yield [size, *each, f"{pictures / theirs:.0f}", f"{pictures / whole:.0f}", f"**{theirs / whole:.2f}**"]


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--library", type=Path, required=True)
    parser.add_argument("--models", type=int, default=30, help="so many, evenly over the library")
    parser.add_argument("--sizes", type=int, nargs="+", default=[192, 256])
    asked = parser.parse_args()
    folders = AssetFolders(asked.library)
    assets = list(folders)
    chosen = [assets[k] for k in np.linspace(0, len(assets) - 1, min(asked.models, len(assets))).round().astype(int)]
    heading = ["pixels", *(f"{part} (ms each)" for part in PARTS)]
    heading += ["raw, per CPU s", "ours, per CPU s", "ours of raw"]
    table(heading, rows([folders[asset] for asset in chosen], asked.sizes))


if __name__ == "__main__":
    main()
