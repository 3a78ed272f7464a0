"""Where the arm can hold the hand, and what is in it."""

from dataclasses import replace

import numpy as np
import pytest

from roomkin.plugins.bowl.carry import can_hold
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.planning.rollout import Stretch
from roomkin.stages.tasks.api import EnvWrapper
from tests.unit.demo_assets import cabinet

OPTIONS = TaskConfig(scale_variants=1)


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> EnvWrapper:
    folder = tmp_path_factory.mktemp("assets") / "door"
    cabinet(folder)
    return EnvWrapper("door", folder, "door_0_joint", None, OPTIONS, render=False)


def test_a_hand_can_be_held_where_the_arm_reaches_and_nothing_is(door: EnvWrapper) -> None:
    door.place(0)
    where, around = door.env.base_from_asset(), Surroundings(door.env.target)
    here, far, inside = door.hand(), door.hand(), door.hand()
    far[:3, 3] += [1.0, 0.0, 0.0]
    middle = door.env.target.moving.bounds.mean(axis=0)
    inside[:3, 3] = (where @ np.append(middle, 1.0))[:3]
    poses = np.stack([here, far, inside])
    state = Stretch(poses, 0.04, (door.env.target.lower,) * 2)
    free = can_hold(door.chain, door.joints()[:7], poses, state, where, around)
    assert free.tolist() == [True, False, False]
    on_the_way = np.array(
        [[*(invert_transform(here) @ np.append((where @ np.append(middle, 1.0))[:3], 1.0))[:3], 0.02]]
    )
    state = replace(state, held=on_the_way)  # a held thing that reaches into the door
    assert not can_hold(door.chain, door.joints()[:7], poses, state, where, around)[0]
