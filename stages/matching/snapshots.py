"""What matching reads: snapshots of the assets, and a scene's picture, masks, depth, each object's view of them."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError, Objects
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.extracted import read_metres, read_object_masks
from roomkin.stages.contracts.features import MAKE_SNAPSHOTS, open_snapshots
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.images import check_size, read_rgb
from roomkin.stages.contracts.library import SnapshotShard
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.masks import ObjectView


class SnapshotFile:
    """One shard, opened for reading: `with SnapshotFile(path) as shard: shard.views(asset)`."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.sidecar, self._file = open_snapshots(path)
        self._rgb, self._depth = self._file["rgb"], self._file["depth"]
        self._position = {asset: number for number, asset in enumerate(self.sidecar.assets)}

    def __enter__(self) -> "SnapshotFile":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def views(self, asset: str) -> list[ObjectView]:
        """All views of an asset: the yaws, then the representative. The object is where there is depth."""
        number = self._position[asset]
        with explain_unreadable(self.path, "snapshot file", MAKE_SNAPSHOTS):  # a chunk may be damaged
            rgbs, depths = self._rgb[number], self._depth[number].astype(np.float32) / 1000
        intrinsics = np.array(self.sidecar.intrinsics, dtype=float)
        up = up_of_camera(self.sidecar.elevation)
        return [ObjectView(rgb, depth > 0, depth, intrinsics, up) for rgb, depth in zip(rgbs, depths, strict=True)]

    def picture(self, asset: str, yaw: float) -> NDArray[np.uint8]:
        """The snapshot (H, W, 3) nearest to a yaw in radians."""
        gap = np.angle(np.exp(1j * (np.array(self.sidecar.yaws) - yaw)))
        with explain_unreadable(self.path, "snapshot file", MAKE_SNAPSHOTS):
            picture: NDArray[np.uint8] = self._rgb[self._position[asset], int(np.abs(gap).argmin())]
        return picture


class Snapshots:
    """All shards of a library, each opened when it is looked into."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths = paths

    @cached_property
    def _shards(self) -> dict[str, Path]:
        """The shard of every asset."""
        sidecars = {path: read_json(SnapshotShard, path.with_suffix(".json"), MAKE_SNAPSHOTS) for path in self._paths}
        return {asset: path for path, sidecar in sidecars.items() for asset in sidecar.assets}

    def picture(self, asset: str, yaw: float) -> NDArray[np.uint8]:
        """The snapshot (H, W, 3) of an asset nearest to a yaw in radians."""
        with self._find_shard(asset) as shard:
            return shard.picture(asset, yaw)

    def views(self, asset: str) -> list[ObjectView]:
        """All views of an asset: the yaws, then the representative."""
        with self._find_shard(asset) as shard:
            return shard.views(asset)

    def _find_shard(self, asset: str) -> SnapshotFile:
        """The shard that holds an asset.

        Raises:
            InputError: none does.
        """
        if asset not in self._shards:
            fix = "give the snapshots that the features were made from"
            raise InputError("--snapshots", f"no shard holds {asset}.", fix, code="E-SNAPSHOTS-MISSING")
        return SnapshotFile(self._shards[asset])


def up_of_camera(elevation: float | None) -> NDArray[np.float64] | None:
    """Unit vector (3,) against gravity in the frame of a level camera that looks down by `elevation` radians."""
    return None if elevation is None else np.array([0.0, -np.cos(elevation), -np.sin(elevation)])


class SceneObjects:
    """`objects.json` with `masks.png` and `depth.npz` beside it, and the picture.

    Depth may be missing (then no normals are compared); masks may not.
    """

    def __init__(self, objects: Path, image: Path) -> None:
        self.objects = read_json(Objects, objects)
        self._rgb = read_rgb(image)
        check_size(image, self._rgb, self.objects.width, self.objects.height, objects.name)
        self._masks = read_object_masks(objects, self.objects)
        self._depth = read_metres(objects, self.objects)
        self._intrinsics = np.array(self.objects.intrinsics, dtype=float)
        self._up = np.array(self.objects.floor_from_camera, dtype=float)[2, :3]

    def view(self, item: SceneObject) -> ObjectView:
        """The object as the camera sees it; the mask may be empty."""
        return ObjectView(self._rgb, self._masks == item.mask, self._depth, self._intrinsics, self._up)
