"""Open3D beside other ways to the same thing: errors, speed, repeatability, cost of the import.

    snakemake --cores 2 scenes8
    python -m benchmarks.geometry --rooms results/scenes/* [--seeds 2]

Prints the tables of docs/results/extraction.md. One thread; about ten minutes for the eight rooms.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import hashlib
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.alternatives import (
    Points,
    numpy_farthest,
    open3d_box,
    open3d_free_plane,
    open3d_normals,
    open3d_plane,
    scipy_inliers,
    sklearn_dbscan,
)
from benchmarks.tables import table
from stages.config.extraction import DepthNoiseConfig, ExtractionConfig
from stages.contracts import Truth, read_json
from stages.extraction import levels, objects
from stages.extraction.contact import extend_to_wall
from stages.extraction.noise import noisy_depth
from stages.extraction.observation import read_folder
from stages.extraction.reconstruct import ExtractedScene, reconstruct
from stages.extraction.sources.folder import observe
from stages.geometry import room_planes
from stages.geometry.boxes import UprightBox, oriented_iou
from stages.geometry.clouds import dbscan, farthest_points, statistical_inliers
from stages.geometry.frames import apply, inverse, wrap_angle, yaw_of_matrix
from stages.geometry.minimum_box import minimum_box
from stages.geometry.planes import fit_plane
from stages.matching.crop import View, cut
from stages.matching.normals import patch_normals

GRID = 16  # patches of a view, for the normals
Row = list[object]


VARIANTS: dict[str, dict[tuple[Any, str], Any]] = {
    "as it is": {},
    "outliers by scipy": {(objects, "statistical_inliers"): scipy_inliers},
    "DBSCAN by scikit-learn": {(objects, "dbscan"): sklearn_dbscan},
    "planes by Open3D": {(room_planes, "fit_plane"): open3d_free_plane},
    "planes by Open3D, implausible ones taken away": {(room_planes, "fit_plane"): open3d_plane},
    "boxes by Open3D": {(levels, "minimum_box"): open3d_box},
}


def errors(result: ExtractedScene, truth: Truth) -> Iterator[tuple[float, float, float]]:
    """Per object: centre (cm), yaw modulo 90 degrees (NaN for symmetric ones), oriented IoU; boxes filled to walls."""
    world_from_floor = np.array(truth.world_from_camera) @ inverse(result.objects.floor_from_camera)
    turn = yaw_of_matrix(world_from_floor[:3, :3])
    walls = {wall.id: wall for wall in result.objects.walls}
    items = {item.mask: item for item in result.objects.objects}
    for true in truth.objects:
        item = items.get(true.mask)
        if item is None or item.box is None or item.mounting is None:
            yield np.nan, np.nan, 0.0
            continue
        box = UprightBox(item.box.center, item.box.size, item.box.yaw)
        if item.mounting.walls:
            box = extend_to_wall(box, walls[item.mounting.walls[0]])
        placed = UprightBox(apply(world_from_floor, box.center), box.size, box.yaw + turn)
        expected = UprightBox(true.position, true.size, true.yaw)
        off = abs(wrap_angle(placed.yaw - true.yaw, np.pi / 2)) if true.symmetry == "none" else np.nan
        distance = float(np.linalg.norm(np.subtract(placed.center, expected.center)))
        yield 100 * distance, float(np.degrees(off)), oriented_iou(placed, expected)


def extraction_rows(rooms: list[Path], seeds: int) -> Iterator[Row]:
    """One row per variant: errors over all rooms and seeds, failed objects, CPU time per room."""
    options = ExtractionConfig()
    for name, replacements in VARIANTS.items():
        measured: list[tuple[float, float, float]] = []
        seconds = 0.0
        with ExitStack() as stack:
            for (module, attribute), function in replacements.items():
                stack.enter_context(patch.object(module, attribute, function))
            for folder in rooms:
                truth = read_json(Truth, folder / "truth.json")
                for seed in range(seeds):
                    noise, steps = np.random.default_rng(seed).spawn(2)
                    picture = observe(folder / "input", options, noise)
                    since = time.process_time()
                    result = reconstruct(folder.name, picture, options, steps)
                    seconds += time.process_time() - since
                    measured += errors(result, truth)
        centre, yaw, iou = np.array(measured).T
        failed = int(np.isnan(centre).sum())
        yield [
            name,
            f"{np.nanmean(centre):.2f}, {np.nanmedian(centre):.2f}",
            f"{np.nanmean(yaw):.2f}, {np.nanmedian(yaw):.2f}",
            f"{iou.mean():.3f}",
            f"{failed}/{len(centre)}",
            f"{seconds / len(rooms) / seeds:.2f}",
        ]


def time_fastest(function: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Milliseconds of the fastest run, and what it returns."""
    best, value = np.inf, None
    for _ in range(repeats):
        since = time.perf_counter()
        value = function()
        best = min(best, time.perf_counter() - since)
    return 1e3 * best, value


def raw_clouds(rooms: list[Path]) -> list[Points]:
    """The clouds that extraction is about to clean."""
    taken: list[Points] = []
    original = objects.clean_cloud

    def keep(points: Points, *args: Any) -> Points:
        taken.append(points[:: max(1, len(points) // objects.MAX_POINTS)][: objects.MAX_POINTS])
        return original(points, *args)

    with patch("stages.extraction.objects.clean_cloud", keep):
        for folder in rooms:
            noise, steps = np.random.default_rng(0).spawn(2)
            reconstruct(folder.name, observe(folder / "input", ExtractionConfig(), noise), ExtractionConfig(), steps)
    return taken


Step = Callable[[Points], Any]


def share_equal(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Share of equal entries."""
    return float((a == b).mean())


# step: by other means (named), by Open3D, how far they agree
STEPS: dict[str, tuple[Step, Step, Callable[[Any, Any], float]]] = {
    "outliers (scipy): same verdict": (
        lambda cloud: scipy_inliers(cloud, objects.NEIGHBOURS, 3.0),
        lambda cloud: statistical_inliers(cloud, objects.NEIGHBOURS, 3.0),
        share_equal,
    ),
    "DBSCAN (scikit-learn): same verdict": (
        lambda cloud: sklearn_dbscan(cloud, 0.08, 8) >= 0,
        lambda cloud: dbscan(cloud, 0.08, 8) >= 0,
        share_equal,
    ),
    "448 farthest of 2048 points (numpy): same points": (
        lambda cloud: numpy_farthest(cloud[:2048].astype(np.float32), 448),
        lambda cloud: farthest_points(cloud[:2048].astype(np.float32), 448),
        lambda a, b: len({*map(tuple, a.tolist())} & {*map(tuple, b.tolist())}) / len(np.unique(a, axis=0)),
    ),
    "plane of 1000 hypotheses (ours): inliers of theirs / ours": (
        lambda cloud: fit_plane(cloud, 0.03, 1000, np.random.default_rng(0)).inliers,  # type: ignore[union-attr]
        lambda cloud: open3d_free_plane(cloud, 0.03, 1000, np.random.default_rng(0)).inliers,  # type: ignore[union-attr]
        lambda a, b: float(b.sum() / a.sum()),
    ),
    "upright box (ours): footprint of theirs / ours": (
        lambda cloud: np.array(minimum_box(cloud, 0.01).size),
        lambda cloud: np.array(open3d_box(cloud, 0.01).size),
        lambda a, b: float(np.prod(b[:2]) / np.prod(a[:2])),
    ),
}


def step_rows(rooms: list[Path]) -> Iterator[Row]:
    """One row per step: milliseconds per cloud by other means and by Open3D, and how far they agree."""
    inputs = [cloud for cloud in raw_clouds(rooms) if len(cloud) >= 2048]
    used = [inputs[index] for index in np.random.default_rng(0).permutation(len(inputs))[:30]]
    for name, (other, open3d, agreement) in STEPS.items():
        times, agreed = [], []
        for cloud in used:
            (a_ms, a), (b_ms, b) = time_fastest(partial(other, cloud)), time_fastest(partial(open3d, cloud))
            times.append((a_ms, b_ms))
            agreed.append(agreement(a, b))
        a_mean, b_mean = np.mean(times, axis=0)
        yield [name, len(used), f"{a_mean:.1f}", f"{b_mean:.1f}", f"{np.mean(agreed):.4f}"]


def normal_rows(rooms: list[Path]) -> Iterator[Row]:
    """Error of patch normals under the depth noise, against those from exact depth; milliseconds per view."""
    off: dict[str, list[float]] = {"ours": [], "Open3D": []}
    cost: dict[str, list[float]] = {"ours": [], "Open3D": []}
    for folder in rooms:
        picture = read_folder(folder / "input")
        noisy = noisy_depth(picture.depth, DepthNoiseConfig(), np.random.default_rng(0))
        for item in picture.annotations.objects:
            mask = picture.masks == item.mask
            if mask.sum() < 1000:
                continue
            views = [cut(View(picture.rgb, mask, depth, picture.intrinsics)) for depth in (picture.depth, noisy)]
            for name, function in (("ours", patch_normals), ("Open3D", open3d_normals)):
                truth = function(views[0], GRID)
                milliseconds, normals = time_fastest(partial(function, views[1], GRID), 1)
                both = (np.abs(truth).sum(-1) > 0) & (np.abs(normals).sum(-1) > 0)
                angles = np.degrees(np.arccos(np.clip((truth * normals).sum(-1)[both], -1, 1)))
                off[name].append(float(np.median(angles)))
                cost[name].append(milliseconds)
    for name in off:
        yield [name, len(off[name]), f"{np.mean(off[name]):.1f}", f"{np.mean(cost[name]):.1f}"]


def digests() -> list[str]:
    """Of what Open3D answers, step by step, to one cloud."""
    cloud = np.random.default_rng(0).normal(size=(8000, 3)) * [1, 1, 0.2]
    return [hashlib.sha256(np.ascontiguousarray(step(cloud)).tobytes()).hexdigest() for _, step, _ in STEPS.values()]


def repeat_rows() -> Iterator[Row]:
    """Whether six fresh processes, three with one thread and three with two, give the same bytes."""
    runs = []
    for threads in "121212":
        program = [sys.executable, "-c", "from benchmarks.geometry import digests; print(*digests())"]
        environment = os.environ | {"OMP_NUM_THREADS": threads}
        output = subprocess.run(program, capture_output=True, text=True, env=environment, check=True).stdout
        runs.append(output.splitlines()[-1].split())
    for name, one, two in zip(STEPS, zip(*runs[::2], strict=True), zip(*runs[1::2], strict=True), strict=True):
        yield [name.split(" (")[0], "yes" if len({*one}) == 1 else "no", "yes" if len({*one, *two}) == 1 else "no"]


def import_rows() -> Iterator[Row]:
    """CPU seconds that a process spends on an import: the best of three."""
    for module in ("numpy", "scipy.spatial", "sklearn.cluster", "open3d", "stages.tasks.api"):
        runs = []
        for _ in range(3):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, "-c", f"import {module}"], check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            runs.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        yield [module, f"{min(runs):.2f}"]


def main() -> None:
    """All tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=Path, nargs="+", required=True, help="folders with input/ and truth.json")
    parser.add_argument("--seeds", type=int, default=3)
    asked = parser.parse_args()
    rooms = sorted(asked.rooms)
    table(["import", "CPU seconds"], import_rows())
    table(["same bytes by Open3D", "one thread", "one and two threads"], repeat_rows())
    table(["step (by other means)", "clouds", "other (ms)", "Open3D (ms)", "agreement"], step_rows(rooms))
    table(["normals", "views", "error (degrees)", "ms"], normal_rows(rooms))
    heading = ["extraction", "centre (cm)", "yaw (degrees)", "oriented IoU", "failed", "CPU s per room"]
    table(heading, extraction_rows(rooms, asked.seeds))


if __name__ == "__main__":
    main()
