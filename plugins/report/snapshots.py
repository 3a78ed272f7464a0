"""Small pictures of the library's assets, turned as matching chose."""

from collections.abc import Iterable
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene
from stages.contracts.library import SnapshotShard
from stages.geometry.cameras import MARGIN
from stages.geometry.frames import angle_difference
from stages.geometry.viewing import view_angle


class Snapshots:
    """Some shards of snapshots (.h5); each picture is read when it is asked for."""

    def __init__(self, shards: Iterable[Path]) -> None:
        self._places: dict[str, tuple[Path, int, SnapshotShard]] = {}
        for path in shards:
            shard = read_json(SnapshotShard, path.with_suffix(".json"))
            self._places |= {asset: (path, index, shard) for index, asset in enumerate(shard.assets)}

    def picture(self, asset: str, yaw: float | None = None) -> Image.Image | None:
        """The asset at the yaw nearest to `yaw` (None: the representative view), cut out; None if it is unknown.

        Raises:
            InputError: the shard cannot be read.
        """
        if asset not in self._places:
            return None
        path, index, shard = self._places[asset]
        view = len(shard.yaws)
        if yaw is not None:
            view = int(np.argmin([angle_difference(each, yaw) for each in shard.yaws]))
        try:
            with h5py.File(path) as file:
                rgb, depth = file["rgb"][index, view], file["depth"][index, view]
        except (OSError, KeyError, ValueError) as error:
            what = f"is not a readable snapshot shard ({error})."
            raise InputError(path, what, "make it again", code="E-FILE-UNREADABLE") from None
        return cut_out(rgb, depth > 0)


def cut_out(rgb: NDArray[np.uint8], seen: NDArray[np.bool_]) -> Image.Image:
    """The part of a picture that is seen, square, the rest transparent."""
    picture = Image.fromarray(np.dstack([rgb, seen.astype(np.uint8) * 255]), "RGBA")
    if not seen.any():
        return picture
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
    half = (1 + 2 * MARGIN) * max(bottom - top, right - left) / 2
    x, y = (left + right) / 2, (top + bottom) / 2
    return picture.crop((round(x - half), round(y - half), round(x + half), round(y + half)))


def views_of(scenes: Iterable[GeneratedScene], name: str) -> dict[str, float]:
    """Yaws of snapshots at which the camera sees the models that stand for an object, by asset; first ranks first."""
    found: dict[str, float] = {}
    for scene in scenes:
        camera = [row[3] for row in scene.floor_from_camera]
        for item in scene.objects:
            if item.id == name and item.status == "ok":
                found.setdefault(item.asset, view_angle(camera, item.position, item.yaw))
    return found
