"""Places for the robot's base in a room, and what is in its way there."""

import numpy as np
from sapien.physx import PhysxArticulationLinkComponent
from scipy.spatial import cKDTree

from roomkin.plugins.in_scene.room import GeneratedRoom
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.clearance import BASE, arm_spheres
from roomkin.stages.simulation.robot import GRIPPER_OPEN
from roomkin.stages.tasks.api import EnvWrapper

# Metres that are tried, towards the handle and sideways; chosen.
TOWARDS, SIDEWAYS = (0.0, -0.05, 0.08, -0.1, 0.15), (0.0, 0.12, -0.12, 0.25, -0.25)


def list_base_shifts() -> list[tuple[float, float]]:
    """Shifts (x, y) of the robot from its usual place before a handle, in the object's frame, the smallest first."""
    found = [(x, y) for x in TOWARDS for y in SIDEWAYS]
    return sorted(found, key=lambda shift: (round(abs(shift[0]) + abs(shift[1]), 3), shift))


def find_obstacle(task: EnvWrapper, room: GeneratedRoom) -> str | None:
    """The obstacle of the robot in its present pose, or of what the task brings along (props); or None."""
    things = {name: points for name, points in room.obstacles.items() if name != "floor"}
    base = task.env.agent.robot.pose.sp.to_transformation_matrix()
    arm, radii = arm_spheres(task.chain.frames(task.joints()[None, :7]), GRIPPER_OPEN)
    plinth = [(0.0, 0.0, -depth) for depth in np.arange(0.1, base[2, 3], 0.1)]
    centers = transform_points(base, np.concatenate([arm[0], BASE[:, :3], np.reshape(plinth, (-1, 3))]))
    radii = np.concatenate([radii, BASE[:, 3], np.full(len(plinth), BASE[0, 3])])
    gaps = {name: float((cKDTree(points).query(centers)[0] - radii).min()) for name, points in things.items()}
    tightest = min(gaps, key=lambda name: gaps[name], default=None)
    if tightest is not None and gaps[tightest] < 0:
        return f"{tightest} is in the robot's place"
    for prop, pose in task.env.props():
        asset = read_asset(prop.folder)
        low, high = np.array([asset.box_min, asset.box_max]) * prop.scale
        for name, points in things.items():
            local = transform_points(invert_transform(pose), points)
            if ((local > low) & (local < high)).all(axis=1).any():
                return f"{name} is in the {asset.id}'s place"
    return None


def find_touched(task: EnvWrapper, room: GeneratedRoom) -> set[str]:
    """Names of furniture and walls that the robot or the object touches now."""
    bodies = (task.env.agent.robot, task.env.object)
    ours = {link.entity.per_scene_id for body in bodies for link in body._objs[0].links}
    names = set()
    for contact in task.env.scene.sub_scenes[0].get_contacts():
        others = [body for body in contact.bodies if body.entity.per_scene_id not in ours]
        if len(others) == 1 and any(point.separation < 0.001 for point in contact.points):
            link = isinstance(others[0], PhysxArticulationLinkComponent)
            names.add(others[0].articulation.name if link else others[0].entity.name)
    return names & (set(room.obstacles) - {"floor"})
