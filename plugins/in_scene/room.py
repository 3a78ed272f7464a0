"""A generated scene about one of its objects: furniture in the robot's way, and where its base may stand."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import sapien
import trimesh
from mani_skill.utils.geometry.trimesh_utils import get_component_meshes
from sapien.physx import PhysxArticulation, PhysxArticulationLinkComponent, PhysxRigidBaseComponent
from scipy.spatial import cKDTree

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene, Look
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.scene_file import read_items
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points, yaw_matrix
from roomkin.stages.planning.clearance import BASE, arm_spheres
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.loading import load_asset, physics_scene, root_pose
from roomkin.stages.simulation.robot import GRIPPER_OPEN
from roomkin.stages.simulation.room import Body, add_backdrop
from roomkin.stages.tasks.api import EnvWrapper

AGAIN = "generate the scenes again"
OBSTACLES_WITHIN = 1.6  # metres around the target within which furniture counts as an obstacle


@dataclass
class GeneratedRoom:
    """A generated scene; `target` is the object that a task is about, `others` is what else stands in it.

    shift: of the robot from its usual place before the target, x and y in the target's frame, metres.
    look: colors and bounds of floor and walls; None: usual ones.
    """

    scene: GeneratedScene
    target: Placed
    others: list[Placed]
    shift: tuple[float, float] = (0.0, 0.0)
    look: Look | None = None

    @property
    def world_from_nominal(self) -> Array:
        """(4, 4) pose of the frame in which the target's box stands above the origin, on z = 0, and faces +x."""
        x, y, _ = self.target.box.center
        return make_transform(yaw_matrix(self.target.box.yaw), [x, y, self.target.box.bottom])

    def stand(self, base: Array) -> Array:
        """The robot's place, of its pose (4, 4) in the target's nominal frame: shifted, never below the floor."""
        world: Array = self.world_from_nominal @ make_transform(np.eye(3), [*self.shift, 0.0]) @ base
        world[2, 3] = max(world[2, 3], 0.0)
        return world

    def load(self, scene: sapien.Scene) -> dict[str, Body]:
        """Add floor, walls and all furniture but the target, which stays where it is; by name."""
        boxes = [item.box for item in (self.target, *self.others)]
        camera = np.array(self.scene.floor_from_camera)[:3, 3]
        bodies: dict[str, Body] = {
            block.name: block for block in add_backdrop(scene, boxes, self.scene.walls, camera, self.look)
        }
        for item in self.others:
            pose = root_pose(item.asset, item.box.center.tolist(), item.box.yaw)
            bodies[item.id] = load_asset(scene, item.folder, pose, True, item.id)
        return bodies

    @cached_property
    def obstacles(self) -> Mapping[str, Array]:
        """(N, 3) points on the surfaces of floor, walls and furniture, by name, as far as the robot may reach."""
        center, reach = self.target.box.center, float(np.linalg.norm(self.target.box.size)) / 2 + OBSTACLES_WITHIN
        scene = physics_scene()  # bodies die with it
        found = {name: surface(body, center, reach) for name, body in self.load(scene).items()}
        return {name: points for name, points in found.items() if len(points)}


def surface(body: Body, center: Array, reach: float) -> Array:
    """(N, 3) points on the collision meshes of a body within `reach` of `center`, world frame; always the same ones."""
    links = (
        body.links if isinstance(body, PhysxArticulation) else [body.find_component_by_type(PhysxRigidBaseComponent)]
    )
    points = [np.zeros((0, 3))]
    for link in links:
        pose = link.pose.to_transformation_matrix()
        local = transform_points(invert_transform(pose), center)
        for mesh in get_component_meshes(link):
            low, high = np.clip(mesh.bounds, local - reach, local + reach)
            if (low >= high).any():
                continue
            if len(mesh.vertices) == 8:  # a box: of walls and floors only what is near
                mesh = trimesh.creation.box(bounds=[low, high])
            count = int(mesh.area * 8000) + 1  # a little more than a centimetre apart
            some = trimesh.sample.sample_surface(mesh, count, seed=np.random.default_rng(0))[0]
            points.append(transform_points(pose, some))
    near = np.concatenate(points)
    return near[np.linalg.norm(near - center, axis=1) < reach]


def read_room(path: Path, target: str, library: Path, cache: Path) -> GeneratedRoom:
    """The room of a generated scene about one of its objects.

    Args:
        cache: folder for models at their sizes.

    Raises:
        InputError: the scene has no such object, or a model that the library does not have.
    """
    generated = read_json(GeneratedScene, path, AGAIN)
    stands = [item.id for item in generated.objects if item.status == "ok"]
    if target not in stands:
        failed = {item.id: item.reason for item in generated.objects if item.status == "failed"}
        why = f"object '{target}' failed: {failed[target]}" if target in failed else f"has no object '{target}'"
        raise InputError(path, f"{why}.", f"those that stand: {', '.join(stands) or 'none'}", code="E-OBJECT-MISSING")
    items = {item.id: item for item in read_items(generated, AssetFolders(library), cache, path)}
    return GeneratedRoom(generated, items.pop(target), list(items.values()))


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
