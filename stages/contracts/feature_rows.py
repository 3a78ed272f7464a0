"""The rows of a feature store, memory-mapped: matching reads a few views of it, never the whole."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts.arrays import check_array, check_within, read_npz, readable
from stages.contracts.errors import InputError
from stages.contracts.features import FeatureIndex
from stages.contracts.files import read_json

AGAIN = "run `python -m stages.matching features` again with the present options"
LARGEST = 60_000.0  # of a float16


def open_features(path: Path) -> tuple[FeatureIndex, NDArray[Any]]:
    """The index of a shard (`path` with .npy or .json) and its rows, still on disk.

    Raises:
        InputError: one is missing or broken, or there are not as many rows as the index says.
    """
    index = read_json(FeatureIndex, path.with_suffix(".json"), AGAIN)
    path = path.with_suffix(".npy")
    with readable(path, "npy file", AGAIN):
        rows = np.load(path, mmap_mode="r", allow_pickle=False)
        check_array(path, "rows", rows, (index.starts[-1], "D"), "fi", AGAIN)
    return index, rows


def open_companion(path: Path, index: FeatureIndex, rows: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """What goes with the rows of a shard (`path` with .npz): `wholes`, and for compressed rows their codec.

    Raises:
        InputError: it is missing or broken, or arrays do not fit each other.
    """
    path = path.with_suffix(".npz")
    parts = read_npz(path, AGAIN)
    if (rows.dtype.kind == "i") != ("components" in parts):
        raise InputError(path, "is not the codec of these rows.", AGAIN)
    shapes: dict[str, tuple[int | str, ...]] = {"wholes": (len(index.starts) - 1, "W")}
    if "components" in parts:
        check_array(path, "components", parts["components"], (rows.shape[1], "D"), "f", AGAIN)
        codes, columns = parts["components"].shape
        shapes |= {"mean": (columns,), "steps": (codes,)}
    for name, shape in shapes.items():
        if name not in parts:
            raise InputError(path, f"has no array '{name}'.", AGAIN)
        check_array(path, name, parts[name], shape, "f", AGAIN)
    return parts


def check_features(path: Path) -> None:
    """Index, rows and what goes with them; every number is finite; codes come with their codec."""
    index, rows = open_features(path)
    for name, part in open_companion(path, index, rows).items():
        check_within(path.with_suffix(".npz"), name, part, -LARGEST, LARGEST, AGAIN)
    check_within(path.with_suffix(".npy"), "rows", rows, -LARGEST, LARGEST, AGAIN)
