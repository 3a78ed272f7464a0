"""Photograph models that are in no library, twice each, with the correspondences of patches."""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from plugins.furniture.catalogue import CATEGORIES, sample
from plugins.furniture.folder import LICENCE, build
from plugins.furniture.refinishing import refinish
from plugins.furniture.robot import robot_of
from plugins.patchnet.network import GRID, SIZE
from plugins.patchnet.training.assemblies import assembly
from plugins.patchnet.training.options import PairOptions
from plugins.patchnet.training.pairs import blemish_picture, crop, hide_part, matches
from plugins.patchnet.training.studio import ChanceStudio, camera_from_object
from stages.articulated.asset_folder import Description, write_asset
from stages.assets.snapshots import Turntable
from stages.cli import progress
from stages.config.assets import SnapshotOptions
from stages.contracts.errors import InputError
from stages.contracts.files import write_atomically
from stages.contracts.library import Asset
from stages.geometry.frames import SYMMETRY_PERIOD
from stages.matching.crop import View
from stages.matching.snapshots import up_of_camera

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


def render(out: Path, config: PairOptions, seed: int) -> None:
    """Write the HDF5 file `out`, if it is not there from the same options and seed.

    Raises:
        InputError: a category that is held out does not exist.
    """
    unknown = sorted(set(config.held_out) - set(CATEGORIES))
    if unknown:
        fix = f"one of {', '.join(CATEGORIES)}"
        raise InputError("--pairs.held-out", f"no category '{unknown[0]}'.", fix, code="E-CATEGORY-UNKNOWN")
    about = json.dumps([asdict(config), seed])
    if out.is_file():
        with h5py.File(out) as file:
            if file.attrs.get("about") == about:
                return
    wanted = models(config)
    photographer, count = Photographer(), len(wanted) * config.views
    with write_atomically(out) as temporary, h5py.File(temporary, "w") as file:
        file.attrs["about"] = about
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
    """Category and number of all models."""
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
        yaws = rng.permutation(draw_yaws(views, rng))
        rgbs, depths = self.turntable.photograph(folder, yaws.tolist())
        turned = yaws + rng.uniform(-JITTER, JITTER, views)
        shots = self.studio.photograph(again, turned.tolist(), rng, PAINTED)
        for rgb, depth, yaw, shot in zip(rgbs, depths, yaws, shots, strict=True):
            snapshot = View(rgb, depth > 0, depth.astype(np.float32) / 1000, self.turntable.intrinsics, self.up)
            view = hide_part(shot.view, rng) if rng.random() < 0.6 else shot.view
            found = matches(view, shot.object_from_camera, snapshot, camera_from_object(self.camera, float(yaw)))
            picture = View(blemish_picture(view.rgb, rng), view.mask)
            yield Pair(crop(picture), crop(snapshot), found, float(yaw))


def draw_yaws(views: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Yaws (views,) evenly over the front half and, half as close, over the back, which tells less of most models."""
    front = -(-2 * views // 3)
    fronts = -np.pi / 2 + (np.arange(front) + rng.uniform()) * np.pi / front
    backs = np.pi / 2 + (np.arange(views - front) + rng.uniform()) * np.pi / (views - front)
    return np.concatenate([fronts, backs])


def make(category: str, index: int, seed: int, folder: Path, finish: np.random.Generator | None = None) -> Asset:
    """A model of a category, or an assembly, as an asset folder; with `finish` the same in another finish."""
    if category != ASSEMBLY:
        recipe = sample(category, index, seed + MODELS)
        recipe = refinish(recipe, finish) if finish else recipe
        return build(recipe, None, folder, f"{category}_{index}", category)
    rng = np.random.default_rng(np.random.SeedSequence((seed, MODELS, index)))
    about = Description(f"{ASSEMBLY}_{index}", ASSEMBLY, LICENCE, "procedural")
    return write_asset(robot_of(assembly(rng), about.id), folder, about)
