"""Verb `render`: photograph models that are in no library, twice each, with the correspondences of patches."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from stages.articulated.asset_folder import Description, write_asset
from stages.assets.snapshots import Turntable
from stages.cli import progress
from stages.config.assets import SnapshotOptions
from stages.config.encoder import PairOptions
from stages.contracts.errors import InputError
from stages.contracts.files import atomic, read_options
from stages.contracts.library import Asset
from stages.encoder.assemblies import assembly
from stages.encoder.pairs import blemished, crop, hidden, matches
from stages.encoder.studio import ChanceStudio, camera_from_object
from stages.geometry.frames import SYMMETRY_PERIOD
from stages.matching.crop import View
from stages.matching.snapshots import up_of_camera
from stages.patchnet.network import GRID, SIZE
from stages.procedural.catalogue import CATEGORIES, sample
from stages.procedural.folder import LICENCE, build
from stages.procedural.refinishing import refinished
from stages.procedural.robot import robot_of

ASSEMBLY = "assembly"
MODELS = 1_000_003  # added to the seed: no library has the models of this one
PAINTED = 0.5  # share of the pictures in plain colours; the others are of another finish
JITTER = 0.2  # radians between a picture and its snapshot, at most


@dataclass(frozen=True)
class Pair:
    """One model as a room may show it, and its snapshot: crops (SIZE, SIZE, 4), matches (GRID * GRID,), turn."""

    picture: NDArray[np.uint8]
    snapshot: NDArray[np.uint8]
    matches: NDArray[np.int16]
    yaw: float


def run(*, shard: int, shards: int, out: Path, options: str = "{}", seed: int = 0) -> None:
    """Photograph every `shards`-th model, beginning with number `shard`.

    Args:
        shard: which part, 0 to shards - 1.
        shards: number of parts.
        out: the HDF5 file.
        options: JSON of the pictures' keys of the config section `encoder`.
        seed: of models and pictures.
    """
    config = read_options(PairOptions, options)
    unknown = sorted(set(config.held_out) - set(CATEGORIES))
    if unknown:
        raise InputError("encoder.held_out", f"no category '{unknown[0]}'.", f"one of {', '.join(CATEGORIES)}")
    wanted = models(config)[shard::shards]
    photographer, count = Photographer(), len(wanted) * config.views
    with atomic(out) as temporary, h5py.File(temporary, "w") as file:
        crops = file.create_dataset("crops", (count, 2, SIZE, SIZE, 4), "u1")  # picture, snapshot
        matched = file.create_dataset("matches", (count, GRID * GRID), "i2")
        yaws = file.create_dataset("yaws", (count,), "f4")
        periods = file.create_dataset("periods", (len(wanted),), "f4")
        file.create_dataset("models", data=[f"{category}_{index}" for category, index in wanted])
        for number, (category, index) in enumerate(progress(wanted, "models", len(wanted))):
            period, pairs = photographer.pairs(category, index, seed, config.views)
            periods[number] = period
            for view, pair in enumerate(pairs):
                at = number * config.views + view
                crops[at, 0], crops[at, 1], matched[at], yaws[at] = pair.picture, pair.snapshot, pair.matches, pair.yaw


def models(config: PairOptions) -> list[tuple[str, int]]:
    """Category and number of all models, mixed, so that all shards have some of all."""
    wanted = [(category, k) for k in range(config.models) for category in CATEGORIES if category not in config.held_out]
    return wanted + [(ASSEMBLY, k) for k in range(config.assemblies)]


class Photographer:
    """A turntable and a studio; made once per process."""

    def __init__(self) -> None:
        self.turntable = Turntable(SnapshotOptions())
        self.studio = ChanceStudio()
        options = SnapshotOptions()
        self.camera = self.turntable.pose.copy()
        self.camera[:3, 3] /= self.turntable.unit
        self.up = up_of_camera(float(np.arctan2(options.camera_height, options.camera_distance)))

    def pairs(self, category: str, index: int, seed: int, views: int) -> tuple[float, list[Pair]]:
        """The model's symmetry period, and its pairs, evenly round it."""
        rng = np.random.default_rng(np.random.SeedSequence((seed, *category.encode(), index)))
        with tempfile.TemporaryDirectory() as scratch:
            folder, again = Path(scratch) / "model", Path(scratch) / "again"
            asset = make(category, index, seed, folder)
            make(category, index, seed, again, rng)
            return SYMMETRY_PERIOD[asset.symmetry], list(self._pairs(folder, again, views, rng))

    def _pairs(self, folder: Path, again: Path, views: int, rng: np.random.Generator) -> Iterator[Pair]:
        yaws = rng.permutation(turns(views, rng))
        rgbs, depths = self.turntable.photograph(folder, yaws.tolist())
        turned = yaws + rng.uniform(-JITTER, JITTER, views)
        shots = self.studio.photograph(again, turned.tolist(), rng, PAINTED)
        for rgb, depth, yaw, shot in zip(rgbs, depths, yaws, shots, strict=True):
            snapshot = View(rgb, depth > 0, depth.astype(np.float32) / 1000, self.turntable.intrinsics, self.up)
            view = hidden(shot.view, rng) if rng.random() < 0.6 else shot.view
            found = matches(view, shot.object_from_camera, snapshot, camera_from_object(self.camera, float(yaw)))
            picture = View(blemished(view.rgb, rng), view.mask)
            yield Pair(crop(picture), crop(snapshot), found, float(yaw))


def turns(views: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Yaws (views,) evenly over the front half and, half as close, over the back, which tells less of most models."""
    front = -(-2 * views // 3)
    fronts = -np.pi / 2 + (np.arange(front) + rng.uniform()) * np.pi / front
    backs = np.pi / 2 + (np.arange(views - front) + rng.uniform()) * np.pi / (views - front)
    return np.concatenate([fronts, backs])


def make(category: str, index: int, seed: int, folder: Path, finish: np.random.Generator | None = None) -> Asset:
    """A model of a category, or an assembly, as an asset folder; with `finish` the same in another finish."""
    if category != ASSEMBLY:
        recipe = sample(category, index, seed + MODELS)
        recipe = refinished(recipe, finish) if finish else recipe
        return build(recipe, None, folder, f"{category}_{index}", category)
    rng = np.random.default_rng(np.random.SeedSequence((seed, MODELS, index)))
    about = Description(f"{ASSEMBLY}_{index}", ASSEMBLY, LICENCE, "procedural")
    return write_asset(robot_of(assembly(rng), about.id), folder, about)
