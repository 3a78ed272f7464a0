"""The feature store: patches of all snapshots, rows of bytes in a memory-mapped .npy with a JSON index.

A row is read back as mean + (codes * steps) @ components, so whatever compares rows need not know. What is lost is
measured in docs/results/matching.md.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError, write_atomically, write_json
from roomkin.stages.contracts.features import MAKE_FEATURES, FeatureIndex, open_companion, open_features

LEVELS = np.iinfo(np.int8).max
HEADROOM = 1.1  # numbers beyond this times the largest one of the sample are cut off; chosen


class Codec(NamedTuple):
    """mean (D,), orthonormal components (K, D), steps (K,) of the codes."""

    mean: NDArray[np.float32]
    components: NDArray[np.float32]
    steps: NDArray[np.float32]

    def encode(self, rows: NDArray[np.floating]) -> NDArray[np.int8]:
        """Codes (P, K) of rows (P, D)."""
        codes = ((rows.astype(np.float32) - self.mean) @ self.components.T) / self.steps
        return np.clip(np.round(codes), -LEVELS, LEVELS).astype(np.int8)

    def decode(self, codes: NDArray[np.int8]) -> NDArray[np.float32]:
        """Rows (P, D) of codes (P, K)."""
        rows = self.mean + (codes * self.steps) @ self.components
        return rows.astype(np.float32, copy=False)


def learn(sample: NDArray[np.floating], dimensions: int, kept: int) -> Codec:
    """A codec from sample rows (N, D): `dimensions` principal components, and the last `kept` columns as they are.

    Raises:
        InputError: the rows have no more columns than that.
    """
    features = sample.shape[1] - kept
    if dimensions >= features:
        what = f"{dimensions}: features have {features} numbers."
        raise InputError("matching.dimensions", what, "0: no compression", code="E-FEATURE-DIMENSIONS")
    rows = sample.astype(np.float64)
    mean = rows.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov(rows[:, :features].T))  # smallest first
    components = np.zeros((dimensions + kept, sample.shape[1]))
    components[:dimensions, :features] = axes[:, ::-1][:, :dimensions].T
    components[dimensions:, features:] = np.eye(kept)
    largest = np.abs((rows - mean) @ components.T).max(axis=0)
    steps = np.maximum(HEADROOM * largest, 1e-6) / LEVELS
    return Codec(mean.astype(np.float32), components.astype(np.float32), steps.astype(np.float32))


other_features = partial(InputError, fix=MAKE_FEATURES, code="E-FEATURES-OTHER")


class Snapshot(NamedTuple):
    """One stored view: `view` counts the yaws; len(yaws) is the representative."""

    asset: str
    view: int


def write_store(
    path: Path,
    index: FeatureIndex,
    rows: Sequence[NDArray[np.float16] | NDArray[np.int8]],
    wholes: Sequence[NDArray[np.float16]],
    codec: Codec | None,
) -> None:
    """Write the rows of all views, in the order of `index.starts`, and beside them index, wholes and codec."""
    with write_atomically(path) as temporary:
        first = rows[0] if rows else np.empty((0, 0), np.float16)  # a shard of broken models is empty
        shape = (index.starts[-1], first.shape[1])
        if rows and not shape[0]:
            fix = "look at the contact sheet of the snapshots"
            raise InputError(path, "no snapshot has a foreground patch.", fix, code="E-FEATURES-EMPTY")
        head = {"descr": np.lib.format.dtype_to_descr(first.dtype), "fortran_order": False, "shape": shape}
        with temporary.open("wb") as file:  # not through a memory map: on a full disk that ends the process, wordless
            np.lib.format.write_array_header_1_0(file, head)
            for block in rows:
                file.write(block.astype(first.dtype, copy=False).tobytes())
    with write_atomically(path.with_suffix(".npz")) as temporary, temporary.open("wb") as file:
        together = np.array(wholes) if wholes else np.empty((0, 0), np.float16)
        np.savez(file, wholes=together, **(codec._asdict() if codec else {}))
    write_json(path.with_suffix(".json"), index)


class FeatureStore:
    """All shards of a library, opened for reading."""

    def __init__(self, paths: Sequence[Path], settings: str) -> None:
        """Open the shards; `settings` is the digest of the encoder that is to be compared with them.

        Raises:
            InputError: a shard is missing, broken, made with other settings, or disagrees with the first one.
        """
        self._where: dict[str, tuple[int, int]] = {}  # asset -> shard, position in it
        self._arrays: list[NDArray[Any]] = []
        self._codecs: list[Codec | None] = []
        self._wholes: list[NDArray[np.float16]] = []
        self._indices: list[FeatureIndex] = []
        for path in paths:
            index, array = open_features(path)
            if index.settings != settings:
                raise other_features(path, f"was made by {index.encoder} with other settings.")
            if self._indices and (index.yaws, index.upright) != (self._indices[0].yaws, self._indices[0].upright):
                raise other_features(path, f"has other views than {paths[0]}.")
            if not index.assets:
                continue
            if self._arrays and array.shape[1] != self._arrays[0].shape[1]:
                raise other_features(path, f"rows: {array.shape[1]} numbers each, {paths[0]} has others.")
            parts = open_companion(path, index, array)
            self._codecs.append(Codec(*(parts[name] for name in Codec._fields)) if "mean" in parts else None)
            self._wholes.append(parts["wholes"])
            self._arrays.append(array)
            self._indices.append(index)
            shard = len(self._indices) - 1
            self._where |= {asset: (shard, position) for position, asset in enumerate(index.assets)}
        if not self._indices:
            raise InputError("--features", "names no feature store.", MAKE_FEATURES, code="E-FEATURES-MISSING")
        self.yaws = self._indices[0].yaws
        self.upright = self._indices[0].upright

    def __contains__(self, asset: str) -> bool:
        return asset in self._where

    def check_holds(self, models: Sequence[str], what: str) -> None:
        """Refuse models of which some are not in it: it is not of their library, or not of all that is needed.

        Args:
            what: that they are, in plural.
        """
        missing = [name for name in models if name not in self]
        if missing:
            lacking = f"{len(missing)} of {len(models)} {what} have no features, e.g. {missing[0]}."
            fix = "give the feature stores of all shards of this library"
            raise InputError("--features", lacking, fix, code="E-FEATURES-MISSING")

    @property
    def representative(self) -> int:
        """View number of the representative snapshots."""
        return len(self.yaws)

    def rows(self, snapshot: Snapshot) -> NDArray[np.floating]:
        """Rows (P, D + 5) of one view: still on disk, or decoded."""
        shard, position = self._where[snapshot.asset]
        at = position * (len(self.yaws) + 1) + snapshot.view
        starts = self._indices[shard].starts
        rows, codec = self._arrays[shard][starts[at] : starts[at + 1]], self._codecs[shard]
        return codec.decode(rows) if codec else rows

    def read_wholes(self, asset: str, views: Sequence[int]) -> NDArray[np.float16]:
        """Some views of an asset, each as one vector (V, W)."""
        shard, position = self._where[asset]
        return self._wholes[shard][np.array(views) + position * (len(self.yaws) + 1)]
