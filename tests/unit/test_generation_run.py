"""The command `generate` on a cabinet with a mug on it: files, places, failures, physics, repeatability."""

import json
import re
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build as build_asset
from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.articulated.model import measure_closed_box
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.config.packages import load_command
from roomkin.stages.contracts import Asset, Cousins, GeneratedScene, InputError, Objects, read_json, write_json
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.cousins import Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.generated import EVEN, measure_place_sureness, measure_sureness
from roomkin.stages.contracts.library_folder import AssetFolders, write_part
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject, Wall
from roomkin.stages.generation.generate import run
from roomkin.stages.generation.inputs import Inputs, read_inputs
from roomkin.stages.generation.placed import Placed, read_collisions
from roomkin.stages.generation.placing import Places
from roomkin.stages.generation.scene_file import doubt_placement, read_items, summarise, to_contract
from roomkin.stages.generation.settling import describe_fall, find_behind, load_items, run_physics, simulate
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, corners
from roomkin.stages.geometry.frames import (
    intrinsics_from_fov,
    invert_transform,
    look_at,
    project,
    transform_points,
    yaw_matrix,
)
from roomkin.stages.geometry.masks import polygon
from roomkin.stages.simulation.loading import physics_scene
from tests.packages import needs
from tests.refusals import refused
from tests.unit.generation_scenes import build, thing
from tests.unit.physics import add_ground

WIDTH, HEIGHT = 160, 120
CABINET = ((3.0, 0.2, 0.4), (0.5, 0.9, 0.8))  # center and extents; its rear 5 cm from the wall x = 3.3
MUG = ((2.95, 0.3, 0.85), (0.1, 0.1, 0.1))


def _library(folder: Path) -> Path:
    for category in ("bottom_cabinet", "mug"):
        for index, number in enumerate((1, 3)):  # those that fit the cabinet
            name = f"{category}_{index}"
            build_asset(sample(category, number, 0), None, folder / "models" / name, name, category)
    write_part(folder / "library.json", folder / "models")
    return folder / "library.json"


def _object(name: str, mask: int, place: tuple, mounting: Mounting) -> SceneObject:
    box = Box(center=place[0], size=place[1], yaw=0.0)
    return SceneObject(id=name, label=name, mask=mask, box=box, mounting=mounting, points=3000, pixels=(1, 1, 9, 9))


def _cloud(place: tuple) -> np.ndarray:
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.5, 0.5, (3000, 3))
    points[:2000, 0] = -0.5  # the face towards the camera
    points[2000:, 2] = 0.5  # and the top
    return (points * place[1] + place[0]).astype(np.float32)


def _cousins(name: str, assets: list[str], psi: float = 0.0) -> ObjectCousins:
    view = Orientation(yaw=psi, distance=0.0)
    found = [
        Cousin(
            rank=k + 1, asset=a, category=a[:-2], distance=float(k), votes=None, orientation=view, orientations=[view]
        )
        for k, a in enumerate(assets)
    ]
    return ObjectCousins(id=name, label=name, cousins=found)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Files of a scene: cabinet_1 at a wall, mug_1 on it, lamp_1 that extraction lost, vase_1 without cousins."""
    folder = tmp_path_factory.mktemp("scene")
    library = _library(folder / "library")
    objects = Objects(
        scene="room_t",
        width=WIDTH,
        height=HEIGHT,
        intrinsics=intrinsics_from_fov(WIDTH, HEIGHT, 0.9).tolist(),
        floor_from_camera=look_at([0, 0, 1.5], [3, 0, 0.5]).tolist(),
        walls=[Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.3, points=99)],
        objects=[
            _object("cabinet_1", 1, CABINET, Mounting(type=3, walls=["wall_1"])),
            _object("mug_1", 2, MUG, Mounting(type=2)),
            SceneObject(id="lamp_1", label="lamp", mask=3, status="failed", reason="too small"),
            _object("vase_1", 4, ((1, 1, 0.1), (0.1, 0.1, 0.2)), Mounting(type=2)),
        ],
    )
    write_json(folder / "objects.json", objects)
    np.savez(
        folder / "clouds.npz",
        cabinet_1=_cloud(CABINET),
        mug_1=_cloud(MUG),
        vase_1=_cloud(((1, 1, 0.1), (0.1, 0.1, 0.2))),
    )
    cousins = Cousins(
        scene="room_t",
        encoder="test",
        objects=[
            _cousins("cabinet_1", ["bottom_cabinet_0", "bottom_cabinet_1"], psi=0.1),
            _cousins("mug_1", ["mug_0"]),
            ObjectCousins(id="vase_1", label="vase", status="failed", reason="nothing like it"),
        ],
    )
    write_json(folder / "cousins.json", cousins)
    Image.new("RGB", (WIDTH, HEIGHT), (9, 9, 9)).save(folder / "rgb.png")
    masks = np.zeros((HEIGHT, WIDTH), np.uint16)
    for value, (center, size) in ((1, CABINET), (2, MUG)):
        seen = transform_points(
            invert_transform(np.array(objects.floor_from_camera)), corners(UprightBox(center, size, 0.0))
        )
        outline = cv2.convexHull(project(seen, objects.intrinsics).astype(np.float32))[:, 0]
        masks[polygon(outline, masks.shape)] = value
    Image.fromarray(masks).save(folder / "masks.png")
    return {
        "cousins": folder / "cousins.json",
        "objects": folder / "objects.json",
        "library": library,
    }


@pytest.fixture(scope="module")
def made(scene: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out")
    return make(scene, out, 2)


def make(scene: dict[str, Path], out: Path, ranks: int) -> Path:
    """Scenes of so many ranks."""
    run(**scene, variant="v", out=out, options=json.dumps({"ranks": ranks, "sizes": "measured"}))
    return out


@pytest.fixture(scope="module")
def drawn(scene: dict[str, Path], made: Path) -> Path:
    return draw(scene, made)


def draw(scene: dict[str, Path], out: Path) -> Path:
    """The pictures of scenes, beside them."""
    image = scene["objects"].parent / "rgb.png"
    scenes = tuple(sorted(out.glob("scene_*.json")))
    files = {"scenes": scenes, "objects": scene["objects"], "image": image, "library": scene["library"]}
    load_command("pictures", "scenes")(**files, out=out, width=128)
    return out


def test_every_file_of_every_rank(made: Path) -> None:
    for rank in (1, 2):
        assert read_json(GeneratedScene, made / f"scene_{rank}.json").rank == rank


@needs("pictures")
def test_every_picture_of_every_rank(drawn: Path) -> None:
    for rank in (1, 2):
        picture = np.asarray(Image.open(drawn / f"scene_{rank}.png"))
        assert picture.shape == (96, 128, 3)
        assert picture.std() > 5
    assert Image.open(drawn / "comparison.png").width > 3 * 128
    assert Image.open(drawn / "thumbnail.webp").size == (2 * 144, 108)


@needs("pictures")
def test_pictures_hold_what_their_scenes_were_made_of(drawn: Path) -> None:
    made = drawn
    both = Image.open(made / "comparison.png").text
    assert set(both) == {"code", "scene_1.json", "scene_2.json"}
    for name in ("scene_1", "scene_2"):
        scene, one = read_json(GeneratedScene, made / f"{name}.json"), Image.open(made / f"{name}.png").text
        assert scene.made and json.loads(both[f"{name}.json"]) == scene.made.model_dump()
        assert one == {"code": both["code"], f"{name}.json": both[f"{name}.json"]}


def test_the_cabinet_stands_at_the_wall_and_the_mug_on_it(made: Path, scene: dict[str, Path]) -> None:
    cabinet, mug = read_json(GeneratedScene, made / "scene_1.json").objects[:2]
    assert cabinet.asset == "bottom_cabinet_0"
    assert abs(cabinet.yaw) == pytest.approx(np.pi, abs=1e-3)  # looks back at the camera, square to the wall
    assert cabinet.position[0] + cabinet.size[0] / 2 == pytest.approx(3.3, abs=1e-5)
    assert cabinet.position[0] - cabinet.size[0] / 2 == pytest.approx(2.75, abs=0.01)
    assert cabinet.size[1:] == pytest.approx((0.9, 0.8), abs=0.015)
    assert mug.support == "cabinet_1"
    assert mug.position[2] - mug.size[2] / 2 == pytest.approx(0.8, abs=1e-5)


def _inputs(objects: Objects, scene: dict[str, Path], folder: Path) -> Inputs:
    """What generation reads, with other objects."""
    write_json(folder / "objects.json", objects)
    for name in ("clouds.npz", "masks.png"):
        (folder / name).write_bytes(scene["objects"].with_name(name).read_bytes())
    return read_inputs(scene["cousins"], folder / "objects.json", scene["library"])


def test_a_front_that_was_told_counts_for_more_than_the_matched_view(scene: dict[str, Path], tmp_path: Path) -> None:
    objects = read_json(Objects, scene["objects"])
    objects.objects[0].front = 1.62  # to the side, though the matched view and the wall say otherwise
    inputs = _inputs(objects, scene, tmp_path)
    cabinet = build(inputs, 1, GenerationConfig()).items[0]
    assert cabinet.id == "cabinet_1" and cabinet.box.yaw == pytest.approx(np.pi / 2, abs=1e-6)


@pytest.mark.parametrize(("x", "ends"), [(3.1, 3.25), (3.3, 3.3)])  # a hand from the wall x = 3.3; reaching into it
def test_a_box_that_was_told_holds_but_for_the_wall(
    scene: dict[str, Path], tmp_path: Path, x: float, ends: float
) -> None:
    """30 cm deep, though such cabinets are twice as deep: only the wall may take some of it."""
    objects = read_json(Objects, scene["objects"])
    told = Box(center=(x, 0.2, 0.4), size=(0.3, 0.9, 0.8), yaw=0.0)
    cabinet = objects.objects[0].model_copy(update={"front": float(np.pi), "box": told, "whole": True})
    objects.objects[0] = cabinet
    inputs = _inputs(objects, scene, tmp_path)
    placed = build(inputs, 1, GenerationConfig()).items[0]
    assert placed.center[0] + placed.size[0] / 2 == pytest.approx(ends, abs=1e-6)
    assert placed.center[0] - placed.size[0] / 2 == pytest.approx(x - 0.15, abs=1e-6)
    assert placed.size[1:] == pytest.approx((0.9, 0.8)) and placed.center[1] == pytest.approx(0.2)


def test_every_object_has_a_place_of_its_own_clear_of_walls_and_of_some_extent(scene: dict[str, Path]) -> None:
    inputs = read_inputs(scene["cousins"], scene["objects"], scene["library"])
    places = Places(inputs, GenerationConfig(sizes="measured"))
    mug = next(one for one in inputs.matched if one.object.id == "mug_1")

    def stand(name: str, cloud: np.ndarray = mug.cloud, **about: object) -> Placed:
        one = replace(mug, object=mug.object.model_copy(update={"id": name} | about), cloud=cloud)
        return places.find(one, mug.cousins[0])

    first, at_wall = stand("mug_1"), Box(center=(3.28, 0.2, 0.9), size=(0.1, 0.2, 0.1), yaw=0.0)
    assert stand("mug_1") is first
    moved = stand("mug_2", box=at_wall, whole=True)  # of the same label, reaching 3 cm into the wall
    assert moved.center[1] == pytest.approx(0.2) and moved.center[0] + moved.size[0] / 2 == pytest.approx(3.3, abs=1e-6)
    free = stand("mug_3", mounting=Mounting(type=2, walls=["wall_1"]))  # it touches a wall, and does not lean on it
    assert free.center == pytest.approx(first.center) and free.size == pytest.approx(first.size)
    flat = stand("mug_4", cloud=mug.cloud * [0, 1, 1])
    assert flat.size.min() == THINNEST


def test_an_object_with_fewer_cousins_uses_its_last(made: Path) -> None:
    cabinet, mug = read_json(GeneratedScene, made / "scene_2.json").objects[:2]
    assert (cabinet.asset, mug.asset) == ("bottom_cabinet_1", "mug_0")


def test_failed_objects_are_carried_with_their_reason(made: Path) -> None:
    lamp, vase = read_json(GeneratedScene, made / "scene_1.json").objects[2:]
    assert (lamp.status, lamp.reason) == ("failed", "extraction: too small")
    assert (vase.status, vase.reason) == ("failed", "matching: nothing like it")


def test_the_scene_is_stable(made: Path) -> None:
    scene = read_json(GeneratedScene, made / "scene_1.json")
    assert scene.plausibility is not None
    assert scene.plausibility.stable
    assert scene.plausibility.max_penetration < 0.005
    assert scene.objects[1].settled_shift is not None
    assert scene.objects[1].settled_shift < 0.01


@needs("pictures")
def test_the_export_has_the_same_places(drawn: Path) -> None:
    made = drawn
    cabinet = read_json(GeneratedScene, made / "scene_1.json").objects[0]
    scene = trimesh.load_scene(made / "scene_1.glb")
    assert {"floor", "wall_1"} <= set(scene.geometry)
    scene.delete_geometry(["floor", "wall_1"])
    low, high = scene.bounds
    assert high[0] == pytest.approx(3.3, abs=1e-3)  # the wall
    assert low[1] == pytest.approx(0.0, abs=1e-3)  # glTF's up axis is y
    assert -high[2] == pytest.approx(cabinet.position[1] - cabinet.size[1] / 2, abs=1e-3)
    assert (made / "scene_1.glb").stat().st_size < 10e6


def test_same_input_same_bytes(scene: dict[str, Path], made: Path, tmp_path: Path) -> None:
    make(scene, tmp_path, 2)
    assert (tmp_path / "scene_1.json").read_bytes() == (made / "scene_1.json").read_bytes()


@needs("pictures")
def test_same_scene_same_pictures(scene: dict[str, Path], drawn: Path, tmp_path: Path) -> None:
    draw(scene, make(scene, tmp_path, 2))
    for name in ("scene_1.png", "scene_1.glb"):
        assert (tmp_path / name).read_bytes() == (drawn / name).read_bytes(), name


def test_collision_and_visual_meshes_fill_the_closed_box(scene: dict[str, Path]) -> None:
    folder = AssetFolders(scene["library"])["bottom_cabinet_0"]
    asset = read_json(Asset, folder / "asset.json")
    bounds = measure_closed_box(read_model(folder))
    assert bounds == pytest.approx(np.array([asset.box_min, asset.box_max]), abs=1e-3)
    assert trimesh.util.concatenate(read_collisions(folder)).extents == pytest.approx(asset.size, abs=0.05)


def test_what_floats_falls_unless_it_hangs_on_a_wall(scene: dict[str, Path], tmp_path: Path) -> None:
    options = GenerationConfig(sizes="measured")
    built = build(read_inputs(scene["cousins"], scene["objects"], scene["library"]), 1, options)
    raised = {"cabinet_1": 0.1, "mug_1": 0.3}  # the cabinet falls 10 cm and the mug, that stood 20 cm above it, 30 cm
    floating = [item.shift([0, 0, raised[item.id]]) for item in built.items]
    hung = [replace(item, mounting=Mounting(type=1)) if item.id == "cabinet_1" else item for item in floating]
    for items, fallen in ((floating, {"cabinet_1": 0.1, "mug_1": 0.3}), (hung, {"mug_1": 0.2})):
        physics = physics_scene()
        add_ground(physics)
        settled = run_physics(physics, load_items(physics, items), items, 0, options)
        assert settled.plausibility.fallen == sorted(fallen)
        assert not settled.plausibility.stable
        drops = {name: f"dropped {100 * height:.0f} cm" for name, height in fallen.items()}
        assert settled.plausibility.how == drops and "mug_1 dropped" in settled.plausibility.wrong
        assert {name: settled.shifts[name] for name in fallen} == pytest.approx(fallen, abs=0.02)


def test_what_stands_on_something_unnamed_is_held_and_said(scene: dict[str, Path], tmp_path: Path) -> None:
    """A mug a metre above the cabinet: on a shelf that nobody named."""
    inputs, options = read_inputs(scene["cousins"], scene["objects"], scene["library"]), GenerationConfig()
    mug = inputs.objects.objects[1]
    assert mug.id == "mug_1" and mug.box is not None
    x, y, z = mug.box.center
    raised = mug.model_copy(update={"box": mug.box.model_copy(update={"center": (x, y, z + 1)})})
    inputs.objects.objects[1] = raised
    cloud = inputs.matched[1].cloud + np.array([0, 0, 1], dtype=np.float32)
    inputs.matched[1] = replace(inputs.matched[1], object=raised, cloud=cloud)
    built = build(inputs, 1, options)
    made = to_contract(
        built.items, built.failed, simulate(built.items, inputs.objects, 0, options), inputs.objects, "b", 1
    )
    held = next(item for item in made.objects if item.id == "mug_1")
    assert held.support == "unnamed" and held.position[2] == pytest.approx(z + 1, abs=0.03)
    assert made.plausibility is not None and not made.plausibility.stable and held.settled_shift == 0
    first, *others = summarise(made, [])
    assert re.fullmatch(r"\S+ rank 1: 2 placed; 2 failed; stands; penetration \d\.\d mm", first)
    assert others == [f"{made.scene} rank 1: mug_1 is held where it was seen: nothing that was named carries it"]
    assert made.plausibility.wrong == "" and made.plausibility.verdict.startswith("stands; held, for nothing")


def test_what_overlaps_a_wall_is_pushed_and_not_said_to_have_dropped(scene: dict[str, Path]) -> None:
    options = GenerationConfig(sizes="measured")
    inputs = read_inputs(scene["cousins"], scene["objects"], scene["library"])
    cabinet = next(item for item in build(inputs, 1, options).items if item.id == "cabinet_1")
    far = max(corners(cabinet.box)[:, 0])
    wall = Wall(id="wall_1", normal=(-1.0, 0.0, 0.0), offset=-far + 0.08, points=9)
    room = inputs.objects.model_copy(update={"walls": [wall]})
    check = simulate([cabinet], room, 0, options).plausibility
    assert check is not None and check.behind == ["cabinet_1"]
    assert check.how == {"cabinet_1": "was pushed 8 cm, for it overlapped wall_1"}
    assert check.verdict == "does not stand: cabinet_1 was pushed 8 cm, for it overlapped wall_1; " + check.kept


def test_what_stays_inside_a_wall_is_not_stable(scene: dict[str, Path]) -> None:
    options = GenerationConfig(sizes="measured")
    built = build(read_inputs(scene["cousins"], scene["objects"], scene["library"]), 1, options)
    physics = physics_scene()  # without the wall: nothing pushes the cabinet out
    add_ground(physics)
    wall = Wall(id="wall_1", normal=(-1.0, 0.0, 0.0), offset=-float(built.items[0].center[0]), points=9)
    bodies = load_items(physics, built.items)
    check = run_physics(physics, bodies, built.items, 0, options, [wall]).plausibility
    assert (check.fallen, check.held, check.stable) == ([], [], False) and "cabinet_1" in check.behind


def test_a_fall_is_said_by_what_it_is() -> None:
    options = GenerationConfig()
    assert describe_fall(np.array([0.2, 0.0, -0.1]), 80.0, "", options) == "tipped by 80°"
    assert describe_fall(np.array([0.02, 0.0, -0.1]), 2.0, "", options) == "dropped 10 cm"
    assert describe_fall(np.array([0.06, 0.0, -0.01]), 0.0, "", options) == "slid 6 cm"
    pushed = describe_fall(np.array([0.06, 0.0, -0.01]), 0.0, "table_1", options)
    assert pushed == "was pushed 6 cm, for it overlapped table_1"


def test_the_story_of_a_place_is_told(made: Path) -> None:
    cabinet, mug = read_json(GeneratedScene, made / "scene_1.json").objects[:2]
    assert cabinet.cousin == 1 and cabinet.doubts == []
    assert cabinet.steps[1] == "rear to wall_1: 0.550 x 0.891 x 0.800 m, moved 2.7 cm"
    assert mug.steps == ["measured along the model's axes: turned +180.0°, 0.099 x 0.099 x 0.100 m"]


def whats(item: Placed, walls: list[Wall], seen: SceneObject) -> list[str]:
    """Its doubts in words."""
    return [doubt.what for doubt in doubt_placement(item, walls, seen, known_categories()).doubts]


def test_what_is_too_large_or_behind_a_wall_is_doubted() -> None:
    back = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)  # seen from x < 4
    mirror = thing("mirror", (4.2, 0, 1.5), (0.6, 2.2, 2.65))
    seen = SceneObject(id="mirror_1", label="mirror", mask=1)
    assert whats(mirror, [back], seen) == [
        "reaches 50 cm behind wall_1",
        "is 220 wide × 60 deep × 265 cm high; usual are 35 to 63 wide × 3 to 4 deep × 77 to 128 cm high",
    ]
    assert whats(thing("mirror", (3.9, 0, 1.5), (0.04, 0.6, 0.9)), [back], seen) == []
    sized = seen.model_copy(update={"told": ["size"]})
    assert whats(mirror, [back], sized) == ["reaches 50 cm behind wall_1"]  # a person says how large it is
    assert len(whats(thing("gizmo", (0, 0, 1.5), (9, 9, 9), support="unnamed"), [], seen)) == 1
    fridge = SceneObject(id="fridge_1", label="fridge", mask=1)  # of a photograph whose camera is taken too high
    assert "× 243 cm high" in whats(thing("fridge", (2, 0, 1.2), (0.8, 0.9, 2.43)), [], fridge)[0]
    assert whats(thing("fridge", (2, 0, 0.9), (0.7, 0.9, 1.9)), [], fridge) == []


def test_a_size_that_the_fit_is_not_sure_of_is_doubted() -> None:
    fridge, seen = thing("fridge", (2, 0, 0.9), (0.7, 0.9, 1.8)), SceneObject(id="fridge_1", label="fridge", mask=1)
    assert whats(replace(fridge, spread=(0.04, 0.03, 0.01)), [], seen) == []
    unsure = replace(fridge, spread=(0.3, 0.03, 0.01))
    assert whats(unsure, [], seen) == [
        "its size is right within 10 % or 3 cm with a chance of 25 % (width ±3 %, depth ±35 %, height ±1 %)"
    ]
    assert whats(unsure, [], seen.model_copy(update={"told": ["size"]})) == [], "a person says so"


def test_a_place_that_the_fit_is_not_sure_of_is_doubted_until_a_person_moves_it() -> None:
    fridge, seen = thing("fridge", (2, 0, 0.9), (0.7, 0.9, 1.8)), SceneObject(id="fridge_1", label="fridge", mask=1)
    sure, unsure = (replace(fridge, place_spread=each) for each in (0.02, 0.084))
    assert whats(sure, [], seen) == []
    assert whats(unsure, [], seen) == ["its place is right to 5 cm with a chance of 16 %"]
    assert doubt_placement(unsure, [], seen, {}, moved=True).doubts == ()


def test_a_place_is_as_likely_right_as_wrong_where_its_spread_is_even() -> None:
    assert measure_place_sureness(EVEN) == 0.5
    assert measure_place_sureness(EVEN / 2) == pytest.approx(1 - measure_place_sureness(2 * EVEN))
    assert measure_place_sureness(0.01) > 0.95


def test_sureness_is_the_chance_that_every_extent_is_right() -> None:
    rng, spread, size = np.random.default_rng(0), [0.2, 0.1, 0.05], [0.1, 0.5, 1.0]
    times = np.exp(np.abs(rng.normal(0, spread, (20000, 3))))
    assert measure_sureness(size, spread) == pytest.approx((times < [1.3, 1.1, 1.1]).all(axis=1).mean(), abs=0.01)


def test_a_wall_ends_before_what_is_seen_beyond_it() -> None:
    """A table in the next room: it is told where it is, and the scene is as stable as it is."""
    back = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)
    beyond, half = thing("gizmo", (7.0, 0, 0.4), (0.8, 1.2, 0.7)), thing("gizmo", (4.2, 0, 0.4), (0.8, 1.2, 0.7))
    seen = SceneObject(id="gizmo_1", label="gizmo", mask=1)
    assert whats(beyond, [back], seen) == [
        "is seen beyond wall_1: past its end or through an opening, else in a mirror"
    ]
    assert whats(half, [back], seen) == ["reaches 60 cm behind wall_1"]
    assert find_behind([beyond, half], [back]) == [half.id]


@pytest.mark.parametrize(("known", "doubted"), [(None, False), (0.9, False), (0.03, True)])
def test_the_place_of_what_has_hardly_any_depth_is_doubted(known: float | None, doubted: bool) -> None:
    seen = SceneObject(id="gizmo_1", label="gizmo", mask=1, depth_known=known)
    found = whats(thing("gizmo", (2, 0, 0.4), (0.8, 1.2, 0.7)), [], seen)
    assert found == (["depth is known on 3 % of its pixels: its place is not certain"] if doubted else [])


def test_scenes_say_how_far_fitted_places_may_be_off(scene: dict[str, Path], made: Path, tmp_path: Path) -> None:
    run(**scene, variant="v", out=tmp_path / "out", options='{"ranks": 1, "sizes": "fitted"}')
    for folder, fitted in ((tmp_path / "out", True), (made, False)):
        placed = [item for item in read_json(GeneratedScene, folder / "scene_1.json").objects if item.status == "ok"]
        assert placed and all(bool(item.place_spread) == fitted for item in placed)


def test_what_has_toppled_has_fallen_however_near_it_lies(scene: dict[str, Path], tmp_path: Path) -> None:
    options = GenerationConfig().model_copy(update={"fallen_distance": 9.0})  # only the tilt can tell
    built = build(read_inputs(scene["cousins"], scene["objects"], scene["library"]), 1, options)
    edge = built.items[0].center[0] - built.items[0].size[0] / 2 - 0.01  # its center 1 cm beyond
    items = [item.shift([edge - item.center[0], 0, 0]) if item.id == "mug_1" else item for item in built.items]
    physics = physics_scene()
    add_ground(physics)
    settled = run_physics(physics, load_items(physics, items), items, 0, options)
    assert settled.plausibility.fallen == ["mug_1"]


def test_an_overlap_is_seen_in_the_contacts(scene: dict[str, Path], tmp_path: Path) -> None:
    options = GenerationConfig(settle_seconds=1.0)  # by then physics has pushed them apart
    built = build(read_inputs(scene["cousins"], scene["objects"], scene["library"]), 1, options)
    items = [item.shift([0, 0, -0.02]) if item.id == "mug_1" else item for item in built.items]
    physics = physics_scene()
    settled = run_physics(physics, load_items(physics, items), items, 0, options)
    assert settled.plausibility.max_penetration == pytest.approx(0.02, abs=0.01)


def test_a_missing_asset_fails_that_object_alone(scene: dict[str, Path], tmp_path: Path) -> None:
    cousins = read_json(Cousins, scene["cousins"]).model_dump()
    cousins["objects"][1]["cousins"][0]["asset"] = "gone"
    write_json(tmp_path / "cousins.json", Cousins.model_validate(cousins))
    inputs = read_inputs(tmp_path / "cousins.json", scene["objects"], scene["library"])
    built = build(inputs, 1, GenerationConfig())
    assert [item.id for item in built.items] == ["cabinet_1"]
    assert "gone" in built.failed["mug_1"]


def test_a_scene_without_anything_that_stands_is_refused(scene: dict[str, Path], made: Path, tmp_path: Path) -> None:
    cousins = read_json(Cousins, scene["cousins"])
    lost = [ObjectCousins(id=item.id, label=item.label, status="failed", reason="none") for item in cousins.objects]
    write_json(tmp_path / "cousins.json", cousins.model_copy(update={"objects": lost}))
    with refused("E-SCENE-EMPTY"):
        run(**scene | {"cousins": tmp_path / "cousins.json"}, variant="v", out=tmp_path / "out", options='{"ranks": 1}')
    assert not list(tmp_path.glob("out/*"))
    empty = read_json(GeneratedScene, made / "scene_1.json").model_copy(update={"objects": []})
    with refused("E-SCENE-EMPTY"):
        read_items(empty, AssetFolders(scene["library"]), tmp_path, tmp_path)


def test_files_of_different_scenes_are_refused(scene: dict[str, Path], tmp_path: Path) -> None:
    other = json.loads(scene["cousins"].read_text()) | {"scene": "room_x"}
    (tmp_path / "cousins.json").write_text(json.dumps(other))
    with refused("E-SCENE-MIXED"):
        read_inputs(tmp_path / "cousins.json", scene["objects"], scene["library"])


def test_missing_clouds_are_named(scene: dict[str, Path], tmp_path: Path) -> None:
    (tmp_path / "objects.json").write_text(scene["objects"].read_text())
    with pytest.raises(InputError, match=r"clouds\.npz"):
        read_inputs(scene["cousins"], tmp_path / "objects.json", scene["library"])


def test_a_broken_archive_of_the_library_is_no_failed_object(scene: dict[str, Path], tmp_path: Path) -> None:
    """One flipped bit in a mesh of it: the object that it would stand for is not to blame."""
    for kept in scene["library"].parent.glob("library.*"):
        shutil.copy(kept, tmp_path)
    archive = tmp_path / "library.zip"
    with zipfile.ZipFile(archive) as opened:
        first = next(each for each in opened.infolist() if each.filename.startswith("bottom_cabinet_0/meshes/"))
    content = bytearray(archive.read_bytes())
    content[first.header_offset + 30 + len(first.filename) + first.compress_size // 2] ^= 1
    archive.write_bytes(content)
    with refused("E-FILE-UNREADABLE", "library.zip", "snakemake --cores 2 library"):
        run(cousins=scene["cousins"], objects=scene["objects"], library=tmp_path / "library.json", variant="default",
            out=tmp_path / "out")  # fmt: skip


def test_frames_agree_with_the_box(scene: dict[str, Path], tmp_path: Path) -> None:
    """The yaw of a placed cabinet turns its front (+x) towards the camera."""
    built = build(read_inputs(scene["cousins"], scene["objects"], scene["library"]), 1, GenerationConfig())
    front = yaw_matrix(built.items[0].box.yaw)[:, 0]
    assert front == pytest.approx([-1, 0, 0], abs=1e-3)


def test_a_scene_that_fails_leaves_nothing(
    scene: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreadable(*args: object) -> None:
        raise InputError("mesh.obj", "is broken.", code="E-MESH-BROKEN")

    monkeypatch.setattr("roomkin.stages.generation.generate.simulate", unreadable)
    with pytest.raises(InputError, match="is broken"):
        run(cousins=scene["cousins"], objects=scene["objects"], library=scene["library"], variant="default",
            out=tmp_path / "out")  # fmt: skip
    assert not (tmp_path / "out").exists() or not any((tmp_path / "out").iterdir())
