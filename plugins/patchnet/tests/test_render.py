"""What is photographed for training."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from plugins.furniture.catalogue import CATEGORIES
from plugins.patchnet.training.assemblies import assembly
from plugins.patchnet.training.options import PairOptions
from plugins.patchnet.training.render import render
from tests.refusals import refused


def test_pairs_are_repeated_byte_for_byte_and_leave_categories_out(tmp_path: Path) -> None:
    held_out = [category for category in CATEGORIES if category not in ("stool", "bottle")]
    options = PairOptions(tuple(held_out), models=1, assemblies=1, views=3)
    for name in ("one", "again"):
        render(tmp_path / f"{name}.h5", options, 5)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "again.h5").read_bytes()
    written = (tmp_path / "one.h5").stat().st_mtime_ns
    render(tmp_path / "one.h5", options, 5)
    assert (tmp_path / "one.h5").stat().st_mtime_ns == written  # it is there
    render(tmp_path / "again.h5", options, 6)
    assert (tmp_path / "again.h5").read_bytes() != (tmp_path / "one.h5").read_bytes()
    with h5py.File(tmp_path / "one.h5") as file:
        assert sorted(name.decode() for name in file["models"]) == ["assembly_0", "bottle_0", "stool_0"]
        shares = (file["crops"][..., 3] >= 128).mean(axis=(2, 3))
        found = (file["matches"][:] >= 0).mean(axis=1)
        assert (shares > 0.05).all() and (found > 0.25 * shares[:, 0]).all()
        inside = file["crops"][:][..., 3] == 0
        assert (file["crops"][:][inside][:, :3] == 127).all()


def test_an_unknown_category_cannot_be_held_out(tmp_path: Path) -> None:
    with refused("E-CATEGORY-UNKNOWN"):
        render(tmp_path / "x.h5", PairOptions(("unicorn",)), 0)


def test_assemblies_are_solids_of_any_shape() -> None:
    sizes = [len(assembly(np.random.default_rng(seed)).base) for seed in range(20)]
    assert min(sizes) >= 3 and max(sizes) > 9


def test_the_command_ends_with_one_line(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "plugins.patchnet", "--out", str(tmp_path), "--pairs.held-out", "unicorn"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and list(tmp_path.iterdir()) == []
    assert done.stderr.startswith("error: ") and done.stderr.endswith("[E-CATEGORY-UNKNOWN]\n")
    assert done.stderr.count("\n") == 1
