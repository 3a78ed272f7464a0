"""Small pictures of the library's assets, turned as matching chose."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.features import MAKE_SNAPSHOTS, open_snapshots
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.library import SnapshotShard
from roomkin.stages.geometry.cameras import MARGIN
from roomkin.stages.geometry.frames import angle_difference
from roomkin.stages.geometry.viewing import view_angle


class Snapshots:
    """Some shards of snapshots (.h5); each picture is read when it is asked for."""

    def __init__(self, shards: Iterable[Path]) -> None:
        sidecars = {path: read_json(SnapshotShard, path.with_suffix(".json")) for path in shards}
        self._places = {
            asset: (path, index) for path, one in sidecars.items() for index, asset in enumerate(one.assets)
        }

    def picture(self, asset: str, yaw: float | None = None) -> Image.Image | None:
        """The asset at the yaw nearest to `yaw` (None: the representative view), cut out; None if it is unknown.

        Raises:
            InputError: the shard cannot be read.
        """
        if asset not in self._places:
            return None
        path, index = self._places[asset]
        shard, file = open_snapshots(path)
        view = -1 if yaw is None else int(np.argmin([angle_difference(each, yaw) for each in shard.yaws]))
        with file, explain_unreadable(path, "snapshot file", MAKE_SNAPSHOTS):
            return cut_out(file["rgb"][index, view], file["depth"][index, view] > 0)


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
