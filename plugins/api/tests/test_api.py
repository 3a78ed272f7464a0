"""A library that is made again in its folder leaves nothing of the one before."""

from pathlib import Path

from roomkin import load_policy, make_library, make_room, make_scenes, models_of
from roomkin.plugins.api.making import _features, _settings
from roomkin.stages.config.assets import COUNTS
from tests.refusals import refused


def config(mugs: int, **changes: object) -> dict[str, object]:
    counts = dict.fromkeys(COUNTS, 0) | {"mug": mugs}
    few = {"matching": {"views": 2, "k_ori": 2}}
    return {"assets": {"counts": counts, "n_snap": 2, "image_size": 64}} | few | changes


def test_a_library_replaces_another(tmp_path: Path) -> None:
    made, own = [], tmp_path / "features/notes.txt"
    own.parent.mkdir()
    own.write_text("not ours")
    for mugs, seed, shards in ((3, 1, 3), (2, 2, 2)):
        changes = config(mugs, seed=seed)
        changes["assets"]["shards"] = shards  # type: ignore[index]
        library = make_library(tmp_path, changes)
        assert library == tmp_path / "library.json" and list(models_of(library)) == [f"mug_0{i}" for i in range(mugs)]
        assert len(list(tmp_path.glob("shard_*.zip"))) == len(list(tmp_path.glob("snapshots/*.h5"))) == shards
        features = _features(_settings(changes), "default", tmp_path / "snapshots/shard_0.h5")
        made.append(features.read_bytes())
    assert made[0] != made[1] and own.read_text() == "not ours"
    assert len(list(tmp_path.glob("features/*/*.npy"))) == 1


def test_mistakes_are_refused_before_anything_is_made(tmp_path: Path) -> None:
    library = tmp_path / "library/library.json"
    with refused("E-CONFIG-KEY", "did you mean 'encoder'"):
        make_library(tmp_path / "library", {"matching": {"encodr": "hog"}})
    with refused("E-FILE-MISSING", "library.json"):
        make_scenes(tmp_path / "kitchen", library, tmp_path / "scenes")
    with refused("E-FILE-MISSING", "library.json"):
        make_room("room_1", library, tmp_path / "rooms")
    with refused("E-FILE-MISSING", "config.json"):
        load_policy(tmp_path / "policy")
    assert not list(tmp_path.iterdir())


def test_a_picture_that_is_not_there_is_named_with_the_nearest_that_is(tmp_path: Path) -> None:
    library = make_library(tmp_path / "library", config(1))
    with refused("E-FILE-MISSING", "no folder ", "kitchn. Fix: docs/scenes.md"):
        make_scenes(tmp_path / "kitchn", library, tmp_path / "scenes")
    (tmp_path / "kitchen").mkdir()
    (tmp_path / "kitchen/camera.json").touch()
    with refused("E-FILE-MISSING", "did you mean 'kitchen'"):
        make_scenes(tmp_path / "kitchn", library, tmp_path / "scenes")
    with refused("E-FILE-MISSING", "kitchen has no rgb.png. Fix: docs/scenes.md"):
        make_scenes(tmp_path / "kitchen", library, tmp_path / "scenes")
