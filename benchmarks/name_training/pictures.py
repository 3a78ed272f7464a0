"""Pictures of random rooms by rays: true depth, the owner of each pixel, and the level frame."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.name_training.rooms import FLOOR, MadeRoom, triangles
from benchmarks.name_training.solids import Array, Rng, cast_rays, cast_scene
from benchmarks.open_rooms.sensor import find_shadow
from roomkin.stages.config.inputs import DepthNoiseConfig
from roomkin.stages.extraction.noise import noisy_depth, smooth_field
from roomkin.stages.geometry.frames import back_project, look_at, make_intrinsics, make_transform, transform_points
from roomkin.stages.geometry.room_planes import Plane, make_floor_frame

WIDTH, HEIGHT = 320, 240  # pixels
GROUND, BACKGROUND, NOTHING = 0, 1, 255  # in `owner`; things are numbered from 2 on
TOP = 0.02  # metres within which a table's top is the ground
MIN_PIXELS = 48  # pixels: what shows fewer is no thing to learn
AT_TABLE = 0.3  # share of pictures that look at a laid table, if there is one; chosen
NEAREST = 0.35  # metres: no picture shows a tenth of its pixels nearer; chosen


@dataclass(frozen=True)
class TrainingPicture:
    """depth (H, W) metres; cosine (H, W) between ray and surface; owner (H, W) uint8; intrinsics (3, 3);
    frame (4, 4) floor_from_camera, z = 0: what things stand on."""

    depth: Array
    cosine: Array
    owner: NDArray[np.uint8]
    intrinsics: Array
    frame: Array


def pictures_in(room: MadeRoom, views: int, rng: Rng) -> Iterator[TrainingPicture]:
    """At most `views` pictures from random places in a room, none of which is too near to something.

    An owner n of their pixels is `room.things[n - 2]`.
    """
    vertices, faces, owners = triangles(room)
    scene = cast_scene(vertices, faces)
    for _ in range(views):
        eye, target, ground, carrier = _choose_view(room, rng)
        if np.linalg.norm((target - eye)[:2]) < 0.2 or (eye < 0.03).any() or (eye > room.size - 0.03).any():
            continue
        focal = WIDTH * np.exp(rng.uniform(np.log(0.6), np.log(1.25)))
        intrinsics = make_intrinsics(focal, focal, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
        pose = look_at(eye, target)
        pose[:3, :3] = pose[:3, :3] @ Rotation.from_euler("z", rng.normal(0, 0.04)).as_matrix()
        rays = back_project(np.ones((HEIGHT, WIDTH)), intrinsics) @ pose[:3, :3].T
        found = cast_rays(scene, np.concatenate([np.broadcast_to(eye, rays.shape), rays], axis=-1))
        depth = found["t_hit"].numpy().astype(float)
        if np.quantile(depth, 0.1) < NEAREST:
            continue
        normals, owner = found["primitive_normals"].numpy(), owners[found["primitive_ids"].numpy()]
        frame = make_floor_frame(Plane(pose[2, :3], ground - pose[2, 3], np.zeros(0, dtype=bool)))
        heights = transform_points(frame, back_project(depth, intrinsics))[..., 2]
        owner = _choose_owners(room, owner, carrier, np.abs(heights) < TOP)
        cosine = np.abs((rays * normals).sum(axis=-1)) / np.linalg.norm(rays, axis=-1)
        yield TrainingPicture(depth, cosine, owner.astype(np.uint8), intrinsics, frame)


def _choose_view(room: MadeRoom, rng: Rng) -> tuple[Array, Array, float, int]:
    """Where the camera is and what it looks at, (3,) each; the height of what things stand on, and whose top it is."""
    laid = [  # tables: all that they carry stands on their top
        number
        for number, thing in enumerate(room.things, 2)
        if thing.support == FLOOR
        and (feet := [one.position[2] for one in room.things if one.support == number])
        and min(feet) > thing.box.top - TOP
    ]
    if laid and rng.random() < AT_TABLE:
        carrier = int(rng.choice(laid))
        box = room.things[carrier - 2].box
        target = np.array([*box.center[:2], box.top]) + rng.normal(0, [0.15, 0.15, 0.05])
        distance, down, around = rng.uniform(0.5, 1.6), rng.uniform(0.3, 1.15), rng.uniform(0, 2 * np.pi)
        away = np.array([np.cos(down) * np.cos(around), np.cos(down) * np.sin(around), np.sin(down)])
        return target + distance * away, target, box.top, carrier
    height = rng.choice([rng.uniform(0.5, 1.2), rng.normal(1.45, 0.2)])
    eye = np.array([*rng.uniform(0.06, 0.94, 2) * room.size[:2], height])
    target = room.things[int(rng.integers(len(room.things)))].box.center if room.things else room.size / 2
    return eye, 0.7 * target + 0.3 * np.array([*room.size[:2] / 2, 0.8]), 0.0, FLOOR


def _choose_owners(
    room: MadeRoom, owner: NDArray[np.int64], carrier: int, level: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """`Picture.owner` (H, W): beside a table whose top is the ground all that does not stand on it is background.

    `carrier`: FLOOR, or that table; `level`: (H, W) pixels at the height of the ground.
    """
    shown = owner.copy()
    if carrier != FLOOR:
        kept = [number for number, thing in enumerate(room.things, 2) if thing.support == carrier]
        shown = np.where(np.isin(owner, kept), owner, BACKGROUND)
        shown[(owner == carrier) & level] = GROUND
    values, counts = np.unique(shown, return_counts=True)
    shown[np.isin(shown, values[(counts < MIN_PIXELS) & (values > BACKGROUND)])] = NOTHING
    return shown


TILT, OFF = 1.7, 0.025  # degrees and share of the camera's height by which the level frame errs; chosen


def sense_depth(picture: TrainingPicture, rng: Rng) -> Array:
    """Depth (H, W) as stereo, structured light, time of flight or a network measures it, metres; 0: unknown."""
    noise = DepthNoiseConfig(range_constant=0.001, range_quadratic=0.004 * rng.random() ** 2, scale=0.008)
    depth = noisy_depth(picture.depth.astype(np.float32), noise, rng).astype(float)
    lost = (depth < rng.uniform(0.2, 0.5)) | (depth > rng.choice([4.5, 8.0, 20.0]))
    lost |= picture.cosine < rng.uniform(0.0, 0.3)
    lost |= find_shadow(picture.depth, rng.uniform(0.0, 10.0))
    lost |= smooth_field((depth.shape[0], depth.shape[1]), rng.uniform(4, 24), rng) > rng.uniform(1.2, 4.0)  # glossy
    lost |= rng.random(depth.shape) < rng.choice([0.0, 0.002, 0.02])
    return np.where(lost, 0.0, depth)


def tilt_frame(frame: Array, rng: Rng) -> Array:
    """`floor_from_camera` (4, 4) with the error of an estimate: degrees, and a share of the camera's height."""
    x, y = np.deg2rad(rng.normal(0, TILT, 2))
    turn = np.array([[1, 0, y], [0, 1, -x], [-y, x, 1]])
    left, _, right = np.linalg.svd(turn)
    return np.asarray(make_transform(left @ right, [0, 0, rng.normal(0, OFF) * frame[2, 3]]) @ frame)
