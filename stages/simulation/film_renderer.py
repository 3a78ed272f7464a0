"""Pictures of the robot at work, for people: a lit room with a floor, and all of the scene in the picture.

A renderer is a scene of its own; policies never see it. Its Panda has a fifth of its triangles, as software rendering
is bound by vertices; the policy's camera sees one of still fewer.
"""

import hashlib
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
import open3d
import sapien
import trimesh
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation
from sapien.physx import PhysxArticulationLinkComponent as Link
from sapien.render import RenderDirectionalLightComponent as DirectionalLight
from trimesh.bounds import corners

from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.simulation.framing import frame_all, intrinsics_of
from roomkin.stages.simulation.loading import load_asset, move, remove
from roomkin.stages.simulation.rendering import RenderCamera, add_block, cache_folder, instance_id, make_scene
from roomkin.stages.simulation.robot import PANDA
from roomkin.stages.simulation.room import Body, Moment, Recording, TaskRoom

SHARE = 0.2  # of the triangles that are kept; chosen: a film looks the same
CREASE = 0.6  # radians between two faces from which on their edge is sharp; chosen
VERSION = 1  # of what is kept on a machine between runs; to be raised with any change here


@cache
def film_urdf() -> Path:
    """Its URDF; it is made once for an environment, whose meshes it names."""
    known = f"{VERSION} {PANDA} {PANDA.read_text(encoding='utf-8')}"
    folder = cache_folder() / f"panda-film-{hashlib.sha256(known.encode()).hexdigest()[:16]}"
    if not folder.is_dir():
        made = Path(tempfile.mkdtemp(dir=cache_folder()))
        tree = ElementTree.parse(PANDA)
        for mesh in tree.iter("mesh"):
            path = PANDA.parent / str(mesh.get("filename"))
            mesh.set("filename", str(path))
            if path.suffix == ".glb":
                thin_scene(path).export(made / path.name)
                mesh.set("filename", str(folder / path.name))
        (made / "panda.srdf").write_text(PANDA.with_suffix(".srdf").read_text(encoding="utf-8"), encoding="utf-8")
        tree.write(made / "panda.urdf")
        with suppress(OSError):  # another job was faster
            made.rename(folder)
        shutil.rmtree(made, ignore_errors=True)
    return folder / "panda.urdf"


def thin_scene(path: Path) -> trimesh.Scene:
    """The meshes of a file with a share of their triangles, in their materials."""
    scene = trimesh.load_scene(path)
    for name, mesh in scene.geometry.items():
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        corners = open3d.utility.Vector3dVector(np.asarray(mesh.vertices))
        solid = open3d.geometry.TriangleMesh(corners, open3d.utility.Vector3iVector(np.asarray(mesh.faces)))
        solid = solid.simplify_quadric_decimation(max(12, round(SHARE * len(mesh.faces))))
        thin = trimesh.Trimesh(np.asarray(solid.vertices), np.asarray(solid.triangles), process=False)
        thin = trimesh.graph.smooth_shade(thin, angle=CREASE)
        thin.visual = trimesh.visual.TextureVisuals(material=mesh.visual.material)
        scene.geometry[name] = thin
    return scene


Array = NDArray[np.float64]
Image = NDArray[np.uint8]
T = TypeVar("T")

FILM_WIDTH, FILM_ASPECT = 480, 0.75  # pixels; height by width
FINER = 1.5  # pixels that are rendered for one, each way
GLANCE = 120  # pixels: width of the pictures by which a view is chosen
HAND_SHARE = 0.6  # of the parts of the hand are seen: the farther finger may be hidden
HAND_DEPTH = 0.08  # metres from what is seen to the middle of a part of the hand, if that is what is seen
ROOM_MARGIN = 0.15  # metres of a room that are shown about robot and asset
LIT = 2.2  # metres about robot and asset that cast shadows


class FilmRenderer:
    """Takes pictures of episodes. One per process, as the first picture of a scene takes seconds.

    Args:
        light: direction in which the key light shines; usually onto the front of the asset, which faces +x.
        width, height: of the pictures, pixels; height: three quarters of the width unless it is given.
    """

    def __init__(
        self, light: Sequence[float] = (-0.8, -0.45, -1.0), width: int = FILM_WIDTH, height: int | None = None
    ) -> None:
        self.scene = make_scene(light=light)
        parts = [part for entity in self.scene.entities for part in entity.components]
        self.key = next(part for part in parts if isinstance(part, DirectionalLight) and part.shadow)
        self.key.shadow_half_size, self.key.shadow_near, self.key.shadow_far = LIT, -2 * LIT, 2 * LIT
        loader = self.scene.create_urdf_loader()
        loader.fix_root_link = True
        self.robot: PhysxArticulation = loader.load(str(film_urdf()))
        self.size = width, height or round(width * FILM_ASPECT)
        self.aspect = self.size[1] / self.size[0]
        size = round(self.size[0] * FINER), round(self.size[1] * FINER)
        self.camera = RenderCamera(self.scene, intrinsics_of(*size), *size, pack="minimal")
        self.glance = GLANCE, round(GLANCE * self.aspect)
        self.finder = RenderCamera(self.scene, intrinsics_of(*self.glance), *self.glance, pack="minimal")

    def film(self, recording: Recording, frames: int) -> list[Image]:
        """`frames` pictures (H, W, 3), evenly over the recording, from a camera that sees all of it; one per
        moment if there are fewer."""
        moments = pick_evenly(recording.moments, min(frames, len(recording.moments)))
        shot = Shot(self, recording, moments)
        pictures = [shot.picture(moment) for moment in moments]
        shot.close()
        return pictures


class Shot:
    """An episode in a renderer with a fixed camera. Close it before the next one begins.

    Args:
        moments: moments of the episode, or expected ones; the camera is placed so that it shows all of them.
    """

    def __init__(self, renderer: FilmRenderer, recording: Recording, moments: Sequence[Moment]) -> None:
        self.renderer, self.scene, first = renderer, renderer.scene, moments[0]
        pose = sapien.Pose(first.asset)
        self.asset = load_asset(self.scene, recording.folder, pose, True, "asset", recording.scale)
        self.props = [
            load_asset(self.scene, prop.folder, sapien.Pose(pose), True, f"prop_{number}", prop.scale)
            for number, (prop, pose) in enumerate(zip(recording.props, first.props, strict=True))
        ]
        self._put(first)
        feet = [_bounds(self.asset.links), _bounds(renderer.robot.links[:1])]
        low = min(bounds[0, 2] for bounds in feet)
        room = recording.room
        self.about = _in_room(self.scene, room, feet[1]) if room else _add_surroundings(self.scene, feet, low)
        seen = [] if recording.room else [corners(np.array([[*box[0, :2], low], box[1]])) for box in feet]
        for moment in moments:
            self._put(moment)
            seen += [corners(_bounds([link])) for body in (self.asset, renderer.robot) for link in _solid(body.links)]
        points = np.concatenate(seen)
        key = renderer.key.entity
        key.set_pose(sapien.Pose((points.min(axis=0) + points.max(axis=0)) / 2, key.pose.q))
        self.world_from_camera = self._view(recording, points, pick_evenly(moments, 3)[1:])

    def picture(self, moment: Moment) -> Image:
        """(H, W, 3) RGB of a moment."""
        self._put(moment)
        large = self.renderer.camera.render(self.world_from_camera).rgb
        return np.asarray(cv2.resize(large, self.renderer.size, interpolation=cv2.INTER_AREA), np.uint8)

    def close(self) -> None:
        """Take all but the robot out of the renderer."""
        for body in (self.asset, *self.props, *self.about):
            remove(self.scene, body)

    def _view(self, recording: Recording, points: Array, moments: Sequence[Moment]) -> Array:
        """(4, 4) world_from_camera that shows all points (N, 3), the first that shows enough of the hand, or most.

        The asset's front, and so its opening, is always before the camera.
        """
        turn = recording.room.world_from_nominal[:3, :3] if recording.room else np.eye(3)
        best, most = np.eye(4), -1.0
        if recording.room:
            points = np.concatenate([points + offset for offset in corners([[-ROOM_MARGIN] * 3, [ROOM_MARGIN] * 3])])
        places = directions(recording.side)
        if recording.side and not recording.room:  # nothing stands on the side to which a door opens
            places = places[: len(places) // 2]
        for direction in places:
            view, shares = frame_all(points, turn @ direction, self.renderer.aspect), []
            for moment in moments:
                self._put(moment)
                shares.append(self._measure_hand_seen(view))
            if np.mean(shares) > most:
                best, most = view, float(np.mean(shares))
            if most > HAND_SHARE:
                break
        return best

    def _measure_hand_seen(self, view: Array) -> float:
        """The share of the hand's parts that are seen, if anything is of the asset."""
        shown, (width, height) = self.renderer.finder.render(view), self.renderer.glance
        parts = ("panda_hand", "panda_leftfinger", "panda_rightfinger")
        links = [link for link in self.renderer.robot.links if link.name in parts]
        points = transform_points(invert_transform(view), np.array([link.pose.p for link in links], float))
        columns, rows = np.rint((points @ intrinsics_of(width, height).T)[:, :2] / points[:, 2:]).astype(int).T
        depths = shown.depth[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        asset = (shown.segmentation == instance_id(self.asset)).any()
        return float(asset * np.mean((depths == 0) | (depths > points[:, 2] - HAND_DEPTH)))

    def _put(self, moment: Moment) -> None:
        for prop, place in zip(self.props, moment.props, strict=True):
            move(prop, sapien.Pose(place))
        for body, pose, joints in (
            (self.asset, moment.asset, moment.asset_joints), (self.renderer.robot, moment.robot, moment.robot_joints),
        ):  # fmt: skip
            body.set_root_pose(sapien.Pose(pose))
            body.set_qpos(np.array([joints[joint.name] for joint in body.active_joints], np.float32))


def pick_evenly(items: Sequence[T], count: int) -> list[T]:
    """`count` items evenly over an episode, the first and the last included; where there are fewer, some twice."""
    return [items[i] for i in np.linspace(0, len(items) - 1, count).round().astype(int)]


def directions(side: float) -> list[Array]:
    """Unit vectors (3,) from the scene to where a camera may stand, in the asset's frame, the likeliest first: next to
    the robot, where no opened door is in the way; nearer to the front and higher, where more is seen into things."""
    first = 1.0 if side >= 0 else -1.0
    found = [np.array([x, y, z]) for y in (first, -first) for z in (0.45, 0.9) for x in (0.75, 1.5)]
    return [each / np.linalg.norm(each) for each in found]


def _add_surroundings(scene: sapien.Scene, feet: Sequence[Array], low: float) -> list[sapien.Entity]:
    """Floor, wall, and plinths beneath what does not reach the floor."""
    blocks = [_plinth(scene, bounds, low) for bounds in feet if bounds[0, 2] - low > 0.005]
    back = feet[0][0, 0] - 0.03
    blocks.append(add_block(scene, [0, 0, low - 0.05], [24, 24, 0.1], (0.42, 0.29, 0.19), "floor"))
    blocks.append(add_block(scene, [back - 0.05, 0, low + 2], [0.1, 24, 4], (0.36, 0.47, 0.52), "wall"))
    skirting = [back + 0.005, 0, low + 0.045], [0.02, 24, 0.09]
    blocks.append(add_block(scene, *skirting, (0.75, 0.74, 0.72), "skirting"))
    return blocks


def _in_room(scene: sapien.Scene, room: TaskRoom, base: Array) -> list[Body]:
    """The room, and a plinth beneath the robot."""
    plinth = [_plinth(scene, base, 0.0)] if base[0, 2] > 0.005 else []
    return [*room.load(scene).values(), *plinth]


def _solid(links: Sequence[Link]) -> list[Link]:
    return [link for link in links if link.collision_shapes]


def _bounds(links: Sequence[Link]) -> Array:
    """(2, 3) lowest and highest corner of a box around links, in the world."""
    boxes = np.array([link.get_global_aabb_fast() for link in _solid(links)])  # the tight ones err on stretched hulls
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _plinth(scene: sapien.Scene, bounds: Array, floor: float) -> sapien.Entity:
    """A plinth beneath a body that does not reach the floor."""
    size = bounds[1] - bounds[0]
    width = np.minimum(0.92 * size[:2], 0.6)
    center = [*(bounds[0, :2] + bounds[1, :2]) / 2, (bounds[0, 2] + floor) / 2]
    return add_block(scene, center, [*width, bounds[0, 2] - floor], (0.62, 0.60, 0.57), "plinth")
