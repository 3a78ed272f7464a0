"""Models as a room may show them: any light, colours, proportions, camera height, distance and place in the picture."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation

from stages.articulated.asset_folder import read_asset
from stages.geometry.cameras import look_at
from stages.geometry.frames import inverse, rigid, yaw_matrix, yaw_quaternion
from stages.matching.crop import View
from stages.simulation.loading import box_centre, load_looks, move, remove
from stages.simulation.rendering import RenderCamera, make_scene

Array = NDArray[np.float64]
Rng = np.random.Generator

SIDE = 224  # pixels of a picture
RADIUS = 4.0  # metres: half the diagonal of every model before these cameras, which measure whole millimetres
DISTANCES = (2.2, 6.5)  # of the cameras, in radii
OFF_AXIS = 0.44  # radians between the optical axis and the model, at most
ELEVATIONS = (0.05, 0.8)  # radians
STRETCH = 0.22  # logarithm of the largest factor per axis


@dataclass(frozen=True)
class Shot:
    """A picture of a model, and `object_from_camera` (4, 4): affine map from the camera frame to the asset's axes at
    the centre of its box, unstretched, in units of its largest extent."""

    view: View
    object_from_camera: Array


@dataclass
class ChanceStudio:
    """One scene in which models are photographed by chance; made once per process."""

    cameras: int = 10
    _cameras: list[tuple[RenderCamera, Array, Array, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.scene = make_scene(shadows=True)
        self.scene.add_directional_light([0, 0, -1], [0, 0, 0])
        self._lights = [
            component
            for entity in self.scene.entities
            for component in entity.components
            if isinstance(component, sapien.render.RenderDirectionalLightComponent)
        ]
        rng = np.random.default_rng(0)  # the cameras are always the same, their places are not
        for distance in np.linspace(*DISTANCES, self.cameras):
            self._cameras.append(self._camera(distance, rng))

    def _camera(self, distance: float, rng: Rng) -> tuple[RenderCamera, Array, Array, float]:
        """A camera for models at a distance (radii) and off its axis: its image is moved so that they are in it."""
        focal = rng.uniform(0.5, 0.95) * SIDE / 2 * np.sqrt(distance**2 - 1)
        angle, around = OFF_AXIS * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
        towards = np.array([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)])
        middle = (SIDE - 1) / 2 - focal * towards[:2] / towards[2]
        intrinsics = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
        return RenderCamera(self.scene, intrinsics, SIDE, SIDE, pack="minimal"), intrinsics, towards, distance

    def photograph(self, folder: Path, yaws: list[float], rng: Rng, painted: float) -> list[Shot]:
        """Pictures of a model at given turns, in two proportions; a share `painted` of them in plain colours."""
        shots = []
        for part in np.array_split(np.array(yaws), min(2, len(yaws))):
            stretch = np.exp(rng.uniform(-STRETCH, STRETCH, 3))
            shots += self._photograph(folder, part.tolist(), stretch, rng, painted)
        return shots

    def _photograph(self, folder: Path, yaws: list[float], stretch: Array, rng: Rng, painted: float) -> list[Shot]:
        asset = read_asset(folder)
        scale = 2 * RADIUS / float(np.linalg.norm(stretch * np.array(asset.size)))
        body = load_looks(self.scene, folder, scale, stretch)
        materials = _materials(body)
        looks = [Looks(material) for material in materials]
        shots = []
        for yaw in yaws:
            if rng.random() < painted:
                paint(looks, rng)
            self._light(rng)
            turn = yaw_matrix(yaw)
            move(body, sapien.Pose(-turn @ (scale * stretch * box_centre(asset)), yaw_quaternion(yaw)))
            camera, intrinsics, towards, distance = self._cameras[int(rng.integers(len(self._cameras)))]
            pose = _aim_camera(rng.uniform(*ELEVATIONS), distance * RADIUS * rng.uniform(0.95, 1.1), towards)
            picture = camera.render(pose)
            unit = scale * stretch * max(asset.size)
            affine = np.eye(4)
            affine[:3] = (turn.T @ pose[:3]) / unit[:, None]
            mask = picture.depth > 0
            view = View(picture.rgb, mask, picture.depth, intrinsics, pose[2, :3].copy())
            shots.append(Shot(view, affine))
            for each in looks:
                each.restore()
        remove(self.scene, body)
        return shots

    def _light(self, rng: Rng) -> None:
        """One to three lights from above and some ambient light, all more or less white."""
        used = int(rng.integers(1, len(self._lights) + 1))
        tint = 1 + rng.uniform(-0.12, 0.12, 3)
        self.scene.set_ambient_light((rng.uniform(0.15, 0.6) * tint).tolist())
        for number, light in enumerate(self._lights):
            strength = rng.uniform(0.5, 2.0) / used if number < used else 0.0
            direction = np.array([*rng.normal(size=2), -rng.uniform(0.2, 1.5)])
            light.set_color((strength * tint).tolist())
            rotation = sapien.math.shortest_rotation([1, 0, 0], (direction / np.linalg.norm(direction)).tolist())
            light.entity.set_pose(sapien.Pose([0, 0, 0], rotation))


def _aim_camera(elevation: float, distance: float, towards: Array) -> Array:
    """(4, 4) world_from_camera, OpenCV axes, of a camera that sees the origin in the direction `towards` (3,)."""
    eye = distance * np.array([np.cos(elevation), 0.0, np.sin(elevation)])
    straight = look_at(eye, [0.0, 0.0, 0.0])[:3, :3]
    axis = np.cross([0, 0, 1.0], towards)
    sine, cosine = float(np.linalg.norm(axis)), float(towards[2])
    k = axis / max(sine, 1e-9)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    turn = np.eye(3) + sine * cross + (1 - cosine) * cross @ cross  # Rodrigues: turns the axis towards the model
    return rigid(straight @ turn.T, eye)


def _materials(body: PhysxArticulation | sapien.Entity) -> list[sapien.render.RenderMaterial]:
    entities = [link.entity for link in body.links] if isinstance(body, PhysxArticulation) else [body]
    shapes = [
        shape
        for entity in entities
        for component in entity.components
        if isinstance(component, sapien.render.RenderBodyComponent)
        for shape in component.render_shapes
    ]
    return [part.material for shape in shapes for part in shape.parts]


class Looks:
    """A material, and what it was at first."""

    def __init__(self, material: sapien.render.RenderMaterial) -> None:
        self.material = material
        self.colour = tuple(float(channel) for channel in material.base_color)
        self.texture, self.roughness = material.base_color_texture, material.roughness

    def restore(self) -> None:
        """As it was."""
        self.material.set_base_color(list(self.colour))
        self.material.set_base_color_texture(self.texture)
        self.material.set_roughness(self.roughness)


def paint(looks: list[Looks], rng: Rng) -> None:
    """Plain paint: what looked the same gets one colour, or (one time in four) every part its own."""
    apart, drawn = rng.random() < 0.25, {}
    for number, each in enumerate(looks):
        key = (number if apart else id(each.texture) if each.texture else None, each.colour)
        if key not in drawn:
            grey = rng.uniform(0.03, 0.9)
            tinted = np.clip(grey * (1 + rng.uniform(0, 0.6) * rng.uniform(-1, 1, 3)), 0.01, 1.0)
            drawn[key] = [*tinted.tolist(), 1.0], float(rng.uniform(0.3, 1.0))
        colour, roughness = drawn[key]
        each.material.set_base_color_texture(None)
        each.material.set_base_color(colour)
        each.material.set_roughness(roughness)


def camera_from_object(camera: Array, yaw: float) -> Array:
    """(4, 4) from the asset's centred axes, in largest extents, to the camera of a snapshot: `camera` is its
    world_from_camera in the same units, and the asset is turned by `yaw` before it."""
    return np.asarray(inverse(camera) @ rigid(yaw_matrix(yaw), np.zeros(3)))
