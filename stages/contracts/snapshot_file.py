"""A shard of snapshots: pictures in HDF5 with a JSON sidecar."""

from pathlib import Path

import h5py
import numpy as np

from roomkin.stages.contracts.arrays import check_array, dataset, explain_unreadable
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.library import SnapshotShard

AGAIN = "run `roomkin assets snapshots` again"


def open_snapshots(path: Path) -> tuple[SnapshotShard, h5py.File]:
    """The sidecar of a shard (`path` with .h5 or .json) and its file, open for reading; the pictures are not read yet.

    Raises:
        InputError: one is missing or broken, or arrays are not as the sidecar says.
    """
    sidecar = read_json(SnapshotShard, path.with_suffix(".json"), AGAIN)
    path = path.with_suffix(".h5")
    with explain_unreadable(path, "snapshot file", AGAIN):
        file = h5py.File(path, "r")
    shape = (len(sidecar.assets), len(sidecar.yaws) + 1, sidecar.image_size, sidecar.image_size)
    check_array(path, "rgb", dataset(path, file, "rgb", AGAIN), (*shape, 3), "u", AGAIN)
    check_array(path, "depth", dataset(path, file, "depth", AGAIN), shape, "u", AGAIN)
    return sidecar, file


def check_snapshots(path: Path) -> None:
    """Sidecar and arrays; every asset is seen in its representative view."""
    sidecar, file = open_snapshots(path)
    with file, explain_unreadable(path.with_suffix(".h5"), "snapshot file", AGAIN):
        for number, asset in enumerate(sidecar.assets):
            if not np.any(file["depth"][number, -1]):
                raise InputError(
                    path.with_suffix(".h5"), f"depth: '{asset}' is not in its picture.", AGAIN, code="E-CONTRACT-BROKEN"
                )
