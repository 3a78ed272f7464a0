"""Pictures for a page, scaled down and embedded in the HTML; of assets turned as matching chose."""

import base64
import io
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.features import MAKE_SNAPSHOTS, open_snapshots
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.images import read_narrow
from roomkin.stages.contracts.library import SnapshotShard
from roomkin.stages.geometry.frames import MARGIN, angle_difference, view_angle

THUMBNAIL = 150  # pixels: small pictures of objects and assets


class PagePicture(NamedTuple):
    """A picture inside the page."""

    source: str
    width: int
    height: int
    alt: str


class Animation(NamedTuple):
    """A film, and the still picture shown where nothing should move."""

    film: PagePicture
    still: PagePicture


def _embed_picture(data: bytes, size: tuple[int, int], alt: str) -> PagePicture:
    return PagePicture(f"data:image/webp;base64,{base64.b64encode(data).decode('ascii')}", *size, alt)


@dataclass(frozen=True)
class Album:
    """Makes pictures for one page, no wider than `width` pixels, as WebP of one quality."""

    width: int
    quality: int

    def add(self, path: Path | None, alt: str) -> PagePicture | None:
        """The picture of a file, if the run has it."""
        return self.put(read_narrow(path, self.width), alt) if path else None

    def put(self, picture: Image.Image, alt: str) -> PagePicture:
        """A picture that is small enough."""
        buffer = io.BytesIO()
        picture.save(buffer, "WEBP", quality=self.quality, method=4)
        return _embed_picture(buffer.getvalue(), picture.size, alt)

    def thumbnail(self, picture: Image.Image | None, alt: str) -> PagePicture | None:
        """A small picture, if there is one."""
        if picture is None:
            return None
        small = picture.copy()
        small.thumbnail((THUMBNAIL, THUMBNAIL), Image.Resampling.LANCZOS)
        return self.put(small, alt)

    def film(self, path: Path, alt: str) -> Animation:
        """An animated WebP as it is, and its last frame.

        Raises:
            InputError: the file is missing or no film.
        """
        try:
            with Image.open(path) as film:
                film.seek(getattr(film, "n_frames", 1) - 1)
                last = film.convert("RGB")
        except (OSError, SyntaxError, ValueError) as error:
            what = f"is not a readable film ({explain(error)})."
            raise InputError(path, what, "make it again", code="E-FILM-UNREADABLE") from None
        return Animation(_embed_picture(path.read_bytes(), last.size, alt), self.put(last, alt))


class SnapshotShards:
    """Some shards of snapshots (.h5); each picture is read when it is asked for."""

    def __init__(self, shards: Iterable[Path]) -> None:
        sidecars = {path: read_json(SnapshotShard, path.with_suffix(".json")) for path in shards}
        each = ((path, *place) for path, one in sidecars.items() for place in enumerate(one.assets))
        self._places = {asset: (path, index) for path, index, asset in each}

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
