"""What matching compares: snapshots of assets, an object's view in its picture, and what a judge is asked of them."""

from collections.abc import Collection, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import InputError, Objects
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.cousins import Candidate, Orientation
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


T = TypeVar("T")
DIGITS = 4  # of distances and scores: beyond them backends differ, so what is equal up to here is a tie


class Question(NamedTuple):
    """What a judge may look at: the object as the camera sees it, its label, and the models.

    library: library.json, its archives beside it; snapshots: pictures of the models; name: scene and object, no two
    alike; rank: of the cousin whose orientation is asked for; item, scene: what extraction found of the object, of all.
    """

    view: ObjectView
    label: str
    library: Path
    snapshots: Snapshots
    name: str = ""
    rank: int = 1
    item: SceneObject | None = None
    scene: Objects | None = None


class AbstainedError(Exception):
    """A judge does not decide. Then the order by distance holds, and cousins.json notes the reason.

    `chosen`: what it did decide on before, best first.
    """

    def __init__(self, reason: str, chosen: Sequence[Any] = ()) -> None:
        self.reason, self.chosen = reason, list(chosen)
        super().__init__(reason)


class Judge(Protocol):
    """Made from the options of `matching`. It gets both rankings, best first, and answers with its own.

    It may raise `AbstainedError`. `name`, if it has one, stands in cousins.json for the key of the config.
    """

    def __init__(self, options: MatchingConfig) -> None: ...

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """Candidates, best first. `by_votes` has the `k_model` that won a round, `by_distance` all."""
        ...

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """Views of one asset, best first. `by_votes` has the `k_ori` that won a round, `by_distance` all."""
        ...


def check_answer(judge: str, kind: type[T], answer: object, shown: Collection[str] | None = None) -> list[T]:
    """The answer of a judge: a list of a kind that is not empty; if something was `shown`, some of that, none twice.

    Raises:
        InputError: it is not; the judge is named.
    """
    where, mend = f"judge {judge}", "docs/extending.md says what a judge gives"
    if not isinstance(answer, list | tuple) or not answer or not all(isinstance(each, kind) for each in answer):
        raise InputError(where, f"gives {repr(answer)[:80]}, no list of {kind.__name__}.", mend, code="E-JUDGE-ANSWER")
    if shown is not None:
        names = [str(each.asset) for each in answer]  # type: ignore[attr-defined]
        for number, name in enumerate(names):
            if name not in shown or name in names[:number]:
                why = f"{name} twice" if name in shown else f"{name}, which it was not shown"
                raise InputError(where, f"gives {why}.", mend, code="E-JUDGE-ANSWER")
    return list(answer)
