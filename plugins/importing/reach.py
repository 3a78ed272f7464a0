"""Kinematic check of imported doors and drawers: whether the arm can follow them open."""

from pathlib import Path

import numpy as np
import sapien
from sapien.physx import PhysxArticulation

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, make_transform
from roomkin.stages.planning.articulation import choose_open_goals
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.loading import load_asset, physics_scene
from roomkin.stages.simulation.robot import REST
from roomkin.stages.simulation.target import read_target
from roomkin.stages.tasks.base_placement import MOTION, can_follow, find_success_opening, reachable_base
from roomkin.stages.tasks.initial_state import (
    InitialState,
    base_pose,
    nominal_root,
    object_motion,
    sample_initial_state,
    sample_scale,
)

STARTS = 4  # of the skill, by seed: seconds each; what it opens in two of three is missed once in a hundred times


def find_middle_state() -> InitialState:
    """The state in the middle of all that varies."""
    return InitialState(0, np.zeros(3), 0.0, np.zeros(2), 0.0, np.zeros(7))


def list_unreachable(folder: Path) -> list[str]:
    """A line for every door and drawer with a handle that the arm can follow in none of several starts of the skill.

    The starts are the undisturbed one, at the asset's own size, and the first episodes', at their scales.
    """
    asset, options = read_asset(folder), TaskConfig()
    left = {joint.name: joint for joint in asset.joints if joint.handle not in (None, "face")}
    starts = [(find_middle_state(), np.ones(3))]
    for seed in range(STARTS):
        starts.append((sample_initial_state(seed, options), sample_scale(seed, options, options.scale_range)))
    for state, scale in starts:
        if left:
            for name in _find_followed(folder, asset, set(left), state, scale, options):
                del left[name]
    return [
        f"{joint.part_type} '{name}' is not opened: in none of {len(starts)} starts can the arm follow it"
        for name, joint in left.items()
    ]


def _find_followed(
    folder: Path, asset: Asset, names: set[str], state: InitialState, scale: Array, options: TaskConfig
) -> list[str]:
    """Which of some joints the arm can follow from where the skill starts in a state."""
    scene = physics_scene()
    body = load_asset(scene, folder, sapien.Pose(), fixed=True, name="imported", scale=scale)
    if not isinstance(body, PhysxArticulation):
        return list(names)
    body.set_qpos(body.get_qlimits()[:, 0])
    nominal = nominal_root(asset, scale)
    root = object_motion(state) @ make_transform(np.eye(3), nominal)
    found = []
    for index, name in enumerate(joint.name for joint in body.get_active_joints()):
        if name not in names:
            continue
        target = read_target(body, index)
        around, opening = Surroundings(target), find_success_opening(target, options)
        base = base_pose(target.reference + nominal, target.side, state, options, target.flap)
        arm = REST + state.joints
        if target.side:
            followed = reachable_base(base, root, arm, around, opening) is not None
        else:
            goals = choose_open_goals(target, opening, MOTION.goal_margin)
            followed = any(can_follow(invert_transform(base) @ root, arm, around, goal) for goal in goals)
        if followed:
            found.append(name)
    return found
