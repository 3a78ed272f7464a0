"""Encoder: what is photographed for training."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from stages.contracts import InputError
from stages.encoder.assemblies import assembly
from stages.encoder.render import run as render
from stages.procedural.catalogue import CATEGORIES


def test_pairs_are_repeated_byte_for_byte_and_leave_categories_out(tmp_path: Path) -> None:
    held_out = [category for category in CATEGORIES if category not in ("stool", "bottle")]
    options = json.dumps({"held_out": held_out, "models": 1, "assemblies": 1, "views": 3})
    for name in ("one", "again"):
        render(shard=0, shards=1, out=tmp_path / f"{name}.h5", options=options, seed=5)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "again.h5").read_bytes()
    with h5py.File(tmp_path / "one.h5") as file:
        assert sorted(name.decode() for name in file["models"]) == ["assembly_0", "bottle_0", "stool_0"]
        shares = (file["crops"][..., 3] >= 128).mean(axis=(2, 3))
        found = (file["matches"][:] >= 0).mean(axis=1)
        assert (shares > 0.05).all() and (found > 0.25 * shares[:, 0]).all()
        inside = file["crops"][:][..., 3] == 0
        assert (file["crops"][:][inside][:, :3] == 127).all()


def test_an_unknown_category_cannot_be_held_out(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no category 'unicorn'"):
        render(shard=0, shards=1, out=tmp_path / "x.h5", options='{"held_out": ["unicorn"]}')


def test_assemblies_are_solids_of_any_shape() -> None:
    sizes = [len(assembly(np.random.default_rng(seed)).base) for seed in range(20)]
    assert min(sizes) >= 3 and max(sizes) > 9
