"""Arrays beside a library: snapshots of its models (HDF5 with a JSON sidecar), an encoder's rows with their index."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from roomkin.stages.contracts.arrays import check_array, check_within, dataset, explain_unreadable, read_npz
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Document, read_json
from roomkin.stages.contracts.library import SnapshotShard
from roomkin.stages.contracts.types import Angle, Count, Id, Text, check_unique

MAKE_SNAPSHOTS = "run `roomkin assets snapshots` again"


def open_snapshots(path: Path) -> tuple[SnapshotShard, h5py.File]:
    """The sidecar of a shard (`path` with .h5 or .json) and its file, open for reading; the pictures are not read yet.

    Raises:
        InputError: one is missing or broken, or arrays are not as the sidecar says.
    """
    sidecar = read_json(SnapshotShard, path.with_suffix(".json"), MAKE_SNAPSHOTS)
    path = path.with_suffix(".h5")
    with explain_unreadable(path, "snapshot file", MAKE_SNAPSHOTS):
        file = h5py.File(path, "r")
    shape = (len(sidecar.assets), len(sidecar.yaws) + 1, sidecar.image_size, sidecar.image_size)
    check_array(path, "rgb", dataset(path, file, "rgb", MAKE_SNAPSHOTS), (*shape, 3), "u", MAKE_SNAPSHOTS)
    check_array(path, "depth", dataset(path, file, "depth", MAKE_SNAPSHOTS), shape, "u", MAKE_SNAPSHOTS)
    return sidecar, file


def check_snapshots(path: Path) -> None:
    """Sidecar and arrays; every asset is seen in its representative view."""
    sidecar, file = open_snapshots(path)
    with file, explain_unreadable(path.with_suffix(".h5"), "snapshot file", MAKE_SNAPSHOTS):
        for number, asset in enumerate(sidecar.assets):
            if not np.any(file["depth"][number, -1]):
                where, what = path.with_suffix(".h5"), f"depth: '{asset}' is not in its picture."
                raise InputError(where, what, MAKE_SNAPSHOTS, code="E-CONTRACT-BROKEN")


MAKE_FEATURES = "run `roomkin matching features` again with the present options"
LARGEST = float(np.finfo(np.float16).max)


class FeatureIndex(Document):
    """`shard_I.json`: which rows belong to which view of which asset.

    Beside it `shard_I.npy`: the rows, (N, D) float16, or (N, K) int8, codes of which a row is
    mean + (codes * steps) @ components; and `shard_I.npz`: mean (D,), components (K, D) and steps (K,) if there are
    codes, and wholes (views, W), every view as one vector.
    """

    encoder: Text
    settings: str = Field(description="digest of the encoder's settings; another one makes another store")
    upright: bool = Field(description="whether normals are upright (the snapshot camera's elevation was known)")
    assets: list[Id]
    yaws: list[Angle] = Field(min_length=1, description="radians; views in this order, then the representative")
    starts: list[Count] = Field(
        description="first row of view v of asset a at a * (len(yaws) + 1) + v; the last is the count"
    )

    @model_validator(mode="after")
    def _complete(self) -> "FeatureIndex":
        check_unique("assets", self.assets)
        if len(self.starts) != len(self.assets) * (len(self.yaws) + 1) + 1:
            raise ValueError("starts: needs one entry per view and one at the end")
        if self.starts[0] != 0 or self.starts != sorted(self.starts):
            raise ValueError("starts: must begin with 0 and never fall")
        return self


def open_features(path: Path) -> tuple[FeatureIndex, NDArray[Any]]:
    """The index of a shard (`path` with .npy or .json) and its rows, still on disk.

    Raises:
        InputError: one is missing or broken, or there are not as many rows as the index says.
    """
    index = read_json(FeatureIndex, path.with_suffix(".json"), MAKE_FEATURES)
    path = path.with_suffix(".npy")
    with explain_unreadable(path, "npy file", MAKE_FEATURES):
        rows = np.load(path, mmap_mode="r", allow_pickle=False)
        check_array(path, "rows", rows, (index.starts[-1], "D"), "fi", MAKE_FEATURES)
    return index, rows


def open_companion(path: Path, index: FeatureIndex, rows: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The arrays beside the rows of a shard (`path` with .npz): `wholes`, and for compressed rows their codec.

    Raises:
        InputError: it is missing or broken, or arrays do not fit each other.
    """
    path = path.with_suffix(".npz")
    parts = read_npz(path, MAKE_FEATURES)
    if (rows.dtype.kind == "i") != ("components" in parts):
        raise InputError(path, "is not the codec of these rows.", MAKE_FEATURES, code="E-FEATURES-BROKEN")
    shapes: dict[str, tuple[int | str, ...]] = {"wholes": (len(index.starts) - 1, "W")}
    if "components" in parts:
        check_array(path, "components", parts["components"], (rows.shape[1], "D"), "f", MAKE_FEATURES)
        codes, columns = parts["components"].shape
        shapes |= {"mean": (columns,), "steps": (codes,)}
    for name, shape in shapes.items():
        if name not in parts:
            raise InputError(path, f"has no array '{name}'.", MAKE_FEATURES, code="E-FEATURES-BROKEN")
        check_array(path, name, parts[name], shape, "f", MAKE_FEATURES)
    return parts


def check_features(path: Path) -> None:
    """Index, rows and what goes with them; every number is finite; codes come with their codec."""
    index, rows = open_features(path)
    for name, part in open_companion(path, index, rows).items():
        check_within(path.with_suffix(".npz"), name, part, -LARGEST, LARGEST, MAKE_FEATURES)
    check_within(path.with_suffix(".npy"), "rows", rows, -LARGEST, LARGEST, MAKE_FEATURES)
