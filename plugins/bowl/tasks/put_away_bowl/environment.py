"""The environment of Putting Away Bowl: a bowl that fits, on a stand before a cabinet with a drawer."""

import hashlib
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import sapien
import torch
import trimesh
from mani_skill.utils.structs import Actor
from numpy.typing import NDArray

from roomkin.plugins.bowl.carry import Movable, Region, find_level_region, measure_headroom
from roomkin.stages.articulated.asset_folder import Description, read_model, write_asset
from roomkin.stages.articulated.model import RGBA, Link, RobotModel, Visual
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points, yaw_matrix
from roomkin.stages.geometry.solids import DENSITY, MINIMUM_INERTIA
from roomkin.stages.planning.clearance import surface_points
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.loading import ParsedAsset
from roomkin.stages.simulation.robot import batch_poses, cache_folder
from roomkin.stages.simulation.room import Prop
from roomkin.stages.simulation.target import Target
from roomkin.stages.tasks.base_placement import CLOSED
from roomkin.stages.tasks.environment import OpenTaskEnv
from roomkin.stages.tasks.initial_state import nominal_root
from roomkin.stages.tasks.observation import WRIST, MountedCamera, other_shoulder, shoulder

PROFILE = [(0.039, 0.0), (0.0598, 0.02), (0.065, 0.05)]  # of the default bowl: (radius, height) of its outside, metres
WALL = 0.012  # metres; as of wood, as PhysX lets go of thin walls
STAND = (((0.17, 0.17, 0.02), 0.0), ((0.06, 0.06, 0.5), -0.02))  # boxes: size, height of their tops; metres
LIGHT_WOOD, DARK_WOOD = (0.55, 0.36, 0.2, 1.0), (0.4, 0.22, 0.11, 1.0)  # linear
SCALE = (0.85, 1.15)  # of the bowl, uniform
AROUND, ABOVE = 0.04, 0.015  # metres kept free on each side of a bowl in a drawer, and above it


@cache
def default_bowl() -> Path:
    """Folder of the bowl; made once and kept between runs."""
    inner = [(radius - WALL, max(height, WALL)) for radius, height in PROFILE]
    inner[-1] = inner[-1][0], PROFILE[-1][1]
    body = trimesh.creation.revolve([(0, 0), *PROFILE, *inner[::-1], (0, WALL)], sections=24)
    base = trimesh.creation.revolve([(0, 0), (PROFILE[0][0], 0), inner[0], (0, WALL)], sections=16)
    return _write("bowl", [body], [base, *_wedges(inner)], LIGHT_WOOD)


def _wedges(inner: list[tuple[float, float]], count: int = 12) -> list[trimesh.Trimesh]:
    """Convex pieces of the wall between the profile and the one inside it."""
    angles = 2 * np.pi * np.arange(count + 1) / count
    return [
        trimesh.convex.convex_hull(
            np.array([(r * np.cos(t), r * np.sin(t), z) for t in turn for r, z in (*outside, *inside)])
        )
        for outside, inside in zip(pairwise(PROFILE), pairwise(inner), strict=True)
        for turn in pairwise(angles)
    ]


@cache
def stand_folder() -> Path:
    """Folder of what the bowl stands on: a plate on a column, its top at z = 0."""
    boxes = [trimesh.creation.box(size) for size, _ in STAND]
    for box, (size, top) in zip(boxes, STAND, strict=True):
        box.apply_translation((0, 0, top - size[2] / 2))
    return _write("stand", boxes, boxes, DARK_WOOD)


def _write(name: str, solids: list[trimesh.Trimesh], pieces: list[trimesh.Trimesh], color: RGBA) -> Path:
    """Folder of a wooden asset in the cache, its name a key of solids and of the convex pieces that collide."""
    shapes = [(mesh.vertices.round(6).tolist(), color) for mesh in (*solids, *pieces)]
    folder = cache_folder() / f"{name}-{hashlib.sha256(repr(shapes).encode()).hexdigest()[:16]}"
    if not (folder / "asset.json").exists():
        whole = trimesh.util.concatenate(solids)
        assert isinstance(whole, trimesh.Trimesh)
        visuals = [Visual(mesh, color, flat=len(mesh.vertices) == 8) for mesh in solids]
        inertia = DENSITY * whole.moment_inertia + MINIMUM_INERTIA * np.eye(3)
        link = Link("base", visuals, pieces, DENSITY * whole.volume, whole.center_mass, inertia)
        about = Description(name, name, "CC0-1.0", "procedural")
        write_asset(RobotModel(name, {"base": link}, []), folder, about)
    return folder


@cache
def load_visual_mesh(folder: Path) -> trimesh.Trimesh:
    """The visible mesh of an asset of one body, in its own frame and size; what collides may have faces inside."""
    visuals = [visual.mesh for link in read_model(folder).links.values() for visual in link.visuals]
    mesh = trimesh.util.concatenate(visuals)
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def sample_scale(extents: Array) -> float:
    """The scale of a bowl beside an object with these extents (3,): the same object, the same bowl."""
    entropy = [round(1e4 * extent) for extent in extents]
    return float(np.random.default_rng((*entropy, 47)).uniform(*SCALE))


def fitting_scale(extents: Array, floor: Region, target: Target) -> float:
    """The largest scale at which a bowl with these extents (3,) goes through an opened drawer and fits into it shut."""
    across = 2 * float(floor.room.max()) - AROUND
    along = 0.9 * (target.upper - target.lower) - 2 * AROUND
    up = measure_headroom(floor, target.fixed) - ABOVE
    return min(min(across, along) / float(extents[:2].max()), up / float(extents[2]))


FOOT = (-0.01, 0.04)  # metres about the drawer's floor at which the foot of a bowl in it is
SEEN = ((0.05, -0.6, 0.05), (1.0, 0.6, 0.95))  # workspace in the base frame that has the stand in it
FIELD_OF_VIEW = 1.4  # radians, with the stand in view of both shoulders' cameras
STAND_AT = (0.44, -0.38, -0.12)  # of the stand's top, from the closed handle: out from the front, y, up; metres
STAND_VARIES = (0.04, 0.04, 0.05)  # uniform +/- metres, of the stand
BOWL_VARIES = 0.015  # uniform +/- metres, of the bowl on it


def with_stand_in_view(options: TaskConfig) -> TaskConfig:
    """The options with cameras and workspace as wide as the stand beside the robot needs."""
    low, high = np.minimum(options.workspace_min, SEEN[0]), np.maximum(options.workspace_max, SEEN[1])
    wide = {"workspace_min": tuple(low.tolist()), "workspace_max": tuple(high.tolist())}
    return options.model_copy(update={**wide, "camera_fov": max(options.camera_fov, FIELD_OF_VIEW)})


class PutAwayBowlEnv(OpenTaskEnv):
    """The bowl is to lie in the target drawer, the drawer to be shut again, the gripper to have let go of the bowl.

    The bowl is made smaller as need be for the drawer to hold it.
    """

    simulation_frequency = 200  # at 100 the fingers sink 2 mm into what they hold, and a thin wall slips out
    robot_shift = (0.07, 0.0, 0.12)  # room for the hand before the handle of the opened drawer, and above the drawer

    def __init__(self, *args: Any, options: TaskConfig | dict[str, Any] | None = None, **kwargs: Any) -> None:
        super().__init__(*args, options=with_stand_in_view(TaskConfig.model_validate(options or {})), **kwargs)

    def cameras(self) -> Sequence[MountedCamera]:
        return [shoulder(self.options), other_shoulder(self.options), WRIST]

    def seen_ids(self, index: int = 0) -> NDArray[np.int16]:
        """Entity ids of what the cloud shows: the bowl, and the drawer or by `task.cloud` the whole cabinet."""
        bowl = self.bowl._objs[index].per_scene_id
        return np.append(super().seen_ids(index), np.int16(bowl))

    def _load_scene(self, options: dict[str, Any]) -> None:
        self._parsed_bowl: ParsedAsset | None = None
        super()._load_scene(options)
        builder = self._parse("stand", stand_folder(), fixed=True).builder()
        builder.initial_pose = sapien.Pose([0, -5, 0])
        self.stand: Actor = builder.build_kinematic("stand")
        self._stand_points = surface_points(load_visual_mesh(stand_folder()))

    def _load_object(self, scales: Array) -> None:
        """The asset, and a bowl that its drawer can hold, in every environment."""
        super()._load_object(scales)
        self._parsed_bowl = self._parsed_bowl or self._parse("bowl", default_bowl(), fixed=False)
        mesh = load_visual_mesh(default_bowl())
        self.floors: list[Region] = []
        self.bowl_meshes: list[trimesh.Trimesh] = []
        self.bowl_scales: list[float] = []
        bowls = []
        for index, (target, scale) in enumerate(zip(self.targets, scales, strict=True)):
            floor = find_level_region(target.moving)  # with the drawer shut
            if floor is None:
                what = f"'{self.joint_name}' is no drawer with a level floor."
                raise InputError(self.asset_folder, what, code="E-DRAWER-FLOOR")
            drawn = sample_scale(np.array(self.asset.size) * scale)
            factor = round(min(drawn, fitting_scale(mesh.extents, floor, target)), 3)
            self.floors.append(floor)
            self.bowl_scales.append(factor)
            self.bowl_meshes.append(mesh.copy().apply_scale(factor))
            builder = self._parsed_bowl.builder(np.full(3, factor))
            builder.initial_pose = sapien.Pose([0, 5, 0])
            builder.set_scene_idxs([index])
            bowls.append(builder.build(name="bowl" if len(scales) == 1 else f"bowl_{index}"))
        self.bowl: Actor = bowls[0] if len(bowls) == 1 else Actor.merge(bowls, name="bowl")

    def _parse(self, name: str, folder: Path, fixed: bool) -> ParsedAsset:
        loader = self.scene.create_urdf_loader()
        loader.name = name
        return ParsedAsset(loader, folder, fixed)

    def _exchange_object(self, scales: Array) -> None:
        self.scene.remove_from_state_dict_registry(self.bowl)
        for entity in self.bowl._objs:  # ManiSkill's remove_actor asks an entity for its entity
            self.scene.sub_scenes[0].remove_entity(entity)
        del self.scene.actors[self.bowl.name]
        super()._exchange_object(scales)

    def _initialize_episode(self, env_idx: torch.Tensor, options: dict[str, Any]) -> None:
        super()._initialize_episode(env_idx, options)
        stands, bowls = [], []
        for index in env_idx.tolist():
            rng = np.random.default_rng((int(self._episode_seed[index]), 23))
            shift = rng.uniform(-1, 1, 3) * STAND_VARIES
            handle = self.targets[index].reference + nominal_root(self.asset, self.scales[index])
            stand = make_transform(np.eye(3), np.add(handle, STAND_AT + shift))
            stand = self.room.world_from_nominal @ stand if self.room else stand
            at = [*rng.uniform(-BOWL_VARIES, BOWL_VARIES, 2), 1e-3 - float(self.bowl_meshes[index].bounds[0, 2])]
            stands.append(stand)
            bowls.append(stand @ make_transform(yaw_matrix(rng.uniform(-np.pi, np.pi)), at))
        self.stand.set_pose(batch_poses(np.stack(stands)))
        self.bowl.set_pose(batch_poses(np.stack(bowls)))
        for set_velocity in (self.bowl.set_linear_velocity, self.bowl.set_angular_velocity):
            set_velocity(torch.zeros(3, device=self.device))

    def success_opening(self, index: int = 0) -> float:
        """The fraction of its range to which the drawer is opened for the bowl."""
        wide = float(self.bowl_meshes[index].extents[:2].max()) + 2 * AROUND
        return min(0.95, wide / (self.targets[index].upper - self.targets[index].lower))

    def is_inside(self) -> torch.Tensor:
        """(N,) whether the bowl stands in the drawer: its middle over the floor, its foot at the floor's height."""
        local = (self.object.pose.inv() * self.bowl.pose).p
        lows, highs, axes = [], [], []
        for target, floor, mesh in zip(self.targets, self.floors, self.bowl_meshes, strict=True):
            foot = float(mesh.bounds[0, 2])
            lows.append(np.add(floor.low, (0, 0, FOOT[0] - foot)))
            highs.append(np.add(floor.high, (0, 0, FOOT[1] - foot)))
            axes.append(target.axis * (target.upper - target.lower))
        travel = self.measure_opening()[:, None] * torch.as_tensor(
            np.array(axes), dtype=local.dtype, device=local.device
        )
        low, high = (torch.as_tensor(np.array(ends), dtype=local.dtype, device=local.device) for ends in (lows, highs))
        return ((local - travel > low) & (local - travel < high)).all(dim=1)

    def check_success(self) -> torch.Tensor:
        """(N,) in, shut, and let go of."""
        there = self.is_inside() & (self.measure_opening() <= CLOSED)
        return there & ~self.agent.is_grasping(self.bowl) if bool(there.any()) else there

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Success; the official code has no such task, so its criterion (any joint past 10 %) says nothing here."""
        found = super().evaluate()
        return found | {"official_success": found["success"]}

    def movable(self) -> Movable:
        """The bowl, which belongs inside the drawer."""
        target = self.target
        value = target.lower + float(self.measure_opening()[0]) * (target.upper - target.lower)
        return Movable(
            self.bowl_meshes[0],
            self._in_base(self.bowl),
            self.floors[0],
            self.base_from_asset() @ target.motions(np.array([value]))[0],
            bool(self.is_inside()[0]),
        )

    def obstacles(self) -> Array:
        """(N, 3) points on the stand, and on what else stands about, in the robot base frame."""
        return np.concatenate([super().obstacles(), transform_points(self._in_base(self.stand), self._stand_points)])

    def props(self) -> list[tuple[Prop, Array]]:
        """Bowl and stand."""
        return [
            (Prop(folder, np.full(3, scale)), np.asarray(actor.pose[0].sp.to_transformation_matrix(), dtype=float))
            for folder, scale, actor in (
                (default_bowl(), self.bowl_scales[0], self.bowl),
                (stand_folder(), 1.0, self.stand),
            )
        ]

    def _in_base(self, actor: Actor) -> Array:
        """(4, 4) pose of an actor of the first environment in the robot base frame."""
        base = self.agent.robot.pose[0].sp.to_transformation_matrix()
        return np.asarray(invert_transform(base) @ actor.pose[0].sp.to_transformation_matrix(), dtype=float)
