"""Photograph assets from a fixed camera as they turn (paper A.1)."""

import math
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.cli import progress
from roomkin.stages.config.assets import SnapshotOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options, write_atomically, write_json
from roomkin.stages.contracts.library import Asset, SnapshotShard
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at

BOX_TOLERANCE = 0.02  # of the largest extent
DEPTH_RANGE = 30.0  # metres: the camera measures in whole millimetres, 32 m at most
# As fast as lzf here, and smaller; and lzf's bytes depend on memory that HDF5 does not initialise.
PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def run(*, library: Path, out: Path, options: str = "{}") -> None:
    """Render the assets of a part of a library, or of all of it.

    Args:
        library: index of the part, its archive beside it.
        out: the HDF5 file; the sidecar (.json) gets the same name.
        options: JSON of the config section `assets`.
    """
    config = read_options(SnapshotOptions, options)
    folders = AssetFolders(library)
    yaws = [2 * math.pi * k / config.n_snap for k in range(config.n_snap)]
    turntable = Turntable(config)
    views, side = len(yaws) + 1, config.image_size
    with write_atomically(out) as temporary:
        with h5py.File(temporary, "w") as file:
            shape, picture = (len(folders), views, side, side), (1, 1, side, side)
            packed = PACKED if folders else {}  # a shard of broken models is empty, which cannot be packed
            rgb = file.create_dataset("rgb", (*shape, 3), "u1", chunks=(*picture, 3) if folders else None, **packed)
            depth = file.create_dataset("depth", shape, "u2", chunks=picture if folders else None, **packed)
            for index, asset in enumerate(progress(folders, "assets", len(folders))):
                rgb[index], depth[index] = turntable.photograph(folders[asset], [*yaws, config.representative_yaw])
        sidecar = SnapshotShard(
            assets=list(folders), yaws=yaws, representative_yaw=config.representative_yaw, image_size=side,
            intrinsics=turntable.intrinsics.tolist(),
            elevation=math.atan2(config.camera_height, config.camera_distance),
        )  # fmt: skip
        write_json(out.with_suffix(".json"), sidecar)


class Turntable:
    """A scene with one camera before which assets turn, each as large as the camera's range allows."""

    def __init__(self, config: SnapshotOptions) -> None:
        from roomkin.stages.simulation.rendering import RenderCamera, make_scene

        self.scene = make_scene(shadows=False, light=(-1.0, 0.5, -1.2))
        side = config.image_size
        self.shape = (side, side)
        self.intrinsics = intrinsics_from_fov(side, side, config.field_of_view)
        self.camera = RenderCamera(self.scene, self.intrinsics, side, side, pack="minimal")
        eye = np.array([config.camera_distance, 0.0, config.camera_height])
        self.unit = DEPTH_RANGE / (float(np.linalg.norm(eye)) + 1.0)  # largest extent of an asset before the camera
        self.pose = look_at(eye * self.unit, [0.0, 0.0, 0.0])

    def photograph(self, folder: Path, yaws: list[float]) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
        """Pictures at the given turns: rgb (V, H, W, 3), depth (V, H, W) in thousandths of the largest extent."""
        from roomkin.stages.articulated.asset_folder import read_asset
        from roomkin.stages.simulation.loading import load_visual, measure_bounds, move, remove, root_pose

        asset = read_asset(folder)
        scale = self.unit / largest_extent(asset)
        body = load_visual(self.scene, folder, scale)
        move(body, root_pose(asset, (0.0, 0.0, 0.0), 0.0, scale))
        check_box(asset, np.ptp(measure_bounds(body), axis=0) / scale)
        rgb = np.empty((len(yaws), *self.shape, 3), np.uint8)
        depth = np.empty((len(yaws), *self.shape), np.uint16)
        for number, yaw in enumerate(yaws):
            move(body, root_pose(asset, (0.0, 0.0, 0.0), yaw, scale))
            picture = self.camera.render(self.pose)
            rgb[number] = picture.rgb
            depth[number] = np.minimum(picture.depth * np.float32(1000 / self.unit), 65535).round()
        remove(self.scene, body)
        return rgb, depth


class VisibilityCheck:
    """Tells whether anything is seen of an asset in its representative picture, which everything later needs."""

    def __init__(self) -> None:
        self.turntable: Turntable | None = None

    def check(self, folder: Path, where: Path) -> None:
        """Photograph an asset folder once.

        Raises:
            InputError: nothing is seen of the model file `where`, or its picture cannot be taken.
        """
        options = SnapshotOptions()
        self.turntable = self.turntable or Turntable(options)
        _, depth = self.turntable.photograph(folder, [options.representative_yaw])
        if not depth.any():
            what = "cannot be seen: it is transparent, or too thin."
            raise InputError(where, what, "make it opaque and thicker", code="E-MODEL-UNSEEN")


def check_box(asset: Asset, seen: NDArray[np.float64]) -> None:
    """Refuse an asset whose box has other extents than what is seen of it, (3,) metres."""
    if np.abs(seen - asset.size).max() > BOX_TOLERANCE * largest_extent(asset):
        stated, found = (" x ".join(f"{extent:.3g}" for extent in extents) for extents in (asset.size, seen))
        what = f"box_min, box_max: a box of {stated} m, but its meshes are {found} m."
        raise InputError(f"asset.json of {asset.id}", what, "make it again", code="E-ASSET-STALE")


def largest_extent(asset: Asset) -> float:
    """Largest side of the closed box, metres."""
    return max(asset.size)
