"""Push Button: a sprung button on a box, in no default library; pushed by the skill; no drawer."""

from pathlib import Path

import numpy as np
import pytest
import sapien

from roomkin.plugins.button.skills.push import Skill, list_pushes
from roomkin.plugins.furniture.catalogue import CATEGORIES, sample
from roomkin.plugins.furniture.folder import build
from roomkin.stages.articulated.affordance import handle_extents
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.config.assets import COUNTS
from roomkin.stages.config.training import DemonstrationsConfig, RandomiseOptions
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.planning.articulation import HALF_PAD
from roomkin.stages.plugins import load
from roomkin.stages.simulation.loading import load_asset, physics_scene
from roomkin.stages.skills import FAR, Float
from roomkin.stages.skills.motion import SkillChain
from roomkin.stages.tasks.api import EnvWrapper
from tests.refusals import refused
from tests.unit.demo_assets import shifted

JOINT = "button_0_joint"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three boxes: a round button, a square one, a mushroom."""
    folder = tmp_path_factory.mktemp("boxes")
    for number in range(3):
        build(sample("button_box", number, 0), None, folder / f"box_{number}", f"box_{number}", "button_box")
    return folder


def world(folder: Path, randomise: RandomiseOptions | None = None) -> EnvWrapper:
    return EnvWrapper("push_button", folder, JOINT, None, TaskConfig(), render=False, randomise=randomise)


def test_the_default_library_has_none() -> None:
    assert "button_box" not in {*COUNTS, *CATEGORIES, *known_categories()}


def test_a_box_has_one_button_and_no_drawer(folder: Path) -> None:
    asset = read_asset(folder / "box_0")
    (joint,) = asset.joints
    assert (joint.part_type, joint.type, joint.handle) == ("button", "prismatic", "face")
    assert (asset.doors, asset.drawers, asset.articulated, asset.placement) == (0, 0, False, "object")
    low, high = PARTS["button"].motion
    assert low < joint.upper - joint.lower < high


def test_no_other_task_takes_it(folder: Path) -> None:
    assert load("tasks", "push_button").target_joint(folder / "box_1").joint == JOINT
    for other in ("door", "drawer"):
        assert load("tasks", other).target_joint(folder / "box_1") is None
        with refused("E-TASK-JOINT"):
            EnvWrapper(other, folder / "box_1", JOINT, None, TaskConfig(), render=False)


@pytest.mark.parametrize("number", range(3))
def test_what_is_pushed_is_its_face(folder: Path, number: int) -> None:
    """As `experiment select` notes where the handle is."""
    asset = read_asset(folder / f"box_{number}")
    panel = asset.joints[0].panel
    low, high = handle_extents(folder / f"box_{number}", asset, JOINT)
    assert panel is not None and (high - low)[1:] == pytest.approx(panel.size, rel=0.01)
    assert high[0] == pytest.approx(asset.box_max[0], abs=1e-6)


def test_it_comes_out_again(folder: Path) -> None:
    """At rest it stays out, pushed it comes back within half a second; a drawer would stay where it is."""
    scene = physics_scene()
    body = load_asset(scene, folder / "box_0", sapien.Pose(), True, "box")
    travel = read_asset(folder / "box_0").joints[0].upper
    for start in (0.0, travel):
        body.set_qpos(np.array([start], np.float32))
        for _ in range(50):
            scene.step()
        assert abs(float(body.get_qpos()[0])) < 0.05 * travel


def test_a_button_whose_joint_counts_from_elsewhere_is_the_same(folder: Path) -> None:
    other, scene = shifted(folder / "box_0", -0.02), physics_scene()
    body = load_asset(scene, other, sapien.Pose(), True, "box")
    for _ in range(2):
        assert body.get_qpos()[0] == pytest.approx(-0.02, abs=5e-4), "out, as it is loaded and half a second later"
        for _ in range(50):
            scene.step()
    lengths = []
    for each in (folder / "box_0", other):
        task = world(each)
        task.place(0)
        plan = Skill(task, DemonstrationsConfig())._plan()
        assert plan is not None
        lengths.append(float(np.linalg.norm(plan[1][-1, :3, 3] - plan[1][0, :3, 3])))
        task.close()
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-3)


def test_the_fingertips_touch_the_face_and_not_what_is_behind_it(folder: Path) -> None:
    task = world(folder / "box_0")
    task.place(0)
    target = task.env.target
    touch = next(list_pushes(target, np.eye(4)))
    tips = touch[:3, 3] + HALF_PAD * touch[:3, 2]
    assert touch[:3, 2] == pytest.approx(target.axis, abs=1e-6)
    assert tips @ target.axis == pytest.approx((target.moving.vertices @ target.axis).min(), abs=1e-6)
    task.close()


@pytest.mark.parametrize("number", range(3))
def test_the_skill_pushes_it_with_the_gripper_closed(folder: Path, number: int) -> None:
    task = world(folder / f"box_{number}")
    actions: list[Float] = []

    def act(action: Float, noisy: bool, ahead: float = FAR) -> None:
        actions.append(action)
        task.act(action)

    task.place(number)
    assert task.opened == pytest.approx(0, abs=0.02) and not task.success
    outcome = SkillChain(task, DemonstrationsConfig()).run(act)
    assert outcome.success and task.success and len(actions) < 30
    assert {float(action[6]) for action in actions} == {-1.0}
    for _ in range(12):  # back from the button, which follows
        task.act(np.array([-1, 0, 0, 0, 0, 0, -1], np.float32))
    assert task.opened < 0.1 and not task.success
    task.close()


def test_a_randomised_button_keeps_its_spring(folder: Path) -> None:
    task = world(folder / "box_0", RandomiseOptions())
    task.place(3)
    (joint,) = task.env.object._objs[0].active_joints
    assert joint.stiffness == PARTS["button"].spring != 0
    task.close()
