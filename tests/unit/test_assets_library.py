"""The library command: index, archives, one clear line for a bad option."""

import json
import zipfile
from pathlib import Path

import pytest

from roomkin.plugins.furniture.library import make, run
from roomkin.stages.articulated.asset_folder import checksum, read_asset
from roomkin.stages.assets.join import run as join
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import describe_unusual, find_category
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.library import Asset, Library, LibraryEntry, LibraryPart
from roomkin.stages.contracts.library_folder import AssetFolders, write_part
from tests.refusals import refused

OPTIONS = json.dumps({"counts": {"mug": 2, "bottom_cabinet": 2, "picture": 1}})


def test_library_has_all_models_sorted_and_whole(tmp_path: Path) -> None:
    run(out=tmp_path / "library.json", options=OPTIONS, seed=5)
    library = read_json(Library, tmp_path / "library.json")
    names = ["bottom_cabinet_00", "bottom_cabinet_01", "mug_00", "mug_01", "picture_00"]
    assert [entry.id for entry in library.assets] == names
    folders = AssetFolders(tmp_path / "library.json")
    with refused("E-LIBRARY-ASSET", "has no asset"):
        folders["nothing_1"]
    for entry in library.assets:
        asset = folders.asset(entry.id)
        assert asset == read_asset(folders[entry.id]) and entry.archive == "library.zip"
        assert entry.checksum == asset.checksum == checksum(folders[entry.id])
        assert (entry.doors, entry.drawers, entry.category) == (asset.doors, asset.drawers, asset.category)
        assert asset.licence == "CC0-1.0"
        assert asset.provenance.endswith("seed 5")
    assert {path.name for path in tmp_path.iterdir()} == {"library.json", "library.zip"}


def test_same_seed_same_bytes_whatever_else_is_made(tmp_path: Path) -> None:
    alone = make("mug", 1, 5, tmp_path / "a")
    for name in ("b", "c"):
        run(out=tmp_path / name / "shard_1.json", shard=1, shards=2, options=OPTIONS, seed=5)
    part = AssetFolders(tmp_path / "b" / "shard_1.json")
    assert list(part) == ["bottom_cabinet_01", "mug_01"] and part.asset("mug_01") == alone
    assert (tmp_path / "b/shard_1.zip").read_bytes() == (tmp_path / "c/shard_1.zip").read_bytes()
    run(out=tmp_path / "b" / "shard_0.json", shard=0, shards=2, options=OPTIONS, seed=5)
    both = AssetFolders(tmp_path / "b" / "shard_1.json", tmp_path / "b" / "shard_0.json")
    assert list(both) == ["bottom_cabinet_00", "bottom_cabinet_01", "mug_00", "mug_01", "picture_00"]


def test_archives_are_read_safely(tmp_path: Path) -> None:
    """What does not fit the index, leads out of the archive or is broken is one line, and nothing is unpacked."""
    asset = make("mug", 0, 0, tmp_path / "models")
    index, archive = tmp_path / "library.json", tmp_path / "library.zip"
    write_part(index, tmp_path / "models")
    whole = archive.read_bytes()
    with zipfile.ZipFile(archive, "a") as opened:
        opened.writestr(f"{asset.id}/../../escaped", "x")
    with pytest.raises(InputError, match=r"library\.zip: holds 'mug_00/../../escaped', which leads out"):
        AssetFolders(index)[asset.id]
    archive.write_bytes(whole[:3000] + b"????" + whole[3004:])
    with pytest.raises(InputError, match=r"library\.zip: is no zip archive that can be read"):
        AssetFolders(index)[asset.id]
    archive.write_bytes(whole[:3000])
    with pytest.raises(InputError, match=r"library\.zip: is no zip archive that can be read"):
        AssetFolders(index).asset(asset.id)
    archive.unlink()
    with pytest.raises(InputError, match=r"library\.zip: no such file"):
        AssetFolders(index)[asset.id]
    write_part(tmp_path / "other" / "library.json", tmp_path / "models")
    make("mug", 0, 1, tmp_path / "models")
    write_part(index, tmp_path / "models")
    (tmp_path / "other" / "library.zip").write_bytes(archive.read_bytes())
    with pytest.raises(InputError, match=r"mug_00/asset\.json: checksum: is '.*', the index says '.*' of 'mug_00'"):
        AssetFolders(tmp_path / "other" / "library.json")[asset.id]


def test_bad_options_are_one_clear_line(tmp_path: Path) -> None:
    with refused("E-CATEGORY-UNKNOWN"):
        run(out=tmp_path / "library.json", options='{"counts": {"zeppelin": 1}}')
    with refused("E-LIBRARY-EMPTY"):
        run(out=tmp_path / "library.json", options='{"counts": {}}')
    with pytest.raises(InputError, match="counts"):
        run(out=tmp_path / "library.json", options='{"counts": {"mug": "many"}}')
    with refused("E-SHARD-NUMBER"):
        run(out=tmp_path / "library.json", shard=2, shards=2, options=OPTIONS)
    assert not (tmp_path / "library.json").exists()


def part(path: Path, *assets: Asset, left_out: tuple[str, ...] = ()) -> Path:
    entries = [LibraryEntry.of(asset, f"{path.stem}.zip") for asset in assets]
    write_json(path, LibraryPart(assets=entries, left_out=list(left_out)))
    return path


def test_of_other_categories_their_models_say_how_large_they_are(tmp_path: Path) -> None:
    mug = make("mug", 0, 0, tmp_path / "models")
    guitars = [mug.model_copy(update={"id": f"g{k}", "category": "guitar", "checksum": str(k)}) for k in range(3)]
    join(own=(part(tmp_path / "own.json", *guitars),), out=tmp_path / "library.json")
    known = AssetFolders(tmp_path / "library.json").categories
    assert describe_unusual(find_category("red guitars", known), mug.size) == ""
    assert "usual are" in describe_unusual(find_category("guitar", known), (1.0, 1.0, 1.0))
    join(own=(part(tmp_path / "own.json", *guitars[:2]),), out=tmp_path / "library.json")
    few = AssetFolders(tmp_path / "library.json").categories["guitar"]
    assert describe_unusual(few, (1.0, 1.0, 1.0)) == "", "two say nothing"


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
    assert library.categories == list(known_categories().values()), "what everybody knows"
    before = out.read_bytes()
    join(library=(ours,), own=own[::-1], out=out)
    assert out.read_bytes() == before, "in whatever order"
    with refused("E-MODEL-NAME"):
        join(library=(ours,), own=(part(tmp_path / "own_c.json", mugs[1]),), out=out)
    with refused("E-MODELS-UNUSABLE"):
        join(library=(ours,), own=(part(tmp_path / "own_c.json", left_out=("it: x",)),), out=out)
    with refused("E-LIBRARY-EMPTY"):
        join(own=(), out=out)
    with refused("E-LIBRARY-ELSEWHERE"):
        join(own=(part(tmp_path / "elsewhere" / "own_a.json", mugs[0]),), out=out)
