"""Pictures from SAPIEN's rasteriser: color, metric depth and one instance id per object."""

import hashlib
import os
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
import sapien
from numpy.typing import ArrayLike, NDArray
from sapien.physx import PhysxArticulation, PhysxArticulationLinkComponent

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import SAPIEN_FROM_OPENCV, quaternion_from_matrix

Pack = Literal["default", "minimal"]
TABLE = re.compile(r"^layout\(.*\) uniform sampler2D samplerBRDFLUT;$", re.MULTILINE)
READ = re.compile(r"texture\(samplerBRDFLUT, [^;]*\)\.xy;")
SKY = re.compile(r"textureLod\(samplerEnvironment, [^;]*\)\.rgb;")
FORMATS: dict[Pack, tuple[str, str]] = {
    "default": ("r32g32b32a32sfloat", "r32g32b32a32sfloat"),
    "minimal": ("r8g8b8a8unorm", "r16g16b16a16sint"),
}


def cache_folder() -> Path:
    """Where generated files are kept between runs; a temporary folder if the home is not writable."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = home / "roomkin"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    return folder if writable else Path(tempfile.gettempdir()) / "roomkin"


def keep(folder: Path, files: dict[str, str]) -> Path:
    """Write generated files below `folder` unless they are there; two jobs may come here at once."""
    for name, text in files.items():
        file = folder / name
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.parent.mkdir(parents=True, exist_ok=True)
            own = file.with_name(f"{os.getpid()}-{file.name}")
            own.write_text(text, encoding="utf-8")
            own.replace(file)
    return folder


def use(pack: Pack) -> None:
    """The next cameras are made with a pack: `default` (color and positions as floats), or `minimal`, thrice as fast
    (color as bytes, positions and segmentation as 16 bit integers, millimetres)."""
    sapien.render.set_camera_shader_dir(make_skyless_pack(pack))
    color, position = FORMATS[pack]
    for name, texture in (("Color", color), ("ColorRaw", color), ("PositionSegmentation", position)):
        sapien.render.set_picture_format(name, texture)


@cache
def make_skyless_pack(pack: str) -> str:
    """Folder of the shader pack without the table and the sky; the pack's own name if it is not as we know it."""
    shipped = Path(sapien.__file__).parent / "vulkan_shader"
    files = {
        f"{part}/{path.name}": path.read_text(encoding="utf-8")
        for part in (pack, "common")
        for path in sorted((shipped / part).iterdir())
    }
    changed = {name: SKY.sub("vec3(0.0);", READ.sub("vec2(0.0);", TABLE.sub("", text))) for name, text in files.items()}
    if changed == files or any("samplerBRDFLUT" in text for text in changed.values()):
        return pack
    digest = hashlib.sha256("\0".join(changed.values()).encode()).hexdigest()[:16]
    return str(keep(cache_folder() / f"shaders-{digest}", changed) / pack)


BACKGROUND = np.array([209, 209, 214], np.uint8)  # where nothing is
SHADED, LIGHTS_BEFORE = 8.0, 2.0  # metres: default radius of what casts shadows, and depth of the map beyond it
_alive: list[sapien.Scene] = []  # the last scene made; while one lives, the next need not compile shaders again (0.1 s)


def render_backend() -> Literal["cpu", "gpu"]:
    """Where a process renders: all its scenes, ManiSkill's too, must be on one device."""
    try:
        sapien.Device("cuda")
    except RuntimeError:
        return "cpu"
    return "gpu"


@dataclass(frozen=True)
class RenderedImage:
    """rgb (H, W, 3) uint8; depth (H, W) float32 metres along the optical axis, 0: nothing there;
    segmentation (H, W) int32 of `instance_id`, 0: nothing there."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    segmentation: NDArray[np.int32]


def make_scene(
    shadows: bool = True,
    light: Sequence[float] = (-0.5, -0.6, -1.0),
    shaded: tuple[Sequence[float], float] = ((0.0, 0.0, 0.0), SHADED),
) -> sapien.Scene:
    """A scene with CPU physics, a renderer, and one key light, one fill light and ambient light.

    Args:
        light: direction in which the key light shines, world frame.
        shaded: center (3,) and radius, metres, of the region that casts shadows.

    Raises:
        InputError: there is no Vulkan device to render with.
    """
    try:
        sapien.render.set_log_level("error")
        device = [sapien.Device("cpu")] if render_backend() == "cpu" else []  # none: SAPIEN takes the GPU
        renderer = sapien.render.RenderSystem(*device)
    except RuntimeError as error:
        what = f"no Vulkan device ({error})."
        raise InputError("renderer", what, "roomkin check", code="E-RENDERER-MISSING") from None
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem(), renderer])
    scene.timestep = 0.01
    scene.set_ambient_light([0.42, 0.42, 0.44])
    key = np.asarray(light, dtype=float)
    center, radius = shaded
    scene.add_directional_light(
        key.tolist(), [1.55, 1.5, 1.42], shadow=shadows, position=list(center), shadow_scale=radius,
        shadow_near=-radius - LIGHTS_BEFORE, shadow_far=radius + LIGHTS_BEFORE, shadow_map_size=2048,
    )  # fmt: skip
    scene.add_directional_light([-key[0], -key[1], -1.4], [0.35, 0.37, 0.42])
    _alive[:] = [scene]
    return scene


def instance_id(body: PhysxArticulation | sapien.Entity) -> int:
    """The id that all pixels of an object carry in `RenderedImage.segmentation`."""
    entity = body.links[0].entity if isinstance(body, PhysxArticulation) else body
    return int(entity.per_scene_id)


class RenderCamera:
    """A pinhole camera of a scene. Moving one camera is faster than keeping many (docs/assets.md)."""

    def __init__(
        self, scene: sapien.Scene, intrinsics: ArrayLike, width: int, height: int, pack: Pack = "default"
    ) -> None:
        """`intrinsics`: 3x3 matrix K in pixels, pixel centers at integers. `pack`: see `shaders.use`; with `minimal`
        depth is cut off to millimetres, and nothing may be farther than 32 m."""
        use(pack)
        k = np.asarray(intrinsics, dtype=float)
        self._pack = pack
        self.scene = scene
        self._component = sapien.render.RenderCameraComponent(width, height)
        # SAPIEN counts pixel centers at half integers
        near, far = 0.02, 60.0  # metres
        self._component.set_perspective_parameters(near, far, k[0, 0], k[1, 1], k[0, 2] + 0.5, k[1, 2] + 0.5, k[0, 1])
        self._entity = sapien.Entity()
        self._entity.name = "camera"
        self._entity.add_component(self._component)
        scene.add_entity(self._entity)

    def render(self, world_from_camera: ArrayLike) -> RenderedImage:
        """Picture from a 4x4 pose of the camera, OpenCV axes."""
        pose = np.asarray(world_from_camera, dtype=float)
        rotation = pose[:3, :3] @ SAPIEN_FROM_OPENCV.T
        self._entity.set_pose(sapien.Pose(pose[:3, 3], quaternion_from_matrix(rotation)))
        self.scene.update_render()
        self._component.take_picture()
        color = self._component.get_picture("Color")
        if self._pack == "minimal":
            position = self._component.get_picture("PositionSegmentation")
            entities, forward = position[..., 3].astype(np.int32), position[..., 2] * np.float32(-0.001)
        else:
            forward = -self._component.get_picture("Position")[..., 2]
            entities = self._component.get_picture("Segmentation")[..., 1].astype(np.int32)
            color = (np.clip(color, 0.0, 1.0) * 255).round().astype(np.uint8)
        seen = entities > 0
        depth = np.where(seen, forward, np.float32(0))
        rgb = np.ascontiguousarray(color[..., :3])
        rgb[~seen] = BACKGROUND
        return RenderedImage(rgb, depth, self._instances(entities))

    def close(self) -> None:
        """Take the camera out of the scene."""
        self.scene.remove_entity(self._entity)

    def _instances(self, entities: NDArray[np.int32]) -> NDArray[np.int32]:
        """Ids of links -> id of their articulation."""
        table = np.arange(max(int(entities.max()), max((e.per_scene_id for e in self.scene.entities), default=0)) + 1)
        for entity in self.scene.entities:
            link = entity.find_component_by_type(PhysxArticulationLinkComponent)
            if link is not None:
                table[entity.per_scene_id] = instance_id(link.articulation)
        return table.astype(np.int32)[entities]


def add_block(
    scene: sapien.Scene,
    center: Sequence[float],
    size: Sequence[float],
    color: Sequence[float],
    name: str,
    yaw: float = 0.0,
    roughness: float = 0.9,
) -> sapien.Entity:
    """A kinematic box: floor, wall. Its extents are `size`, its surface one color (if the scene shows anything)."""
    half = (np.asarray(size, dtype=float) / 2).tolist()
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=half)
    if has_renderer(scene):
        material = sapien.render.RenderMaterial()
        material.base_color = [*color, 1.0]
        material.roughness, material.specular = roughness, 0.1
        builder.add_box_visual(half_size=half, material=material)
    builder.initial_pose = sapien.Pose(list(center), [np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
    return builder.build_kinematic(name)


def has_renderer(scene: sapien.Scene) -> bool:
    """Whether the scene has a renderer."""
    try:
        return scene.render_system is not None
    except RuntimeError:
        return False
