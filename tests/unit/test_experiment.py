"""`matching distances` and `experiment select`: which assets a policy experiment trains and tests on."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from stages.articulated.affordance import target_joint
from stages.config.matching import MatchingConfig
from stages.contracts import Asset, GeneratedScene, InputError, TaskAssets, read_json, write_json
from stages.contracts.cousins import Candidate, CategoryMatch, ObjectCousins
from stages.contracts.distances import Distances
from stages.contracts.generated import PlacedObject
from stages.contracts.library import Joint, LibraryEntry
from stages.experiment.select import choose_cousins
from stages.experiment.select import run as select
from stages.matching.distances import distances_to
from stages.matching.distances import run as distances
from stages.matching.encoders import make_encoder, settings_digest
from stages.matching.store import FeatureStore
from tests.unit.matching_data import MODELS, World


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("experiment"))


def write_asset(world: World, name: str, doors: list[tuple[str, float, float, str]], origin: str = "0 0 0") -> Path:
    """An asset folder whose doors are boxes: (handle or '', width, height of the centre, axis)."""
    folder = world.folder / "models" / name
    folder.mkdir(parents=True, exist_ok=True)
    links, joints = '<link name="base"/>', []
    for number, (handle, width, height, axis) in enumerate(doors):
        panel = f'<geometry><mesh filename="panel.obj" scale="1 {width} 1"/></geometry>'
        links += f'<link name="l{number}"><visual><origin xyz="0 0 0.1"/>{panel}</visual></link>'
        links += f'<joint name="j{number}" type="revolute"><parent link="base"/><child link="l{number}"/>'
        links += f'<origin xyz="0.2 0 {height - 0.1}" rpy="{origin}"/><axis xyz="{axis}"/>'
        links += '<limit lower="0" upper="1.57"/></joint>'
        joints.append(
            Joint(
                name=f"j{number}",
                type="revolute",
                role="door",
                parent="base",
                link=f"l{number}",
                axis=tuple(float(value) for value in axis.split()),
                lower=0,
                upper=1.57,
                handle_link=handle or None,
            )
        )
    trimesh.creation.box((0.02, 1, 0.4)).export(folder / "panel.obj")
    (folder / "model.urdf").write_text(f'<robot name="{name}">{links}</robot>')
    asset = Asset(
        id=name,
        category=MODELS[name][0],
        box_min=(-0.2, -0.4, 0),
        box_max=(0.2, 0.4, 1.0),
        mass=1,
        joints=joints,
        doors=len(doors),
        licence="CC0-1.0",
        provenance="test",
        checksum="0",
    )
    write_json(folder / "asset.json", asset)
    return folder


UP, DOWN, FLAP = "0 0 1", "0 0 -1", "0 1 0"


def test_target_joint_is_the_largest_reachable_one(world: World) -> None:
    def chosen(*doors: tuple[str, float, float, str]) -> str | None:
        panel = target_joint(write_asset(world, "cabinet_00", list(doors)), "door")
        return panel.joint if panel else None

    assert chosen(("h", 0.3, 0.5, UP), ("h", 0.6, 0.5, UP)) == "j1"  # larger
    assert chosen(("h", 0.3, 0.5, UP), ("", 0.6, 0.5, UP)) == "j0"  # has a handle
    assert chosen(("h", 0.4, 0.9, UP), ("h", 0.4, 0.6, UP)) == "j1"  # as large, nearer to mid-height
    assert chosen(("h", 0.4, 0.5, UP), ("h", 0.4, 0.5, DOWN)) == "j0"  # the first by name
    assert chosen(("h", 0.6, 0.5, FLAP), ("h", 0.3, 0.5, UP)) == "j1"  # a flap is no door
    assert chosen(("h", 0.6, 0.5, FLAP)) is None and chosen(("", 0.6, 0.5, UP)) is None
    twin = target_joint(write_asset(world, "cabinet_00", [("h", 0.4, 0.5, DOWN)]), "door")
    folder = write_asset(world, "cabinet_00", [("h", 0.4, 0.5, UP), ("h", 0.3, 0.5, DOWN)])
    like = target_joint(folder, "door", twin)
    assert like is not None and like.joint == "j1"  # turns as the twin's does, and is large enough
    turned = target_joint(write_asset(world, "cabinet_00", [("h", 0.4, 0.5, "0 -1 0")], "1.5707963 0 0"), "door")
    assert turned is not None and turned.axis[2] == pytest.approx(-1.0)  # the joint frame is turned, the hinge upright
    assert target_joint(folder, "drawer") is None


@pytest.fixture(scope="module")
def experiment(world: World) -> dict[str, Any]:
    """A scene with matched cousins whose assets have doors."""
    for name, (_, _, _, doors, drawers) in MODELS.items():
        if doors + drawers:
            write_asset(world, name, [("h", 0.4, 0.5, UP)])
    cousins = world.folder / "cousins.json"
    world.match(cousins, count_threshold=None)
    scene = world.folder / "scene_1.json"
    placed = [
        PlacedObject(id="cabinet_1", label="cabinet", asset="cabinet_00", category="cabinet", size=(0.5, 0.8, 0.9)),
        PlacedObject(id="bowl_4", label="bowl", asset="bowl_01", category="bowl", size=(0.2, 0.2, 0.2)),
    ]
    identity = np.eye(4).tolist()
    generated = GeneratedScene(
        scene="test",
        variant="b",
        rank=1,
        width=8,
        height=8,
        intrinsics=np.eye(3).tolist(),
        floor_from_camera=identity,
        walls=[],
        objects=placed,
    )
    write_json(scene, generated)
    return {"cousins": cousins, "scene_file": scene, "library": world.library, "task": "door"}


def alike(world: World, experiment: dict[str, Any], object: str) -> Path:
    """The distances file of an object."""
    out = world.folder / "distances" / f"{object}.json"
    if not out.exists():
        files = {"cousins": experiment["cousins"], "library": world.library, "features": world.features}
        distances(**files, object=object, out=out)
    return out


def test_distances_are_those_of_a_search_among_any_of_the_assets(world: World, experiment: dict[str, Any]) -> None:
    """Columns do not depend on each other: a table of all articulated assets serves every task."""
    table = read_json(Distances, alike(world, experiment, "cabinet_1"))
    assert table.assets == [name for name, model in MODELS.items() if model[3] + model[4]]
    assert set(table.distances) <= set(table.assets)
    options = MatchingConfig()
    encoder = make_encoder(options)
    store = FeatureStore(world.features, settings_digest(options, encoder))
    some = ["cabinet_03", "cabinet_00"]
    among = distances_to("cabinet_00", some, store, encoder.weights(True), options)
    assert [table.from_asset("cabinet_00")[asset] for asset in some] == among and among[1] == 0.0 < among[0]


def test_select_ranks_cousins_by_distance_to_the_twin(world: World, experiment: dict[str, Any], tmp_path: Path) -> None:
    files = experiment | {"distances": alike(world, experiment, "cabinet_1")}
    select(**files, object="cabinet_1", count=3, out=tmp_path / "task.json")
    result = read_json(TaskAssets, tmp_path / "task.json")
    assert [asset.role for asset in result.assets] == ["twin", "cousin_1", "cousin_2", "cousin_3", "dissimilar"]
    twin, *others = result.assets
    assert (twin.asset, twin.distance) == ("cabinet_00", 0.0)
    distances = [asset.distance for asset in others]
    assert distances == sorted(distances) and distances[0] > 0
    assert len({asset.asset for asset in result.assets}) == 5
    assert {asset.size for asset in result.assets} == {(0.5, 0.8, 0.9)} and {a.joint for a in others} == {"j0"}


@pytest.mark.parametrize(
    ("object", "count", "message"),
    [
        ("cabinet_9", 1, "'cabinet_9' is not in the scene.*would do for a door: cabinet_1, cabinet_2"),
        ("bowl_4", 1, "has no cousin with a door to open"),
        ("lost_1", 1, r"failed \(extraction: no points\)"),
        ("cabinet_2", 1, "was not placed"),
        ("cabinet_1", 9, "has 4 cousins with a door that has a handle, 9 are asked for"),
    ],
)
def test_select_says_which_objects_would_do(
    world: World, experiment: dict[str, Any], tmp_path: Path, object: str, count: int, message: str
) -> None:
    files = experiment | {"distances": alike(world, experiment, object)}
    with pytest.raises(InputError, match=message):
        select(**files, object=object, count=count, out=tmp_path / "task.json")
    assert not (tmp_path / "task.json").exists()


def test_distances_of_another_object_are_refused(world: World, experiment: dict[str, Any], tmp_path: Path) -> None:
    files = experiment | {"distances": alike(world, experiment, "cabinet_2")}
    with pytest.raises(InputError, match="is of 'cabinet_2' in test by hog, not of 'cabinet_1' in test"):
        select(**files, object="cabinet_1", count=3, out=tmp_path / "task.json")
    table = read_json(Distances, alike(world, experiment, "cabinet_1"))
    write_json(tmp_path / "d.json", table.model_copy(update={"distances": {}}))
    with pytest.raises(InputError, match="has no distances from cabinet_00, the twin"):
        select(**experiment | {"distances": tmp_path / "d.json"}, object="cabinet_1", count=3, out=tmp_path / "t.json")
    assert not (tmp_path / "task.json").exists()


def test_cousins_are_ordered_by_distance_whichever_list_they_come_from() -> None:
    """Candidates are taken first, but the nearest is cousin_1 (Table 3)."""
    names = ("cabinet_twin", "cabinet_near", "cabinet_far", "cabinet_last", "bowl_near")
    distances = dict(zip(names, (0.0, 0.1, 0.5, 0.9, 0.05), strict=True))
    entries = {
        name: LibraryEntry(id=name, category=name.split("_")[0], folder=name, doors=1, drawers=0, checksum="")
        for name in names
    }
    item = ObjectCousins(
        id="cabinet_1",
        label="cabinet",
        status="failed",
        reason="no matter",
        categories=[CategoryMatch(category="cabinet", distance=0.0)],
        by_distance=[Candidate(asset="cabinet_far", category="cabinet", distance=0.5)],
    )
    assert choose_cousins(item, "cabinet_twin", distances, entries, 1) == ["cabinet_far"]
    assert choose_cousins(item, "cabinet_twin", distances, entries, 2) == ["cabinet_near", "cabinet_far"]
    assert choose_cousins(item, "cabinet_twin", distances, entries, 9) == [
        "cabinet_near",
        "cabinet_far",
        "cabinet_last",
    ]
