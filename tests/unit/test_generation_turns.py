"""How far models are turned to the axes of what was seen, and how far they move when a scene settles."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sapien

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.cousins import Cousin, Orientation
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.generation.settling import run_physics
from roomkin.stages.generation.turning import find_yaw
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import view_angle
from tests.unit.generation_scenes import thing

CAMERA = (0.0, 0.0, 1.4)
BOX = UprightBox([3.0, 0.5, 0.4], [0.5, 0.8, 0.8], 0.0)
OUTLINE = np.array([[x, y, 0.4] for x in (2.75, 3.25) for y in np.linspace(0.1, 0.9, 30)])


def turned(degrees: float, articulated: bool, *walls: Wall, **options: float | None) -> float:
    """Degrees at which a model stands that was matched at so many, in the place of a box along the axes."""
    seen = Orientation(yaw=view_angle(CAMERA, BOX.center, np.deg2rad(degrees)))
    cousin = Cousin(rank=1, asset="a", category="c", distance=1, votes=None, orientation=seen, orientations=[])
    limits = GenerationConfig().model_copy(update={"snap_articulated": 20.0, "snap_other": 10.0} | options)
    return float(np.rad2deg(find_yaw(cousin, BOX, OUTLINE, CAMERA, walls, articulated, limits)))


def test_models_with_joints_are_turned_farther_than_others() -> None:
    assert turned(8, True) == pytest.approx(0) and turned(8, False) == pytest.approx(0)
    assert turned(15, True) == pytest.approx(0) and turned(15, False) == pytest.approx(15)
    assert turned(25, True) == pytest.approx(25) and turned(25, False) == pytest.approx(25)
    assert turned(100, True) == pytest.approx(90)  # the nearest quarter
    assert turned(40, True, snap_articulated=None) == pytest.approx(0)
    assert turned(40, False, snap_other=None) == pytest.approx(0)
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.3, points=9)
    assert turned(170, False, wall) == turned(190, False, wall) == pytest.approx(180)  # whatever the limit


def test_a_front_that_fits_as_well_comes_before_a_rear_but_not_as_in_the_paper() -> None:
    rear, front = (Orientation(yaw=yaw, score=0.9) for yaw in (np.pi, 0.0))
    cousin = Cousin(rank=1, asset="a", category="c", distance=1, votes=None, orientation=rear, orientations=[front])
    found = [
        np.rad2deg(find_yaw(cousin, BOX, OUTLINE, CAMERA, [], False, GenerationConfig(wall_view=view)))
        for view in ("rear", "first")
    ]
    assert np.abs(found) == pytest.approx([180, 0])


def test_a_view_with_its_rear_to_the_wall_comes_first_but_not_as_in_the_paper() -> None:
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.3, points=9)
    side, rear_to_wall = (Orientation(yaw=view_angle(CAMERA, BOX.center, np.deg2rad(each))) for each in (90, 180))
    cousin = Cousin(
        rank=1, asset="a", category="c", distance=1, votes=None, orientation=side, orientations=[rear_to_wall]
    )
    found = [
        np.rad2deg(find_yaw(cousin, BOX, OUTLINE, CAMERA, [wall], False, GenerationConfig(wall_view=view)))
        for view in ("rear", "first")
    ]
    assert np.abs(found) == pytest.approx([180, 90])


def test_what_hangs_says_nothing_of_how_calm_a_scene_is() -> None:
    items = [
        thing("picture", (3, 0, 1.5), (0.05, 0.6, 0.4), mounting=1, walls=["wall_1"]),
        thing("mug", (2, 0, 0.05), (0.1,) * 3),
    ]
    moved = {"picture": 0.0, "mug": 0.02}
    bodies: Any = {
        item.id: SimpleNamespace(
            per_scene_id=number,
            get_pose=lambda item=item: sapien.Pose(np.add(item.center, [moved[item.id], 0, 0])),
        )
        for number, item in enumerate(items)
    }
    scene: Any = SimpleNamespace(timestep=0.01, step=lambda: None, get_contacts=list)
    found = run_physics(scene, bodies, items, 0, GenerationConfig())
    assert found.shifts == pytest.approx(moved)
    assert found.plausibility.mean_displacement == pytest.approx(0.02)
