"""Arrays beside the documents (npz, npy, HDF5): broken in every way, refused in one line."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from PIL import Image

from roomkin.stages.contracts import InputError, Objects, read_json
from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.extracted import read_clouds
from roomkin.stages.matching.snapshots import SceneObjects, SnapshotFile
from roomkin.stages.matching.store import FeatureStore
from tests.refusals import refused
from tests.unit.contract_files import CLOUD, HEIGHT, WIDTH, Bench, masks, with_value

CLOUDS = {
    "no arrays": ({}, "has no cloud of 'cabinet_1'"),
    "one missing": ({"bowl_1": CLOUD}, "has no cloud of 'cabinet_1'"),
    "a stranger": ({"cabinet_1": CLOUD, "bowl_1": CLOUD, "sofa_1": CLOUD}, "cloud of 'sofa_1'"),
    "empty": ({"cabinet_1": CLOUD[:0], "bowl_1": CLOUD}, "cabinet_1: has 0 points"),
    "two points": ({"cabinet_1": CLOUD[:2], "bowl_1": CLOUD}, "cabinet_1: has 2 points"),
    "other count": ({"cabinet_1": CLOUD[:49], "bowl_1": CLOUD}, "objects.json says 50"),
    "flat": ({"cabinet_1": CLOUD[:, :2], "bowl_1": CLOUD}, "cabinet_1: has shape (50, 2), not (N, 3)"),
    "one axis": ({"cabinet_1": CLOUD.ravel(), "bowl_1": CLOUD}, "cabinet_1: has shape (150,)"),
    "whole numbers": ({"cabinet_1": CLOUD.astype(int), "bowl_1": CLOUD}, "cabinet_1: has type int64"),
    "text": ({"cabinet_1": CLOUD.astype(str), "bowl_1": CLOUD}, "cabinet_1: has type"),
    "NaN": ({"cabinet_1": with_value(CLOUD, np.nan), "bowl_1": CLOUD}, "cabinet_1: holds NaN"),
    "infinite": ({"cabinet_1": with_value(CLOUD, np.inf), "bowl_1": CLOUD}, "cabinet_1: holds NaN or infinity"),
    "millimetres": ({"cabinet_1": with_value(CLOUD, 2500), "bowl_1": CLOUD}, "cabinet_1: holds 2500"),
    "elsewhere": ({"cabinet_1": CLOUD + np.float32([0, 1, 0]), "bowl_1": CLOUD}, "cabinet_1: is not where its box"),
    "above": ({"cabinet_1": CLOUD + np.float32([0, 0, 2]), "bowl_1": CLOUD}, "cabinet_1: is not where its box"),
}


@pytest.mark.parametrize("case", list(CLOUDS))
def test_clouds(bench: Bench, case: str) -> None:
    arrays, words = CLOUDS[case]
    np.savez(bench.root / "extraction/clouds.npz", **arrays)
    bench.refused("objects", "clouds.npz", words)
    with pytest.raises(InputError, match=r"clouds\.npz"):  # what generation calls
        read_clouds(bench.path("objects"), read_json(Objects, bench.path("objects")))


def test_clouds_of_failed_objects_are_no_fault(bench: Bench) -> None:
    np.savez(bench.root / "extraction/clouds.npz", cabinet_1=CLOUD, bowl_1=CLOUD, lamp_1=CLOUD)
    assert main(["objects", str(bench.path("objects"))]) == 0


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def text(path: Path) -> None:
    path.write_text("no such thing")


def empty(path: Path) -> None:
    path.write_bytes(b"")


def gone(path: Path) -> None:
    path.unlink()


COMPANIONS = [
    ("objects", "extraction/clouds.npz"), ("objects", "extraction/depth.npz"), ("objects", "extraction/masks.png"),
    ("snapshots", "snapshots/shard_0.h5"), ("features", "features/shard_0.npy"),
    ("policy", "training/policy.safetensors"), ("policy", "training/last.safetensors"),
    ("episodes", "demonstrations/episodes.h5"), ("camera", "input/rgb.png"), ("annotations", "input/masks.png"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name"), COMPANIONS)
@pytest.mark.parametrize("how", [cut, text, empty, gone])
def test_a_companion(bench: Bench, kind: str, name: str, how: Callable[[Path], None]) -> None:
    how(bench.root / name)
    if name.endswith("extraction/depth.npz") and how is gone:
        assert main([kind, str(bench.path(kind))]) == 0  # matching then compares no normals
    else:
        bench.refused(kind, name)


EXTRACTED = {
    "unnamed mask value": ("masks.png", np.where(masks() < 3, masks(), 9).astype(np.uint16), "holds the value 9"),
    "mask of another size": ("masks.png", masks()[:20] % 3, "48x20"),
    "color masks": ("masks.png", np.dstack([masks().astype(np.uint8)] * 3), "3 channels"),
    "depth of another size": ("depth.npz", {"depth": np.ones((9, 9), np.float32)}, "is 9x9 pixels"),
    "depth in millimetres": ("depth.npz", {"depth": np.full((HEIGHT, WIDTH), 2500, np.uint16)}, "has type uint16"),
    "depth NaN": ("depth.npz", {"depth": np.full((HEIGHT, WIDTH), np.nan, np.float32)}, "holds NaN"),
    "depth negative": ("depth.npz", {"depth": np.full((HEIGHT, WIDTH), -1, np.float32)}, "holds -1"),
    "depth without a name": ("depth.npz", {"z": np.ones((HEIGHT, WIDTH))}, "no array named 'depth'"),
}


@pytest.mark.parametrize("case", list(EXTRACTED))
def test_what_lies_beside_objects(bench: Bench, case: str) -> None:
    name, content, words = EXTRACTED[case]
    path = bench.root / "extraction" / name
    np.savez(path, **content) if isinstance(content, dict) else Image.fromarray(content).save(path)
    bench.refused("objects", name, words)
    shutil.copy(bench.root / "input/rgb.png", bench.root / "extraction/rgb.png")
    with pytest.raises(InputError, match=name):
        SceneObjects(bench.path("objects"), bench.root / "extraction/rgb.png")


def replace(file: h5py.File, name: str, array: Any) -> None:
    del file[name]
    if array is not None:
        file[name] = array


SNAPSHOTS = {
    "no rgb": ("rgb", None, "has no array"),
    "a group": ("rgb", "group", "has no array"),
    "float": ("rgb", np.ones((2, 3, 16, 16, 3), np.float32), "rgb: has type float32"),
    "fewer assets": ("rgb", np.ones((1, 3, 16, 16, 3), np.uint8), "rgb: has shape (1, 3, 16, 16, 3)"),
    "fewer views": ("depth", np.ones((2, 2, 16, 16), np.uint16), "depth: has shape (2, 2, 16, 16)"),
    "other size": ("depth", np.ones((2, 3, 8, 8), np.uint16), "depth: has shape"),
    "nothing seen": ("depth", np.zeros((2, 3, 16, 16), np.uint16), "'cabinet_0' is not in its picture"),
}


@pytest.mark.parametrize("case", list(SNAPSHOTS))
def test_snapshots(bench: Bench, case: str) -> None:
    name, array, words = SNAPSHOTS[case]
    path = bench.root / "snapshots/shard_0.h5"
    with h5py.File(path, "a") as file:
        replace(file, name, None if isinstance(array, str) else array)
        if isinstance(array, str):
            file.create_group(name)
    bench.refused("snapshots", "shard_0.h5", words)
    if case != "nothing seen":  # a view without an object has no patches: matching says so
        with pytest.raises(InputError, match=r"shard_0\.h5"):
            SnapshotFile(path)


FEATURES = {
    "fewer rows": (np.ones((11, 4), np.float16), "has shape (11, 4), not (12, D)"),
    "one axis": (np.ones(12, np.float16), "rows: has shape (12,)"),
    "counts": (np.ones((12, 4), np.uint8), "rows: has type uint8"),
    "NaN": (np.full((12, 4), np.nan, np.float16), "rows: holds NaN"),
    "pickled": (np.array([{}], dtype=object), "is no readable npy file"),
}


@pytest.mark.parametrize("case", list(FEATURES))
def test_features(bench: Bench, case: str) -> None:
    array, words = FEATURES[case]
    path = bench.root / "features/shard_0.npy"
    np.save(path, array, allow_pickle=True)
    bench.refused("features", "shard_0.npy", words)
    if case != "NaN":  # a store is mapped, not read: only the check looks at every number
        with pytest.raises(InputError, match=r"shard_0\.npy"):
            FeatureStore([path], "abc")


COMPANIONS = {
    "fewer views": ({"wholes": np.ones((5, 8))}, "wholes: has shape (5, 8), not (6, W)"),
    "no views": ({"mean": np.ones(4)}, "has no array 'wholes'"),
    "codec without codes": (
        {"wholes": np.ones((6, 8)), "mean": np.ones(9), "components": np.ones((4, 9)), "steps": np.ones(4)},
        "is not the codec of these rows",
    ),
    "infinite": ({"wholes": np.full((6, 8), np.inf)}, "wholes: holds NaN or infinity"),
}


@pytest.mark.parametrize("case", list(COMPANIONS))
def test_what_goes_with_features(bench: Bench, case: str) -> None:
    arrays, words = COMPANIONS[case]
    np.savez(bench.root / "features/shard_0.npz", **arrays)
    bench.refused("features", "shard_0.npz", words)


def test_codes_without_a_codec(bench: Bench) -> None:
    np.save(bench.root / "features/shard_0.npy", np.ones((12, 4), np.int8))
    bench.refused("features", "shard_0.npz", "is not the codec of these rows")
    with refused("E-FEATURES-BROKEN"):
        FeatureStore([bench.root / "features/shard_0.npy"], "abc")
    np.savez(bench.root / "features/shard_0.npz", wholes=np.ones((6, 8)), components=np.ones((4, 9)), mean=np.ones(9))
    bench.refused("features", "shard_0.npz", "has no array 'steps'")


def test_feature_stores_that_do_not_belong_together(bench: Bench) -> None:
    path, other = bench.root / "features/shard_0.npy", bench.root / "features/shard_1.npy"
    for suffix in (".json", ".npz"):
        shutil.copy(path.with_suffix(suffix), other.with_suffix(suffix))
    np.save(other, np.ones((12, 5), np.float16))
    with pytest.raises(InputError, match=r"shard_1\.npy: rows: 5 numbers each"):
        FeatureStore([path, other], "abc")
    with pytest.raises(InputError, match="with other settings"):
        FeatureStore([path], "another digest")
    with pytest.raises(InputError, match="names no feature store"):
        FeatureStore([], "abc")
