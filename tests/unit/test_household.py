"""What rooms hold beside furniture: a washing machine opens, a rug carries, keys are seen but not touched."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from roomkin.plugins.furniture.catalogue import CATEGORIES, has_fronts, leaves, sample
from roomkin.plugins.furniture.folder import generate, robot_of
from roomkin.plugins.furniture.library import make
from roomkin.plugins.furniture.shapes import bounds_of
from roomkin.stages.articulated.asset_folder import contract_joints
from roomkin.stages.contracts.categories import category_in
from roomkin.stages.simulation.loading import load_asset, physics_scene, root_pose
from tests.unit.physics import add_ground, position_of

ROOM = (
    *("bag", "can", "cell_phone", "curtain", "cushion", "cutlery", "keyboard", "monitor", "mouse", "ottoman"),
    *("radiator", "remote", "rug", "sink", "suitcase", "telephone", "toilet", "washing_machine", "wine_glass"),
)


@pytest.mark.parametrize("index", range(5))
def test_a_washing_machine_has_a_round_door_that_opens_away_from_its_body(index: int) -> None:
    model = generate(sample("washing_machine", index, 0))
    (joint,) = contract_joints(robot_of(model, "washing_machine"))
    assert joint.part_type == "door" and joint.handle == "arch" and joint.panel is not None
    assert joint.panel.hinge in ("left", "right") and 0.3 < joint.panel.size[1] < 0.45
    (door,) = model.moving
    body = max(part.mesh.bounds[1][0] for part in model.base if part.collisions is None)
    handle = max(door.parts, key=lambda part: part.mesh.bounds[1][0])
    assert (handle.mesh.bounds[:, 1].mean() - door.origin[1]) * door.axis[2] < -0.25, "held at its free side"
    for angle in np.linspace(0, door.upper, 7):
        turn = trimesh.transformations.rotation_matrix(angle, door.axis, door.origin)
        points = np.concatenate([trimesh.transform_points(part.mesh.vertices, turn) for part in door.parts])
        assert points[:, 0].min() > body, f"it meets its body at {np.degrees(angle):.0f} degrees"


def test_a_door_without_a_layout_is_counted() -> None:
    assert has_fronts("washing_machine") == (True, False) and leaves("washing_machine") == (3, 0)
    assert leaves("oven") == (0, 3) and leaves("rug") == (0, 0)


def test_a_rug_lies_flat_and_carries(tmp_path: Path) -> None:
    rug, ottoman = make("rug", 0, 0, tmp_path), make("ottoman", 0, 0, tmp_path)
    assert rug.size[2] < 0.015 < 1 < rug.size[1]
    scene = physics_scene()
    add_ground(scene)
    lying = load_asset(scene, tmp_path / rug.id, root_pose(rug, (0, 0, rug.size[2] / 2), 0.0), False, rug.id)
    above = (0.2, 0.1, rug.size[2] + ottoman.size[2] / 2 + 0.001)
    standing = load_asset(scene, tmp_path / ottoman.id, root_pose(ottoman, above, 0.5), False, ottoman.id)
    start = [position_of(body) for body in (lying, standing)]
    for _ in range(200):
        scene.step()
    for body, before in zip((lying, standing), start, strict=True):
        assert np.linalg.norm(position_of(body) - before) < 0.005


def test_what_is_only_seen_lies_within_what_is_touched() -> None:
    """The physics sees about the box that the eye sees: nothing floats, nothing sinks into what carries it."""
    for name in ROOM:
        for index in range(CATEGORIES[name].count):
            model = generate(sample(name, index, 0))
            parts = [*model.base, *(part for moving in model.moving for part in moving.parts)]
            seen = bounds_of([part.mesh for part in parts])
            touched = bounds_of([piece for part in parts for piece in part.pieces])
            assert abs(touched[0][2] - seen[0][2]) < 1e-4, f"{name}_{index} stands on what is not touched"
            assert (touched[1] - touched[0] > 0.4 * (seen[1] - seen[0])).all(), f"{name}_{index}"


@pytest.mark.parametrize(
    ("file", "category"),
    [
        *(("pouf_3", "ottoman"), ("throwPillow", "cushion"), ("area_rug", "rug"), ("drapes", "curtain")),
        *(("wash_basin", "sink"), ("WC", "toilet"), ("washer", "washing_machine"), ("computerScreen", "monitor")),
        *(("desk_phone", "telephone"), ("smartphone", "cell_phone"), ("tv_remote", "remote"), ("010_soup_can", "can")),
        *(
            ("trash_can", "trash_can"),
            ("garbage_can", "trash_can"),
            ("wineglass", "wine_glass"),
            ("030_fork", "cutlery"),
        ),
        *(("backpack", "bag"), ("luggage", "suitcase"), ("sink_cabinet", "bottom_cabinet"), ("toilet_seat", None)),
    ],
)
def test_files_are_known_by_what_people_call_them(file: str, category: str | None) -> None:
    assert category_in(file) == category
