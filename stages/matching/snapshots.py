"""Reading the snapshots of the assets stage."""

from pathlib import Path
from types import TracebackType

import h5py
import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError, SnapshotShard, read_json
from stages.matching.crop import View


class SnapshotFile:
    """One shard, opened for reading: `with SnapshotFile(path) as shard: shard.views(asset)`."""

    def __init__(self, path: Path) -> None:
        fix = "run `python -m stages.assets snapshots` again"
        self.path = path
        self.sidecar = read_json(SnapshotShard, path.with_suffix(".json"), fix)
        try:
            self._file = h5py.File(path, "r")
            self._rgb, self._depth = self._file["rgb"], self._file["depth"]
        except (OSError, KeyError) as error:
            raise InputError(path, f"is no readable snapshot file ({error.__class__.__name__}).", fix) from None
        size = self.sidecar.image_size
        shape = (len(self.sidecar.assets), len(self.sidecar.yaws) + 1, size, size)
        if self._depth.shape != shape or self._rgb.shape != (*shape, 3):
            what = f"has shapes {self._rgb.shape} and {self._depth.shape}, its sidecar says {shape}."
            raise InputError(path, what, fix)
        self._position = {asset: number for number, asset in enumerate(self.sidecar.assets)}

    def __enter__(self) -> "SnapshotFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def __contains__(self, asset: str) -> bool:
        return asset in self._position

    def views(self, asset: str) -> list[View]:
        """All views of an asset: the yaws, then the representative. The object is where there is depth."""
        number = self._position[asset]
        depths = self._depth[number].astype(np.float32) / 1000
        intrinsics = np.array(self.sidecar.intrinsics, dtype=float)
        up = up_of_camera(self.sidecar.elevation)
        return [
            View(rgb, depth > 0, depth, intrinsics, up) for rgb, depth in zip(self._rgb[number], depths, strict=True)
        ]

    def picture(self, asset: str, yaw: float) -> NDArray[np.uint8]:
        """The snapshot (H, W, 3) nearest to a yaw in radians."""
        gap = np.angle(np.exp(1j * (np.array(self.sidecar.yaws) - yaw)))
        picture: NDArray[np.uint8] = self._rgb[self._position[asset], int(np.abs(gap).argmin())]
        return picture


def up_of_camera(elevation: float | None) -> NDArray[np.float64] | None:
    """Unit vector (3,) against gravity in the frame of a level camera that looks down by `elevation` radians."""
    return None if elevation is None else np.array([0.0, -np.cos(elevation), -np.sin(elevation)])
