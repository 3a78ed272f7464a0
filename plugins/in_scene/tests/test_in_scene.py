"""Demonstrations inside a generated scene: the robot before its object, other furniture about."""

import json
from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.films.kinds import read_films
from roomkin.plugins.in_scene.demonstrate import run
from roomkin.plugins.in_scene.kinds import SceneDemonstration, SceneDemonstrations
from roomkin.plugins.in_scene.room import OBSTACLES_WITHIN, GeneratedRoom, find_obstacle, list_base_shifts, read_room
from roomkin.stages.contracts import InputError, read_json, write_json
from roomkin.stages.contracts.archives import unpack
from roomkin.stages.contracts.episode_store import read_episodes
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.tasks.api import EnvWrapper
from tests.packages import needs
from tests.refusals import refused
from tests.unit.demo_assets import cabinet

TASK = {"points": 128, "camera_size": 64, "cloud": "target_link"}
YAW = 2.9  # of the cabinet: it faces the camera
PLACE = (2.0, -0.3, 0.9)  # its box's center: it hangs 0.55 m above the floor


def scene(rank: int, *others: PlacedObject, target: str = "cab") -> GeneratedScene:
    """A cabinet on the wall x = 2.25, and other things."""
    hung = PlacedObject(
        id="cabinet_1", label="cabinet", asset=target, category="bottom_cabinet", position=PLACE, yaw=YAW,
        size=(0.4, 0.45, 0.7), support="wall",
    )  # fmt: skip
    camera = [[0.0, 0.0, 1.0, -1.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.4], [0.0, 0.0, 0.0, 1.0]]
    return GeneratedScene(
        scene="room_1", variant="default", rank=rank, width=64, height=48, floor_from_camera=camera,
        intrinsics=[[50.0, 0.0, 31.5], [0.0, 50.0, 23.5], [0.0, 0.0, 1.0]],
        walls=[Wall(id="wall_1", normal=(-1.0, 0.0, 0.0), offset=-2.3, points=9)], objects=[hung, *others],
    )  # fmt: skip


def block(name: str, position: tuple[float, float, float], size: tuple[float, float, float]) -> PlacedObject:
    """A cabinet that is only in the way."""
    return PlacedObject(
        id=name, label=name, asset="cab", category="bottom_cabinet", position=position, yaw=YAW, size=size
    )


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    layouts = {"cab": [["door"]], "shelf": [["open"]], "chest": [["drawer"], ["drawer"]], "oven": [["panel"], ["flap"]]}
    for name, layout in layouts.items():
        cabinet(folder / "models" / name, layout=layout, major="rows", handle_length=0.5)
    write_part(folder / "library.json", folder / "models")
    return folder / "library.json"


def test_one_demonstration_per_scene_or_the_reason_for_none(library: Path, tmp_path: Path) -> None:
    beside = block("chest_1", (1.9, 0.6, 0.35), (0.4, 0.45, 0.7))
    wall_of_boxes = block("chest_1", (1.2, -0.5, 0.6), (0.9, 1.4, 1.2))  # where the robot would stand
    made = [scene(1, beside), scene(2, wall_of_boxes), scene(3, target="shelf"), scene(4, target="gone")]
    paths = []
    for number, each in enumerate(made, 1):
        paths.append(tmp_path / f"scene_{number}.json")
        write_json(paths[-1], each)
    given = {"library": library, "object": "cabinet_1", "task": "door", "task_options": json.dumps(TASK), "seed": 1}
    run(scenes=tuple(paths), out=tmp_path / "out", **given)
    found = read_json(SceneDemonstrations, tmp_path / "out" / "in_scene.json")
    good, blocked, shelf, gone = found.demonstrations
    assert good.status == "ok" and good.joint == "door_0_joint" and good.film and good.film.opened > 0.5
    assert blocked.status == "failed" and "chest_1 is in the robot's place" in blocked.reason
    assert shelf.reason == "cabinet_1 is shelf, which has no door that the robot can open"
    assert gone.status == "failed" and "'gone', which the library does not have" in gone.reason
    assert [film.role for film in read_films(unpack(tmp_path / "out" / "films.zip", "") / "films.json").films] == [
        "rank_1"
    ]
    assert (tmp_path / "out" / "film.png").is_file()

    store = read_episodes(unpack(tmp_path / "out" / "episodes.zip", "") / "rank_1.h5")
    (clouds, _, actions), *others = store.episodes
    assert not others and len(actions) == good.film.steps
    scenery = clouds[0][clouds[0][:, 3] == 0, :3].astype(float)
    assert np.ptp(scenery, axis=0)[1] < 0.6, "neither the chest nor the wall is in the cloud"
    with refused("E-SCENE-OBJECT"):
        run(scenes=(paths[0],), out=tmp_path / "no", **(given | {"object": "sofa_1"}))


def test_an_object_that_failed_is_no_target(library: Path, tmp_path: Path) -> None:
    lost = PlacedObject(id="lamp_1", label="lamp", status="failed", reason="too small")
    write_json(tmp_path / "scene_1.json", scene(1, lost))
    for name, why in (("lamp_1", "object 'lamp_1' failed: too small"), ("oven_1", "has no object 'oven_1'")):
        with refused("E-OBJECT-MISSING", why):
            read_room(tmp_path / "scene_1.json", name, library, tmp_path)


def test_the_robot_stands_before_the_object_and_not_in_the_floor(library: Path, tmp_path: Path) -> None:
    low = scene(1).objects[0].model_copy(update={"position": (2.0, -0.3, 0.35), "support": "floor"})
    made = scene(1).model_copy(update={"objects": [low, block("chest_1", (1.9, 0.6, 0.35), (0.4, 0.45, 0.7))]})
    write_json(tmp_path / "scene_1.json", made)
    room = read_room(tmp_path / "scene_1.json", "cabinet_1", library, tmp_path)
    options = TASK | {"object_xy": 0.0, "object_yaw": 0.0}
    task = demo_task(room, options)
    base = task.env.agent.robot.pose.sp.to_transformation_matrix()
    assert base[2, 3] == pytest.approx(0.0, abs=1e-6), (
        "a handle so near to the floor would have the robot stand below it"
    )
    root = task.env.object.pose.sp.to_transformation_matrix()
    front = root[:3, :3] @ [1.0, 0.0, 0.0]
    assert front == pytest.approx([np.cos(YAW), np.sin(YAW), 0.0], abs=1e-5)
    away = base[:3, 3] - root[:3, 3]
    assert away @ front > 0.5 and base[:3, 0] @ front < -0.9, "before the front, facing it"
    assert find_obstacle(task, room) is None
    assert len(task.env.obstacles()) > 1000
    away_from_it = np.linalg.norm(np.concatenate(list(room.obstacles.values())) - room.target.box.center, axis=1)
    assert away_from_it.max() < np.linalg.norm(room.target.box.size) / 2 + OBSTACLES_WITHIN
    room.shift = (-0.5, 0.0)  # into the cabinet and the wall behind it
    task.place(0)
    moved = task.env.agent.robot.pose.sp.to_transformation_matrix()
    assert (moved[:3, 3] - base[:3, 3]) @ front == pytest.approx(-0.5, abs=1e-5)
    task.close()


@pytest.mark.parametrize(
    ("task", "asset", "joint"),
    [
        ("drawer", "chest", "drawer_0_joint"),
        pytest.param("put_away_bowl", "chest", "drawer_0_joint", marks=needs("bowl")),
        ("door", "oven", "door_0_joint"),
    ],
)
def test_every_task_is_demonstrated_in_a_scene(
    library: Path, tmp_path: Path, task: str, asset: str, joint: str
) -> None:
    """A drawer, a bowl into it, and a flap, which an experiment would not choose but a scene may have."""
    made = scene(1, block("chest_1", (1.9, 0.9, 0.35), (0.4, 0.45, 0.7)), target=asset)
    write_json(tmp_path / "scene_1.json", made)
    run(
        scenes=(tmp_path / "scene_1.json",), object="cabinet_1", task=task, library=library, out=tmp_path / "out",
        task_options=json.dumps(TASK),
    )  # fmt: skip
    (found,) = read_json(SceneDemonstrations, tmp_path / "out" / "in_scene.json").demonstrations
    assert (found.status, found.joint) == ("ok", joint), found.reason


def test_a_model_that_cannot_be_used_fails_alone_and_a_broken_file_ends_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a flipped bit in the library is a rank that the robot cannot open."""

    def demonstrate(path: Path, generated: GeneratedScene, setting: object) -> None:
        raise faults[path.name]("model.urdf", "is broken.", code="E-MODEL-BROKEN")

    faults: dict[str, type[InputError]] = {"scene_1.json": ObjectError, "scene_2.json": ObjectError}
    monkeypatch.setattr("roomkin.plugins.in_scene.demonstrate.demonstrate_in_scene", demonstrate)
    monkeypatch.setattr("roomkin.plugins.in_scene.demonstrate.FilmRenderer", lambda light: None)
    paths = tuple(tmp_path / name for name in faults)
    for rank, path in enumerate(paths, 1):
        write_json(path, scene(rank))
    run(scenes=paths, object="cabinet_1", task="door", library=tmp_path, out=tmp_path / "out")
    found = read_json(SceneDemonstrations, tmp_path / "out/in_scene.json").demonstrations
    assert [(one.status, one.reason) for one in found] == [("failed", "model.urdf: is broken.")] * 2
    faults["scene_2.json"] = InputError
    with refused("E-MODEL-BROKEN"):
        run(scenes=paths, object="cabinet_1", task="door", library=tmp_path, out=tmp_path / "out")


@needs("bowl")
def test_what_a_task_brings_along_does_not_stand_in_furniture(library: Path, tmp_path: Path) -> None:
    stool = block("stool_1", (1.47, 0.24, 0.3), (0.3, 0.3, 0.6))
    write_json(tmp_path / "scene_1.json", scene(1, stool, target="chest"))
    room = read_room(tmp_path / "scene_1.json", "cabinet_1", library, tmp_path)
    world = TaskConfig.model_validate(TASK)
    task = EnvWrapper(
        "put_away_bowl", room.target.folder, "drawer_0_joint", None, world, render=False, vary_scale=False, room=room
    )
    task.place(0)
    assert task.env.props()[1][1][:2, 3] == pytest.approx([1.47, 0.24], abs=0.02), "the stand"
    assert find_obstacle(task, room) == "stool_1 is in the stand's place"
    task.close()


def demo_task(room: GeneratedRoom, options: dict[str, object]):  # type: ignore[no-untyped-def]
    """The door task in a room, placed, without a camera."""
    task = EnvWrapper(
        "door", room.target.folder, "door_0_joint", None, TaskConfig.model_validate(options), render=False,
        vary_scale=False, room=room,
    )  # fmt: skip
    task.place(0)
    return task


def test_places_begin_with_the_usual_one_and_are_all_different() -> None:
    shifts = list_base_shifts()
    assert shifts[0] == (0.0, 0.0) and len(set(shifts)) == len(shifts)


def test_a_failed_scene_has_a_reason_and_no_film() -> None:
    about = {"scene": "room_1", "variant": "default", "rank": 1, "asset": "cab"}
    with pytest.raises(ValueError, match="film"):
        SceneDemonstration(**about, status="ok")
    with pytest.raises(ValueError, match="reason"):
        SceneDemonstration(**about, status="failed")
