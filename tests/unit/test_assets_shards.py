"""Shards of the user's models: what is together, which files count, and shards in which nothing can be used."""

import json
import os
import zipfile
from pathlib import Path

import pytest

from roomkin.plugins.importing import own
from roomkin.plugins.importing.shards import MEAN, Shard, groups, own_shards
from roomkin.plugins.pictures import snapshots as sheets
from roomkin.stages.assets import snapshots
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.contracts import InputError, LibraryPart, read_json
from roomkin.stages.contracts.__main__ import main as check
from roomkin.stages.matching.encoders import make_encoder, settings_digest
from roomkin.stages.matching.features import run as encode
from roomkin.stages.matching.store import FeatureStore
from tests.refusals import refused

HOG = EncoderOptions(encoder="hog")


def write(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)
    return folder


def shards_of(*folders: Path, **options: object) -> dict[str, Shard]:
    return own_shards(AssetsConfig.model_validate({"counts": {}, "folders": [str(one) for one in folders], **options}))


def digests(*folders: Path) -> dict[str, str]:
    """Of every model's shard, by the model."""
    return {name: shard.digest() for shard in shards_of(*folders).values() for name in shard.models}


def test_a_new_name_changes_one_group_or_cuts_it() -> None:
    names = [f"chair_{number}" for number in range(400)]
    before = groups(names)
    assert sorted(name for group in before for name in group) == sorted(names)
    assert MEAN / 2 < len(names) / len(before) < MEAN * 2
    assert groups(names[::-1]) == before
    for new in ("table", "stool_1", "stool_2", "stool_3", "stool_4", "stool_5"):
        after = groups([*names, new])
        gone = [group for group in before if group not in after]
        made = [group for group in after if group not in before]
        assert len(gone) <= 1 and len(made) <= 2
        assert sum(map(len, made)) == sum(map(len, gone)) + 1


@pytest.mark.parametrize(
    ("changed", "models"),
    [
        ("bowl/a/meshes/a.obj", {"bowl_a"}), ("bowl/a/asset.json", {"bowl_a"}), ("bowl/flat.obj", {"bowl_flat"}),
        ("45/meta.json", {"mine_45"}), ("common/wood.png", {"bowl_a", "bowl_flat", "mine_45"}), ("jug/c/c.urdf", set()),
        ("index.html", None),
    ],
)  # fmt: skip
def test_a_change_makes_anew_what_may_read_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: str, models: set[str] | None
) -> None:
    """A model's own folder, and what lies in no model's; everything, where other folders are named; no page of ours."""
    monkeypatch.setattr("roomkin.plugins.importing.shards.MEAN", 1)  # every model by itself
    mine = write(tmp_path / "mine", "bowl/a/model.urdf", "bowl/a/meshes/a.obj", "bowl/flat.obj", "45/mobility.urdf")
    write(mine, "45/meta.json", "common/wood.png", "jug/c/c.urdf")
    (mine / "jug/c/c.urdf").write_text('<mesh filename="package://bowl/a.obj"/>')
    before = digests(mine)
    assert set(before) == {"bowl_a", "bowl_flat", "mine_45", "jug_c"}
    for path in mine.rglob("*"):
        os.utime(path)
    assert digests(mine) == before, "only touched"
    path = mine / changed
    path.write_text(path.read_text() + " " if path.exists() else "{}")
    after = digests(mine)
    assert {name for name in after if after[name] != before[name]} == (set() if models is None else models | {"jug_c"})


def test_folders_do_not_share_shards_and_names_are_numbered(tmp_path: Path) -> None:
    one, two = write(tmp_path / "one", "jug/a.obj", "mug/00.obj"), write(tmp_path / "two", "jug/a.obj", "bowl/b.obj")
    alone, both = shards_of(one), shards_of(one, two, one, counts={"mug": 2})
    assert {name for shard in both.values() for name in shard.models} == {"jug_a", "mug_00_2", "jug_a_2", "bowl_b"}
    assert all(len({file.parent.parent for file in shard.models.values()}) == 1 for shard in both.values())
    assert shards_of(one, two)[next(iter(alone))] == next(iter(alone.values()))
    (one / "jug/asset.json").write_text('{"category": "jar"}')
    assert "jar_a" in digests(one)
    (one / "jug/asset.json").write_text("broken notes, which are said when it is imported")
    assert "jug_a" in digests(one)
    with refused("E-MODELS-NONE"):
        shards_of(tmp_path / "three")


def test_a_shard_of_broken_models_is_empty_all_the_way(tmp_path: Path) -> None:
    mine = write(tmp_path / "mine", "jug/a.obj")
    out, options = tmp_path / "own_0.json", '{"n_snap": 2, "image_size": 96}'
    own.run(folder=mine, models=(f"jug_a={mine / 'jug/a.obj'}",), out=out)
    part = read_json(LibraryPart, out)
    assert part.assets == [] and len(part.left_out) == 1 and "a.obj: holds no triangles" in part.left_out[0]
    assert zipfile.ZipFile(tmp_path / "own_0.zip").namelist() == []
    shard, features = tmp_path / "shard_own_0.h5", tmp_path / "features.npy"
    snapshots.run(library=out, out=shard, options=options)
    sheets.run(snapshots=(shard,))
    encode(snapshots=shard, out=features, options=json.dumps(HOG.keep_stored()))
    assert check(["library_part", str(out), "snapshots", str(shard), "features", str(features)]) == 0
    with pytest.raises(InputError, match="names no feature store"):
        FeatureStore([features], settings_digest(HOG, make_encoder(HOG)))
    with refused("E-MODELS-NONE"):
        own.run(folder=mine, models=("jug_b=gone.obj",), out=out)
