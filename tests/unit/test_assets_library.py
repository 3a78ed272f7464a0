"""The library verb: index, folders, one clear line for a bad option."""

import json
from pathlib import Path

import pytest

from stages.articulated.asset_folder import checksum
from stages.assets.library import index_of, make, run
from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.library import Asset, Library

OPTIONS = json.dumps({"counts": {"mug": 2, "bottom_cabinet": 2, "picture": 1}})


def test_library_has_all_models_sorted_and_whole(tmp_path: Path) -> None:
    run(out=tmp_path / "library.json", options=OPTIONS, seed=5)
    library = read_json(Library, tmp_path / "library.json")
    names = ["bottom_cabinet_00", "bottom_cabinet_01", "mug_00", "mug_01", "picture_00"]
    assert [entry.id for entry in library.assets] == names
    for entry in library.assets:
        folder = tmp_path / entry.folder
        asset = read_json(Asset, folder / "asset.json")
        assert entry.checksum == asset.checksum == checksum(folder)
        assert (entry.doors, entry.drawers, entry.category) == (asset.doors, asset.drawers, asset.category)
        assert asset.licence == "CC0-1.0"
        assert asset.provenance.endswith("seed 5")
    assert {path.name for path in tmp_path.iterdir()} == {"library.json", "models"}


def test_same_seed_same_bytes_whatever_else_is_made(tmp_path: Path) -> None:
    alone = make("mug", 1, 5, tmp_path / "a")
    run(out=tmp_path / "b" / "library.json", options=OPTIONS, seed=5)
    other = read_json(Asset, tmp_path / "b" / "models" / "mug_01" / "asset.json")
    assert alone == other


def test_bad_options_are_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"assets.counts: no category 'zeppelin'"):
        run(out=tmp_path / "library.json", options='{"counts": {"zeppelin": 1}}')
    with pytest.raises(InputError, match="would be empty"):
        run(out=tmp_path / "library.json", options='{"counts": {}}')
    with pytest.raises(InputError, match="counts"):
        run(out=tmp_path / "library.json", options='{"counts": {"mug": "many"}}')
    assert not (tmp_path / "library.json").exists()


def test_two_models_of_one_name(tmp_path: Path) -> None:
    asset = make("mug", 0, 0, tmp_path)
    with pytest.raises(InputError, match="two models are called 'mug_00'"):
        index_of([asset, asset])
