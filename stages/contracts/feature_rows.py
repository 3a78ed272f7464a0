"""The rows of a feature store, memory-mapped: matching reads a few views of it, never the whole."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts.arrays import check_array, check_within, readable
from stages.contracts.features import FeatureIndex
from stages.contracts.files import read_json

AGAIN = "run `python -m stages.matching features` again with the present options"
LARGEST = 60_000.0  # of a float16


def open_features(path: Path) -> tuple[FeatureIndex, NDArray[np.float16]]:
    """The index of a shard (`path` with .npy or .json) and its rows, still on disk.

    Raises:
        InputError: one is missing or broken, or there are not as many rows as the index says.
    """
    index = read_json(FeatureIndex, path.with_suffix(".json"), AGAIN)
    path = path.with_suffix(".npy")
    with readable(path, "npy file", AGAIN):
        rows = np.load(path, mmap_mode="r", allow_pickle=False)
        check_array(path, "rows", rows, (index.starts[-1], "D"), "f", AGAIN)
    return index, rows


def check_features(path: Path) -> None:
    """Index and rows; every number is finite."""
    _, rows = open_features(path)
    check_within(path.with_suffix(".npy"), "rows", rows, -LARGEST, LARGEST, AGAIN)
