"""What of a library a picture alone needs drawn: with that matching finds the same as with all of it."""

import json
from pathlib import Path

import pytest

from roomkin.stages.assets.part import run as part
from roomkin.stages.contracts import Cousins, Library, LibraryPart, read_json
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.library_folder import SceneShards, holds, name_part
from roomkin.stages.matching.features import run as features
from roomkin.stages.matching.match import run as match
from roomkin.stages.matching.shards import choose_shards
from roomkin.stages.matching.shards import run as shards
from tests.refusals import refused
from tests.unit.matching_data import World, write_scene, write_snapshots

OPTIONS = json.dumps({"model_selection": "distance", "orientation_selection": "distance"})


def model(category: str, number: int, shard: int) -> LibraryEntry:
    name = f"{category}_{number}"
    return LibraryEntry(id=name, category=category, archive=f"shard_{shard}.zip", doors=0, drawers=0, checksum="")


CHAIRS, TABLES = ([model(category, number, number % 2) for number in range(4)] for category in ("chair", "table"))
MUGS = [model("mug", number, 1) for number in range(200)]


@pytest.mark.parametrize(
    ("wanted", "drawn", "chosen"),
    [
        (CHAIRS, [], [name_part(["chair"])]),
        (CHAIRS + TABLES, [], [name_part(["table", "chair"])]),
        (CHAIRS + TABLES, [name_part(["chair", "mug"])], [name_part(["chair", "mug"]), name_part(["table"])]),
        (CHAIRS, [name_part(["table"])], [name_part(["chair"])]),
        (CHAIRS, ["0", "1", name_part(["chair"])], ["0", "1"]),
        (CHAIRS + TABLES + MUGS, [], [name_part(["chair", "table"]), name_part(["mug"])]),
    ],
)
def test_what_is_drawn_is_used_and_only_what_lacks_is_named(
    wanted: list[LibraryEntry], drawn: list[str], chosen: list[str]
) -> None:
    assert choose_shards(wanted, drawn) == chosen
    assert all(any(holds(shard, entry) for shard in chosen) for entry in wanted)


def test_matching_with_what_a_picture_needs_finds_the_same_as_with_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the cabinets alone, of a library that has shelves and bowls, too."""
    world = World(tmp_path)
    objects = write_scene(tmp_path / "picture", [("cabinet_00", 0.5, {}), ("cabinet_02", -0.4, {"label": "cupboard"})])
    drawn = tmp_path / "drawn"
    given = {"objects": objects, "library": world.library}
    shards(**given, snapshots=drawn, out=tmp_path / "shards.json")
    (name,) = read_json(SceneShards, tmp_path / "shards.json").shards
    part(library=world.library, shard=name, out=tmp_path / "part.json")
    models = [entry.id for entry in read_json(LibraryPart, tmp_path / "part.json").assets]
    assert models and {model.rpartition("_")[0] for model in models} == {"cabinet"}

    pictures = write_snapshots(drawn / f"shard_{name}.h5", models)
    features(snapshots=pictures, out=tmp_path / "part.npy")
    given |= {"image": objects.parent / "rgb.png", "options": OPTIONS}
    match(**given, features=(tmp_path / "part.npy",), out=tmp_path / "some.json")
    match(**given, features=tuple(world.features), out=tmp_path / "all.json")
    some, whole = (read_json(Cousins, tmp_path / f"{which}.json") for which in ("some", "all"))
    assert some.objects == whole.objects and some.objects[0].cousins[0].asset == "cabinet_00"

    capsys.readouterr()
    shards(objects=world.objects, library=world.library, snapshots=drawn, out=tmp_path / "next.json")
    all_models = len(read_json(Library, world.library).assets)
    assert f"; {all_models - len(models)} of the library must be drawn first" in capsys.readouterr().out
    write_snapshots(drawn / f"shard_{name}.h5", models[1:])  # one is new: all that is drawn with it is drawn again
    shards(objects=world.objects, library=world.library, snapshots=drawn, out=tmp_path / "next.json")
    assert f"; {all_models} of the library must be drawn first" in capsys.readouterr().out
    first, second = read_json(SceneShards, tmp_path / "next.json").shards
    assert first == name and second == name_part(["bowl", "shelf"])
    given |= {"objects": world.objects, "image": world.objects.parent / "rgb.png"}
    with refused("E-FEATURES-MISSING"):
        match(**given, features=(tmp_path / "part.npy",), out=tmp_path / "next.json")


def test_a_part_that_the_library_does_not_have_is_refused(tmp_path: Path) -> None:
    with refused("E-LIBRARY-EMPTY"):
        part(library=World(tmp_path).library, shard=name_part(["sofa"]), out=tmp_path / "part.json")
