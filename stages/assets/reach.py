"""Kinematic check of imported doors and drawers: whether the arm can follow them open."""

from pathlib import Path

import numpy as np
import sapien
from sapien.physx import PhysxArticulation

from stages.articulated.asset_folder import read_asset
from stages.contracts.task_options import TaskConfig
from stages.geometry.frames import inverse
from stages.planning.articulation import opened_to
from stages.planning.clearance import Surroundings
from stages.simulation.loading import load_asset, physics_scene
from stages.simulation.robot import REST
from stages.simulation.target import read_target
from stages.tasks.base_placement import MOTION, can_follow, reachable_base, success_opening
from stages.tasks.initial_state import InitialState, base_pose


def undisturbed() -> InitialState:
    """The state in the middle of all that varies."""
    return InitialState(0, np.zeros(3), 0.0, np.zeros(2), 0.0, np.zeros(7))


def out_of_reach(folder: Path) -> list[str]:
    """A line for every door and drawer with a handle that the arm can follow from no place."""
    asset, options = read_asset(folder), TaskConfig()
    handled = {joint.name: joint for joint in asset.joints if joint.handle is not None}
    scene = physics_scene()
    body = load_asset(scene, folder, sapien.Pose(), fixed=True, name="imported")
    if not handled or not isinstance(body, PhysxArticulation):
        return []
    body.set_qpos(body.get_qlimits()[:, 0])
    lines = []
    for index, name in enumerate(joint.name for joint in body.get_active_joints()):
        if name not in handled:
            continue
        target = read_target(body, index)
        base = base_pose(target.reference, target.side, undisturbed(), options, target.flap)
        around = Surroundings(target)
        opening = success_opening(target, options)
        if target.side:
            reached = reachable_base(base, np.eye(4), REST, around, opening) is not None
        else:
            goals = opened_to(target, opening, MOTION.goal_margin)
            reached = any(can_follow(inverse(base), REST, around, goal) for goal in goals)
        if not reached:
            lines.append(f"{handled[name].role} '{name}' is not opened: the arm can follow it from no place")
    return lines
