"""The library verb: index, folders, one clear line for a bad option."""

import json
from pathlib import Path

import pytest

from stages.articulated.asset_folder import checksum
from stages.assets.join import run as join
from stages.assets.library import make, run
from stages.contracts.errors import InputError
from stages.contracts.files import read_json, write_json
from stages.contracts.library import Asset, Library, LibraryEntry, LibraryPart

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


def part(path: Path, *assets: Asset, left_out: tuple[str, ...] = ()) -> Path:
    entries = [LibraryEntry.of(asset, f"models/{asset.id}") for asset in assets]
    write_json(path, LibraryPart(assets=entries, left_out=list(left_out)))
    return path


def test_parts_are_joined_without_copies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mugs = [make("mug", k, 0, tmp_path / "models") for k in range(3)]
    copy = mugs[0].model_copy(update={"id": "a_mug", "checksum": mugs[2].checksum})
    out, ours = tmp_path / "library.json", part(tmp_path / "procedural.json", mugs[1])
    own = (part(tmp_path / "own_b.json", mugs[2]), part(tmp_path / "own_a.json", copy, mugs[0], left_out=("it: x",)))
    join(library=(ours,), own=own, out=out)
    library = read_json(Library, out)
    assert [entry.id for entry in library.assets] == ["a_mug", "mug_00", "mug_01"]
    assert library.left_out == ["it: x", "mug_02: is a copy of a_mug"]
    assert [line for line in capsys.readouterr().out.splitlines() if line.startswith("left out: ")] == [
        f"left out: {line}" for line in library.left_out
    ]
    before = out.read_bytes()
    join(library=(ours,), own=own[::-1], out=out)
    assert out.read_bytes() == before, "in whatever order"
    with pytest.raises(InputError, match="two models are called 'mug_01'"):
        join(library=(ours,), own=(part(tmp_path / "own_c.json", mugs[1]),), out=out)
    with pytest.raises(InputError, match=r"none of the models can be used\. it: x"):
        join(library=(ours,), own=(part(tmp_path / "own_c.json", left_out=("it: x",)),), out=out)
    with pytest.raises(InputError, match="would be empty"):
        join(own=(), out=out)
    with pytest.raises(InputError, match="does not lie beside"):
        join(own=(part(tmp_path / "elsewhere" / "own_a.json", mugs[0]),), out=out)
