"""Matching end to end on a ray-traced library: features, match, select, and what happens to bad input."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from stages.articulated.affordance import target_joint
from stages.contracts import Asset, Cousins, GeneratedScene, InputError, TaskAssets, read_json, write_json
from stages.contracts.generated import PlacedObject
from stages.contracts.library import Joint
from stages.geometry.frames import angle_difference
from stages.matching.features import run as features
from stages.matching.match import run as match
from stages.matching.select import run as select
from tests.unit.matching_data import MODELS, write_library, write_scene, write_snapshots

SHOWN: list[tuple[str, float, dict]] = [
    ("cabinet_00", 0.5, {}),
    ("cabinet_01", -0.4, {}),
    ("shelf_00", 0.9, {}),
    ("bowl_01", 0.2, {}),
    ("cabinet_02", 0.1, {"id": "lost_1", "status": "failed", "reason": "no points", "mask": 5}),
    ("bowl_00", 0.1, {"id": "unseen_1", "mask": 99}),
]


class World:
    """Files of one library and one scene."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.library = write_library(folder)
        names = sorted(MODELS)
        self.snapshots = [write_snapshots(folder / f"shard_{k}.h5", names[k::2]) for k in range(2)]
        self.features = [folder / "features" / f"shard_{k}.npy" for k in range(2)]
        for snapshots, out in zip(self.snapshots, self.features, strict=True):
            features(snapshots=snapshots, out=out)
        self.objects = write_scene(folder / "scene", SHOWN)

    def match(self, out: Path, **options: Any) -> Cousins:
        snapshots = self.snapshots if options.pop("picture", False) else None
        match(
            objects=self.objects,
            image=self.objects.parent / "rgb.png",
            library=self.library,
            features=self.features,
            snapshots=snapshots,
            out=out,
            options=json.dumps(options),
        )
        return read_json(Cousins, out)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("matching"))


@pytest.mark.parametrize("decides", ["distance", "votes"])
def test_models_and_orientations_are_found(world: World, tmp_path: Path, decides: str) -> None:
    result = world.match(tmp_path / "cousins.json", model_selection=decides, orientation_selection=decides, k_cousins=3)
    for (name, yaw, _), entry in list(zip(SHOWN, result.objects, strict=True))[:4]:
        assert entry.status == "ok" and entry.decided_by == entry.orientation_decided_by == decides
        best = entry.cousins[0]
        assert best.asset == name, f"{entry.id}: {[cousin.asset for cousin in entry.cousins]}"
        if best.category != "bowl":  # their sides look alike
            assert angle_difference(best.orientation.yaw, yaw) <= 0.42, entry.id  # steps of 0.39
        assert [cousin.rank for cousin in entry.cousins] == list(range(1, len(entry.cousins) + 1))
        assert entry.by_distance == sorted(entry.by_distance, key=lambda candidate: candidate.distance)
        assert {candidate.asset for candidate in entry.by_votes} <= {candidate.asset for candidate in entry.by_distance}
        assert len(best.orientations) == 4 and best.orientations[0] == best.orientation
    assert all(cousin.category == "cabinet" for cousin in result.objects[0].cousins)


def test_models_are_compared_by_representatives_if_asked(world: World, tmp_path: Path) -> None:
    """The paper's way; distances are then those to the last view, which no orientation has."""
    result = world.match(tmp_path / "cousins.json", views=0)
    first = result.objects[0]
    assert {candidate.asset for candidate in first.by_distance} == {"cabinet_00", "cabinet_02", "cabinet_03"}
    assert all(cousin.distance != cousin.orientation.distance for cousin in first.cousins)


def test_one_bad_object_does_not_stop_the_scene(world: World, tmp_path: Path) -> None:
    result = world.match(tmp_path / "cousins.json", picture=True)
    lost, unseen = result.objects[4:]
    assert (lost.status, lost.reason) == ("failed", "extraction: no points")
    assert unseen.status == "failed" and "mask 99 has no pixel" in unseen.reason
    assert (tmp_path / "cousins.png").stat().st_size > 10_000


def test_backends_pick_the_same_and_a_second_run_writes_the_same_bytes(world: World, tmp_path: Path) -> None:
    first, second, other = (
        world.match(tmp_path / f"{name}.json", search=search)
        for name, search in (("a", "torch"), ("b", "torch"), ("c", "faiss"))
    )
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    for ours, theirs in zip(first.objects, other.objects, strict=True):
        for picks in ("by_votes", "by_distance", "cousins"):
            a, b = getattr(ours, picks), getattr(theirs, picks)
            assert [(pick.asset, pick.votes) for pick in a] == [(pick.asset, pick.votes) for pick in b]
            assert [pick.distance for pick in a] == pytest.approx([pick.distance for pick in b], abs=2e-4)
        yaws = [[cousin.orientation.yaw for cousin in entry.cousins] for entry in (ours, theirs)]
        assert yaws[0] == yaws[1]
    assert second.objects == first.objects


def test_search_without_depth(world: World, tmp_path: Path) -> None:
    depth = world.objects.parent / "depth.npz"
    kept = depth.read_bytes()
    depth.unlink()
    try:
        result = world.match(tmp_path / "cousins.json")
    finally:
        depth.write_bytes(kept)
    assert [entry.cousins[0].asset for entry in result.objects[:2]] == ["cabinet_00", "cabinet_01"]


def test_unusable_input_is_refused_in_one_line_and_leaves_nothing(world: World, tmp_path: Path) -> None:
    out = tmp_path / "cousins.json"
    with pytest.raises(InputError, match="was made by hog with other settings"):
        world.match(out, hog={"grid": 12})
    with pytest.raises(InputError, match="4 of 8 assets have no features"):
        match(
            objects=world.objects,
            image=world.objects.parent / "rgb.png",
            library=world.library,
            features=world.features[:1],
            out=out,
        )
    broken = tmp_path / "shard.npy"
    broken.write_bytes(b"no array")
    broken.with_suffix(".json").write_text(world.features[0].with_suffix(".json").read_text())
    with pytest.raises(InputError, match="cannot be read"):
        match(objects=world.objects, image=world.library, library=world.library, features=[broken], out=out)
    with pytest.raises(InputError, match="is no readable image"):
        match(objects=world.objects, image=world.library, library=world.library, features=world.features, out=out)
    (tmp_path / "shard.h5").write_bytes(b"no hdf5")
    (tmp_path / "shard.json").write_text(world.snapshots[0].with_suffix(".json").read_text())
    with pytest.raises(InputError, match="is no readable snapshot file"):
        features(snapshots=tmp_path / "shard.h5", out=tmp_path / "f.npy")
    assert not out.exists() and not (tmp_path / "f.npy").exists()


def write_asset(world: World, name: str, doors: list[tuple[str, float, float, str]], origin: str = "0 0 0") -> Path:
    """An asset folder whose doors are boxes: (handle or '', width, height of the centre, axis)."""
    folder = world.folder / "models" / name
    folder.mkdir(parents=True, exist_ok=True)
    links, joints = '<link name="base"/>', []
    for number, (handle, width, height, axis) in enumerate(doors):
        panel = f'<geometry><mesh filename="panel.obj" scale="1 {width} 1"/></geometry>'
        links += f'<link name="l{number}"><visual><origin xyz="0 0 0.1"/>{panel}</visual></link>'
        links += f'<joint name="j{number}" type="revolute"><parent link="base"/><child link="l{number}"/>'
        links += f'<origin xyz="0.2 0 {height - 0.1}" rpy="{origin}"/><axis xyz="{axis}"/></joint>'
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
        PlacedObject(id="cabinet_1", label="cabinet", asset="cabinet_00", size=(0.5, 0.8, 0.9)),
        PlacedObject(id="bowl_4", label="bowl", asset="bowl_01", size=(0.2, 0.2, 0.2)),
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
    return {
        "cousins": cousins,
        "scene_file": scene,
        "library": world.library,
        "features": world.features,
        "task": "door",
    }


def test_select_ranks_cousins_by_distance_to_the_twin(world: World, experiment: dict[str, Any], tmp_path: Path) -> None:
    select(**experiment, object="cabinet_1", count=3, out=tmp_path / "task.json")
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
    experiment: dict[str, Any], tmp_path: Path, object: str, count: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        select(**experiment, object=object, count=count, out=tmp_path / "task.json")
    assert not (tmp_path / "task.json").exists()
