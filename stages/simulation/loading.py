"""Put asset folders into a SAPIEN scene: articulated ones as articulations, the others as rigid actors."""

import hashlib
import tempfile
from collections.abc import Sequence
from copy import copy
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.articulated.resizing import resize_model
from roomkin.stages.articulated.urdf_writer import DAMPING, FRICTION, SURFACE_FRICTION, write_urdf
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.geometry.frames import yaw_matrix, yaw_quaternion
from roomkin.stages.simulation.rendering import has_renderer
from roomkin.stages.simulation.stretching import stretch_builder

_NUMBERS = count()  # of bodies


def physics_scene(timestep: float = 0.01) -> sapien.Scene:
    """A scene with CPU physics alone. It needs no Vulkan device; assets load without visuals."""
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    scene.timestep = timestep
    return scene


def box_center(asset: Asset) -> NDArray[np.float64]:
    """Center of the closed box in the asset frame."""
    return (np.array(asset.box_min) + np.array(asset.box_max)) / 2


def root_pose(asset: Asset, position: Sequence[float], yaw: float, scale: float = 1.0) -> sapien.Pose:
    """Pose of the URDF root that puts the closed box's center at `position`, turned by `yaw` about z."""
    return sapien.Pose(np.asarray(position) - scale * yaw_matrix(yaw) @ box_center(asset), yaw_quaternion(yaw))


class ParsedAsset:
    """An asset that a URDF loader has read once; its body can be built many times, at any scale.

    Args:
        loader: SAPIEN's URDF loader, or ManiSkill's around it.
        folder: of the asset; or of a URDF alone, with the asset that it is.
        fixed: the base does not move (a cabinet screwed to the wall); doors and drawers still do.
    """

    def __init__(self, loader: Any, folder: Path, fixed: bool, asset: Asset | None = None) -> None:
        self.folder, self.fixed, self._loader = Path(folder), fixed, loader
        self.asset = asset or read_asset(folder)
        self._builder = self._parse(self.folder.resolve() / self.asset.urdf)

    def builder(self, scale: NDArray[np.float64] | None = None) -> Any:
        """A builder of the body; `scale` (3,) stretches it along the asset's axes.

        It works in memory. Shapes askew to the axes are stretched in files that are kept until the process ends.
        """
        body, number = self._resize(scale), next(_NUMBERS) % 0xFFFF + 1
        for link in getattr(body, "link_builders", []):
            # SAPIEN compares the bits of an SRDF within bodies of one number. The robot's is 0: its fingers would pass
            # through whatever door has the same bit.
            link.collision_groups = [*link.collision_groups[:3], number]
        return body

    def _resize(self, scale: NDArray[np.float64] | None) -> Any:
        if scale is None or (scale == 1).all():
            return copy(self._builder)
        ready = stretch_builder(self._builder, scale)
        if ready is not None:
            return ready
        size = tuple((np.array(self.asset.size) * scale).tolist())
        folder = Path(_scratch().name) / hashlib.sha256(f"{self.folder.resolve()}{size}".encode()).hexdigest()[:16]
        if not folder.exists():
            write_urdf(resize_model(self.folder, self.asset, size, by_recipe=False).robot, folder)
        return self._parse(folder / self.asset.urdf)

    def _parse(self, urdf: Path) -> Any:
        self._loader.fix_root_link = self.fixed
        self._loader.set_material(SURFACE_FRICTION, SURFACE_FRICTION, 0.0)
        try:
            parsed = self._loader.parse(str(urdf))
        except Exception as error:  # the loader raises whatever its XML and mesh readers raise
            what = f"cannot be loaded: {str(error).splitlines()[0]}."
            raise ObjectError(urdf, what, code="E-MODEL-BROKEN") from error
        names = ("articulation_builders", "actor_builders") if isinstance(parsed, dict) else (0, 1)
        bodies = [*parsed[names[0]], *parsed[names[1]]]
        if len(bodies) != 1:
            raise ObjectError(urdf, f"holds {len(bodies)} separate bodies.", "one body per URDF", code="E-MODEL-BODIES")
        return bodies[0]


@cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="acdc-stretched-")


def load_visual(scene: sapien.Scene, folder: Path, scale: float) -> PhysxArticulation | sapien.Entity:
    """Add the visuals of an asset, closed and scaled; it is fixed and collides with nothing."""
    loader = scene.create_urdf_loader()
    loader.scale = scale
    builder = ParsedAsset(loader, folder, fixed=True).builder()
    for link in getattr(builder, "link_builders", [builder]):
        link.collision_records.clear()
    builder.initial_pose = sapien.Pose()
    if not hasattr(builder, "link_builders"):
        builder.set_physx_body_type("kinematic")
        return builder.build()
    return close_joints(builder.build())


def load_asset(
    scene: sapien.Scene,
    folder: Path,
    pose: sapien.Pose,
    fixed: bool,
    name: str,
    scale: NDArray[np.float64] | None = None,
    asset: Asset | None = None,
) -> PhysxArticulation | sapien.Entity:
    """Add an asset to a scene, closed.

    Args:
        pose: of the URDF root; see `root_pose`.
        fixed: the base does not move (a cabinet screwed to the wall); doors and drawers still do.
        scale: (3,) factors along the asset's axes.
        asset: what the folder is, where it holds a URDF alone.

    Returns:
        An articulation if the URDF has joints, else an entity (kinematic if fixed).
    """
    parsed = ParsedAsset(scene.create_urdf_loader(), folder, fixed, asset)
    builder = parsed.builder(scale)
    builder.initial_pose = pose
    if not has_renderer(scene):
        for link in getattr(builder, "link_builders", [builder]):
            link.visual_records.clear()
    if not hasattr(builder, "link_builders"):
        builder.set_name(name)
        builder.set_physx_body_type("kinematic" if fixed else "dynamic")
        return builder.build()
    articulation = builder.build()
    articulation.set_name(name)
    names = [joint.name for joint in articulation.get_active_joints()]
    set_joint_dynamics(articulation, parsed.asset, names)
    return close_joints(articulation)


def close_joints(articulation: PhysxArticulation) -> PhysxArticulation:
    """The articulation with every joint at its lower limit."""
    lower = [float(joint.limits[0][0]) for joint in articulation.get_active_joints()]
    articulation.set_qpos(np.array(lower, dtype=np.float32))
    return articulation


def set_joint_dynamics(articulation: PhysxArticulation, asset: Asset, names: Sequence[str]) -> None:
    """Give every joint the friction and damping of our URDFs, which SAPIEN's loader ignores, and its part's spring.

    `names`: of its active joints in the URDF; ManiSkill calls them otherwise.
    """
    springs = {joint.name: PARTS[joint.part_type].spring for joint in asset.joints}
    for joint, name in zip(articulation.get_active_joints(), names, strict=True):
        joint.set_friction(FRICTION)
        joint.set_drive_properties(stiffness=springs.get(name, 0.0), damping=DAMPING)
        if joint.stiffness:
            joint.set_drive_target(float(joint.limits[0][0]))


def move(body: PhysxArticulation | sapien.Entity, pose: sapien.Pose) -> None:
    """Put the URDF root at a pose."""
    if isinstance(body, PhysxArticulation):
        body.set_root_pose(pose)
    else:
        body.set_pose(pose)


def measure_bounds(body: PhysxArticulation | sapien.Entity) -> NDArray[np.float64]:
    """(2, 3) lowest and highest corner of the box around the visuals of a body, world frame."""
    entities = [link.entity for link in body.links] if isinstance(body, PhysxArticulation) else [body]
    shown = [
        part for each in entities for part in each.components if isinstance(part, sapien.render.RenderBodyComponent)
    ]
    boxes = np.array([part.compute_global_aabb_tight() for part in shown], dtype=float)
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def remove(scene: sapien.Scene, body: PhysxArticulation | sapien.Entity) -> None:
    """Take an asset out of the scene."""
    if isinstance(body, PhysxArticulation):
        scene.remove_articulation(body)
    else:
        scene.remove_actor(body)
