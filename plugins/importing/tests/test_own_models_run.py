"""Folders of models that come, grow, change and go: what is new is imported, photographed and encoded, nothing else."""

import json
import os
import shutil
from pathlib import Path

import pytest
import trimesh

from roomkin.plugins.importing.own import run as own
from roomkin.plugins.importing.shards import own_shards
from roomkin.stages.config.assets import COUNTS, AssetsConfig
from roomkin.stages.config.model import load, with_defaults
from roomkin.stages.config.reads import stores
from tests.workflow.workspace import MICRO, ROOT, copy, dry_run, make, overlay, planned, put, snakemake

LIBRARY = "results/assets/library"


def write_models(folder: Path, *names: str) -> None:
    for name in names:
        (folder / "crate" / name).mkdir(parents=True)
        trimesh.creation.box((0.2, 0.3, 0.1 + len(list(folder.parent.rglob("*.obj"))) / 10)).export(
            folder / "crate" / name / "box.obj"
        )


def asked(folder: Path, *folders: str) -> tuple[str, ...]:
    """Arguments for library and features of the models in `folders` alone."""
    changes = {
        "assets": {"counts": dict.fromkeys(COUNTS, 0), "folders": list(folders), "n_snap": 4, "image_size": 96},
        "matching": {"encoder": "hog", "views": 4, "hog": {"image_size": 96, "grid": 12}},
    }
    (folder / "own.yaml").write_text(json.dumps(changes))
    (store,) = stores(load(with_defaults(changes)))
    shards = own_shards(AssetsConfig.model_validate(changes["assets"]))
    files = [f"results/matching/features/{store}/shard_{shard}.npy" for shard in shards]
    return (f"{LIBRARY}/library.json", *files, "--configfile", "own.yaml")


def would_run(folder: Path, *folders: str) -> dict[str, int]:
    done = dry_run(folder, *asked(folder, *folders))
    assert done.returncode == 0, done.stdout
    return {name: count for name, count in planned(done.stdout).items() if not name.startswith("results")}


def runs(folder: Path, *folders: str) -> None:
    done = snakemake(folder, *asked(folder, *folders))
    assert done.returncode == 0, done.stdout[-3000:]


def one_shard(**more: int) -> dict[str, int]:
    return {"own": 1, "snapshots": 1, "features": 1, "library": 1} | more


def test_what_is_new_is_made_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = make(tmp_path / "run")
    monkeypatch.chdir(folder)
    for name, model in (("mine", "a"), ("theirs", "c"), ("hers", "e")):
        write_models(folder / name, model)
    runs(folder, "mine", "theirs")
    assert would_run(folder, "mine", "theirs", "hers") == one_shard()
    for path in folder.glob("*/crate/*/*"):
        os.utime(path)
    assert would_run(folder, "mine", "theirs") == {}, "touched, not changed"

    write_models(folder / "theirs", "d")
    assert would_run(folder, "mine", "theirs") == one_shard()
    runs(folder, "mine", "theirs")
    (folder / "theirs/crate/d/asset.json").write_text('{"licence": "CC0"}')
    assert would_run(folder, "mine", "theirs") == one_shard()
    (folder / "theirs/crate/d/asset.json").unlink()
    assert would_run(folder, "mine", "theirs") == {}

    assert would_run(folder, "theirs") == {"library": 1}
    runs(folder, "theirs")
    entries = json.loads((folder / LIBRARY / "library.json").read_text())["assets"]
    assert [entry["id"] for entry in entries] == ["box_c", "box_d"], "nothing of the other is left"

    config = AssetsConfig.model_validate({"counts": dict.fromkeys(COUNTS, 0), "folders": ["theirs"]})
    ((name, shard),) = own_shards(config).items()
    again = tmp_path / f"again/shard_{name}.json"
    own(folder=Path("theirs"), models=tuple(shard.list_files("theirs")), out=again)
    for path in (again, again.with_suffix(".zip")):
        grown = folder / LIBRARY / path.name
        assert path.read_bytes() == grown.read_bytes(), "as if all had been there from the first"


def test_a_folder_leaves_procedural_models_and_rooms_as_they_are(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    write_models(folder / "mine_", "c", "d")
    done = dry_run(folder, "matching", *overlay(folder, "assets: {folders: [mine_]}"))
    assert planned(done.stdout) == one_shard(match=1, draw_cousins=1, matching=1), done.stdout
    done = dry_run(folder, "all", *MICRO)
    assert "Nothing to be done" in done.stdout, done.stdout[-3000:]


def test_own_models_alone_are_a_library_for_a_picture(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    write_models(folder / "mine", "a")
    shutil.copytree(ROOT / "tests/data/photographed_room", folder / "room")
    (folder / "room/rgb.jpg").rename(folder / "room/rgb.png")
    put(folder / "room/depth.npz", folder / "room/masks.png")  # their headers are looked at
    experiment = "experiment: {rooms: [room], inputs: {room: room}, targets: {door: null}}"
    given = overlay(folder, f"{{assets: {{folders: [mine], own_only: true}}, {experiment}}}")
    done = dry_run(folder, "matching", *given)
    assert done.returncode == 0, done.stdout[-3000:]
    jobs = planned(done.stdout)
    assert jobs["own"] == jobs["match"] == 1 and "procedural" not in jobs, jobs
