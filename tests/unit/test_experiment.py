"""`matching distances` and `experiment select`: which assets a policy experiment trains and tests on."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.stages.articulated.affordance import target_joint
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import (
    Asset,
    GeneratedScene,
    InputError,
    Objects,
    TaskAssets,
    Truth,
    read_json,
    write_json,
)
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.cousins import Distances
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.library import FrontPanel, Joint
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.experiment.select import choose_cousins, choose_dissimilar
from roomkin.stages.experiment.select import run as select
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.matching.distances import measure_distances
from roomkin.stages.matching.distances import run as distances
from roomkin.stages.matching.encoders import column_weights, make_encoder, settings_digest
from roomkin.stages.matching.store import FeatureStore
from tests.refusals import refused
from tests.unit.demo_assets import an_asset
from tests.unit.matching_data import MODELS, World


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("experiment"))


Door = tuple[str | None, float, float, str]  # handle, width, height of the center, hinge


def write_asset(world: World, name: str, doors: list[Door], tall: float = 0.4, role: str = "door") -> Path:
    """An asset folder with the fronts, which are boxes with boxes as handles: 10 cm long, 10 cm above the middle."""
    folder = world.folder / "models" / name
    folder.mkdir(parents=True, exist_ok=True)
    box = '<visual><origin xyz="{}"/><geometry><box size="{}"/></geometry></visual>'
    kind = 'revolute" name="j{0}"><axis xyz="0 0 1"/><limit lower="0" upper="1.57"/>'
    link = '<link name="l{0}">{1}</link><joint type="' + kind + '<parent link="base"/><child link="l{0}"/></joint>'
    fronts = [
        box.format(f"0.2 0 {height}", f"0.02 {width} {tall}") + box.format(f"0.23 0 {height + 0.1}", "0.04 0.02 0.1")
        for _, width, height, _ in doors
    ]
    links = "".join(link.format(number, front) for number, front in enumerate(fronts))
    body = box.format("0 0 0.5", "0.36 0.8 1")
    (folder / "model.urdf").write_text(f'<robot name="{name}"><link name="base">{body}</link>{links}</robot>')
    joints = [
        Joint(
            name=f"j{number}",
            type="revolute" if role == "door" else "prismatic",
            part_type=role,
            parent="base",
            link=f"l{number}",
            axis=(0, 0, 1),
            lower=0,
            upper=1.57,
            handle_link=f"l{number}" if handle else None,
            handle=handle,
            panel=FrontPanel(hinge=hinge, height=height, size=(width, tall)),
        )
        for number, (handle, width, height, hinge) in enumerate(doors)
    ]
    asset = Asset(
        id=name,
        category=MODELS[name][0],
        box_min=(-0.2, -0.4, 0),
        box_max=(0.2, 0.4, 1.0),
        mass=1,
        joints=joints,
        doors=len(doors) if role == "door" else 0,
        drawers=len(doors) if role == "drawer" else 0,
        licence="CC0-1.0",
        provenance="test",
        checksum=f"digest of {name}",
    )
    write_json(folder / "asset.json", asset)
    return folder


def test_target_joint_is_the_largest_reachable_one(world: World) -> None:
    def chosen(*doors: Door) -> str | None:
        found = target_joint(write_asset(world, "cabinet_00", list(doors)), "door")
        return found.joint if found else None

    assert chosen(("bar", 0.3, 0.5, "left"), ("bar", 0.6, 0.5, "left")) == "j1"  # larger
    assert chosen(("bar", 0.3, 0.5, "left"), (None, 0.6, 0.5, "left")) == "j0"  # has a handle
    assert chosen(("bar", 0.4, 0.9, "left"), ("bar", 0.4, 0.6, "left")) == "j1"  # as large, nearer to mid-height
    assert chosen(("bar", 0.4, 0.5, "left"), ("bar", 0.4, 0.5, "right")) == "j0"  # the first by name
    assert chosen(("bar", 0.6, 0.5, "bottom"), ("bar", 0.3, 0.5, "left")) == "j1"  # a flap is no door
    assert chosen(("bar", 0.6, 0.5, "bottom")) is None and chosen((None, 0.6, 0.5, "left")) is None
    assert target_joint(world.folder / "models" / "cabinet_00", "drawer") is None


def test_a_cousin_is_opened_at_the_joint_most_like_the_twins(world: World) -> None:
    twin = target_joint(write_asset(world, "cabinet_00", [("bar", 0.4, 0.5, "right")]), "door")
    assert twin is not None

    def chosen(*doors: Door, tall: float = 0.4) -> str:
        found = target_joint(write_asset(world, "cabinet_00", list(doors), tall), "door", twin)
        assert found is not None
        return found.joint

    assert chosen(("bar", 0.4, 0.5, "left"), ("knob", 0.1, 0.1, "right")) == "j1"  # the hinge side before all else
    assert chosen(("knob", 0.4, 0.5, "right"), ("bar", 0.3, 0.5, "right")) == "j1"  # then the handle
    assert chosen(("bar", 0.4, 0.8, "right"), ("bar", 0.4, 0.4, "right")) == "j1"  # then height and extents
    assert chosen(("bar", 0.9, 0.5, "right"), ("bar", 0.45, 0.5, "right")) == "j1"
    drawers = write_asset(world, "cabinet_00", [("bar", 0.4, 0.2, "slide"), ("bar", 0.4, 0.6, "slide")], role="drawer")
    low = target_joint(drawers, "drawer", twin._replace(hinge="slide", height=0.1))
    high = target_joint(drawers, "drawer", twin._replace(hinge="slide", height=0.7))
    assert low is not None and high is not None and (low.joint, high.joint) == ("j0", "j1")


@pytest.fixture(scope="module")
def experiment(world: World) -> dict[str, Any]:
    """A scene with matched cousins, some of whose assets have doors."""
    for name, (_, _, _, doors, drawers) in MODELS.items():
        write_asset(world, name, [("bar", 0.4, 0.5, "left")] if doors + drawers else [])
    pack(world.folder / "models", world.folder / "models.zip")
    cousins = world.folder / "cousins.json"
    world.match(cousins, count_threshold=None)
    scene = world.folder / "scene_1.json"
    placed = [
        PlacedObject(id="cabinet_1", label="cabinet", asset="cabinet_00", category="cabinet", size=(0.5, 0.8, 0.9)),
        PlacedObject(id="bowl_4", label="bowl", asset="bowl_01", category="bowl", size=(0.2, 0.2, 0.2)),
    ]
    generated = GeneratedScene(
        scene="test",
        variant="default",
        rank=1,
        width=8,
        height=8,
        intrinsics=[[8.0, 0.0, 3.5], [0.0, 8.0, 3.5], [0.0, 0.0, 1.0]],
        floor_from_camera=make_transform(np.eye(3), [0.0, 0.0, 1.5]).tolist(),
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
    among = measure_distances("cabinet_00", some, store, column_weights(encoder, True), options)
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
    assert (twin.handle, twin.hinge) == ("bar", "left")
    assert twin.panel_height == pytest.approx(0.5 * 0.9) and twin.panel_size == pytest.approx((0.4, 0.36))
    assert twin.handle_length == pytest.approx(0.1 * 0.9) and twin.handle_height == pytest.approx(0.5 + 0.1 / 0.4)
    assert (twin.family, twin.digest) == ("cabinet_00", "digest of cabinet_00")


def test_all_assets_leave_out_what_is_held_out_and_dissimilar(
    world: World, experiment: dict[str, Any], tmp_path: Path
) -> None:
    files = experiment | {"distances": alike(world, experiment, "cabinet_1")}
    select(**files, object="cabinet_1", count=3, held_out=(2,), out=tmp_path / "task.json")
    result = read_json(TaskAssets, tmp_path / "task.json")
    roles = {asset.role: asset.asset for asset in result.assets}
    everything = [asset.asset for asset in result.all_assets]
    assert everything[0] == roles["twin"] and {roles["cousin_1"], roles["cousin_3"]} <= set(everything)
    assert not {roles["cousin_2"], roles["dissimilar"]} & set(everything)
    assert [asset.distance for asset in result.all_assets] == sorted(asset.distance for asset in result.all_assets)
    broken = result.model_copy(update={"all_assets": [result.assets[-1]]}).model_dump()
    with pytest.raises(ValueError, match=r"its family 'cabinet_\d+' is in training and in the held-out and dissimilar"):
        TaskAssets.model_validate(broken)


def truth_of(world: World, folder: Path, **assets: str) -> dict[str, Path]:
    """The flags of a truth that names the models of objects of the scene."""
    masks = {item.id: item.mask for item in read_json(Objects, world.objects).objects}
    true = [
        TrueObject(
            mask=masks[id], asset=asset, category="cabinet", position=(0, 0, 0), yaw=0, size=(1, 1, 1), symmetry="none",
            support="floor",
        )
        for id, asset in assets.items()
    ]  # fmt: skip
    write_json(folder / "truth.json", Truth(scene="test", scale=1, world_from_camera=np.eye(4).tolist(), objects=true))
    return {"truth": folder / "truth.json", "objects": world.objects}


def test_the_twin_is_the_true_model_and_what_matching_chose_is_a_role_of_its_own(
    world: World, experiment: dict[str, Any], tmp_path: Path
) -> None:
    known = truth_of(world, tmp_path, cabinet_1="cabinet_03")
    files = experiment | {"object": "cabinet_1", "count": 2, "out": tmp_path / "task.json"}
    features = {"cousins": experiment["cousins"], "library": world.library, "features": world.features}
    distances(**features, **known, object="cabinet_1", out=tmp_path / "d.json")
    select(**files, **known, distances=tmp_path / "d.json")
    result = read_json(TaskAssets, tmp_path / "task.json")
    assert [asset.role for asset in result.assets] == ["twin", "matched", "cousin_1", "cousin_2", "dissimilar"]
    assert [asset.asset for asset in result.assets[:2]] == ["cabinet_03", "cabinet_00"]
    assert result.assets[0].distance == 0 < result.assets[1].distance
    known = truth_of(world, tmp_path, cabinet_1="cabinet_00")
    select(**files | {"count": 3}, **known, distances=tmp_path / "d.json")
    assert "matched" not in {asset.role for asset in read_json(TaskAssets, tmp_path / "task.json").assets}


def test_a_true_model_that_will_not_do_is_refused(world: World, experiment: dict[str, Any], tmp_path: Path) -> None:
    files = experiment | {"object": "cabinet_1", "count": 2, "out": tmp_path / "task.json"}
    files |= {"distances": alike(world, experiment, "cabinet_1")}
    known = truth_of(world, tmp_path, cabinet_1="shelf_00")
    with pytest.raises(
        InputError, match=r"'cabinet_1' is truly shelf_00, which has no door to open.*would do.*cabinet"
    ):
        select(**files, **known)
    with pytest.raises(InputError, match="one is given without the other"):
        select(**files, truth=known["truth"])
    truth = read_json(Truth, known["truth"]).model_copy(update={"scene": "attic"})
    write_json(known["truth"], truth)
    with pytest.raises(InputError, match=r"is of attic, but .*objects\.json of test"):
        select(**files, **known)


def test_the_dissimilar_asset_differs_in_shape_and_not_in_its_handle_or_hinge() -> None:
    others = [
        an_asset("near", 1.0),
        an_asset("far", 2.0, handle="arch"),
        an_asset("knob", 3.0, handle="knob"),
        an_asset("mirrored", 4.0, hinge="right"),
    ]

    def chosen(*known: TaskAsset) -> str | None:
        found = choose_dissimilar(others, known)
        return found.asset if found else None

    assert chosen(an_asset("twin")) == "near"
    assert chosen(an_asset("twin"), others[1]) == "far" and chosen(*others) == "mirrored"
    assert choose_dissimilar(others[2:], [an_asset("twin")]) is others[2], "at least the hinge side is known"
    assert choose_dissimilar([], others) is None


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
    with refused("E-DISTANCES-STALE", "is of 'cabinet_2' in test by hog, not of 'cabinet_1' in test"):
        select(**files, object="cabinet_1", count=3, out=tmp_path / "task.json")
    table = read_json(Distances, alike(world, experiment, "cabinet_1"))
    write_json(tmp_path / "d.json", table.model_copy(update={"distances": {}}))
    with refused("E-DISTANCES-STALE", "has no distances from cabinet_00, the twin"):
        select(**experiment | {"distances": tmp_path / "d.json"}, object="cabinet_1", count=3, out=tmp_path / "t.json")
    write_json(tmp_path / "d.json", table.model_copy(update={"encoder": "dinov2"}))
    with refused("E-DISTANCES-STALE", "is of 'cabinet_1' in test by dinov2"):
        select(**experiment | {"distances": tmp_path / "d.json"}, object="cabinet_1", count=3, out=tmp_path / "t.json")
    assert not (tmp_path / "task.json").exists()


POOL = [an_asset(name, distance) for distance, name in enumerate(("a_1", "a_2", "b_1", "c_1", "c_2", "d_1", "e_1"))]


def cousins_of(
    count: int, held_out: tuple[int, ...] = (), pool: list[TaskAsset] = POOL, first: list[TaskAsset] | None = None
) -> list[str]:
    pools = [pool] if first is None else [first, pool]
    return [asset.asset for asset in choose_cousins(pools, {"twin"}, count, held_out)]


def test_cousins_are_the_nearest_of_families_of_their_own() -> None:
    assert cousins_of(3) == ["a_1", "b_1", "c_1"] == cousins_of(3, pool=POOL[::-1])
    assert cousins_of(2, pool=[an_asset("twin_1"), *POOL[3:]]) == ["c_1", "d_1"], "none is the twin's sibling"
    assert cousins_of(2, first=POOL[4:]) == ["c_2", "d_1"], "candidates before what count_threshold held back"
    assert cousins_of(4, first=POOL[4:]) == ["a_1", "b_1", "c_1", "d_1"], "the candidates are too few"


def test_a_held_out_cousin_has_a_handle_that_training_shows_as_long_as_there_are_enough() -> None:
    knob = [an_asset("b_1", 2.0, handle="knob") if asset.asset == "b_1" else asset for asset in POOL]
    assert cousins_of(2, pool=knob) == ["a_1", "b_1"] and cousins_of(2, (2,), knob) == ["a_1", "c_1"]
    assert cousins_of(5, (2,), knob) == ["a_1", "b_1", "c_1", "d_1", "e_1"], "there is no other"


def test_where_families_are_too_few_those_in_training_are_relatives_and_held_out_ones_stay_alone() -> None:
    assert cousins_of(7) == [asset.asset for asset in POOL]
    assert cousins_of(6, (2,)) == ["a_1", "b_1", "c_1", "c_2", "d_1", "e_1"], "a_2 is trained on, so not held out"
    assert cousins_of(6, (1,)) == ["a_1", "b_1", "c_1", "c_2", "d_1", "e_1"], "a_2 is left out of training"
    assert len(cousins_of(7, (2,))) == 6, "too few: select refuses"
