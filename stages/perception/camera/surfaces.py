"""Ground, walls and ceiling of a picture with depth, by geometry alone, before anything is named.

A wall is an upright plane of some area that reaches high and behind which, as wide as it is, hardly anything lies.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import back_project, transform_points
from roomkin.stages.geometry.levels import find_ground
from roomkin.stages.geometry.room_planes import (
    CELLS,
    GRAZING,
    LEVEL,
    PLANE_THRESHOLD,
    WALL_TILT,
    WallPlane,
    cell_normals,
    fit_wall,
    make_floor_frame,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
STEP, NEAR = 0.02, 11  # metres between planes that are tried, and how many of them are one; chosen
MIN_WALL = 0.4  # square metres of flat cells that are seen of a wall: few of a far one are flat; chosen on `work`
TOP = 1.5  # metres above the ground to which a wall reaches; chosen
MAX_SHARE_BEHIND = 0.12  # of what is seen within a wall's width: doors, windows, mirrors; chosen
FARTHER = 0.25  # metres: what is farther behind a plane is behind it, not its noise; chosen
ALONG = np.cos(np.deg2rad(25))  # of a surface's normal with its wall's: brick and noise are allowed for; chosen
MIN_OFF, NOISE = 0.015, 0.006  # metres, and of the distance squared, 1 / metres: points are off planes; chosen
DEEPEST = 1.0  # metres from the front of furniture to its wall; chosen
MIN_CEILING = 1.9, 8  # metres from the ground to a ceiling, and cells that show it; chosen


@dataclass(frozen=True)
class Surfaces:
    """Ground, walls and ceiling of a room.

    Attributes:
        frame: floor_from_camera (4, 4), z = 0 on the ground.
        points: (H, W, 3) of the pixels, floor frame.
        below: share of the points that lie below the ground.
        ground: (H, W) the pixels on it; `floor`: with what lies below it.
        walls: planes in the floor frame, largest first; `wall_masks` (H, W): the pixels on each.
        beyond: (H, W) what is on a wall or behind it, or on the ceiling or above it.
    """

    frame: Array
    points: Array
    below: float
    ground: Mask
    floor: Mask
    walls: list[WallPlane]
    wall_masks: list[Mask]
    beyond: Mask

    @property
    def on_wall(self) -> Mask:
        """(H, W) what is on any wall."""
        return np.asarray(np.any([np.zeros_like(self.floor), *self.wall_masks], axis=0))


def find_surfaces(depth: Array, intrinsics: Array, max_tilt: float, frame: Array | None = None) -> Surfaces | None:
    """Ground, walls and ceiling; None: no surface tells which way is up, or nothing level lies below the camera.

    Args:
        depth: (H, W) metres, 0: unknown.
        intrinsics: (3, 3) pixels.
        max_tilt: largest angle between image-up and the ground's normal, degrees.
        frame: floor_from_camera (4, 4), if that is known.
    """
    in_camera, known = back_project(depth, intrinsics), depth > 0
    if frame is None and (ground := find_ground(in_camera, known, max_tilt)) is not None:
        frame = make_floor_frame(ground)
    if frame is None:
        return None
    points = transform_points(frame, in_camera)
    off = np.maximum(MIN_OFF, NOISE * depth**2)
    floor = known & (points[..., 2] < off)
    on_ground = floor & (points[..., 2] > -off)
    centers, normals = cell_normals(in_camera, known)
    cells, facing = transform_points(frame, centers), normals @ frame[:3, :3].T
    sight = np.abs((normals * centers).sum(axis=1)) / centers[:, 2]  # cosine between both, at the optical axis
    side = depth.shape[1] // CELLS / intrinsics[0, 0] * centers[:, 2]
    walls = find_walls(points[known], cells, facing, side**2 / np.maximum(sight, GRAZING), float(frame[2, 3]))
    wall_masks, beyond = [], find_ceiling(points, cells, facing, off) & known
    for wall in walls:
        distance = points @ wall.normal - wall.offset
        wall_masks.append(known & ~floor & ~beyond & (np.abs(distance) < off))
        beyond |= known & ~floor & (distance < off)
    below = float((points[known][:, 2] < -FARTHER).mean())
    return Surfaces(frame, points, below, on_ground, floor, walls, wall_masks, beyond)


def find_walls(points: Array, cells: Array, facing: Array, areas: Array, camera_height: float) -> list[WallPlane]:
    """The walls, largest first: in each of the room's four directions at most one.

    Args:
        points: (N, 3) of all that is seen, floor frame.
        cells, facing, areas: of flat cells: centers (M, 3), unit normals (M, 3) towards the camera, square metres (M,).
        camera_height: metres above the ground.
    """
    upright = (np.abs(facing[:, 2]) < WALL_TILT) & (cells[:, 2] > PLANE_THRESHOLD)
    cells, facing, areas = cells[upright], facing[upright], areas[upright]
    if not len(cells):
        return []
    angles = np.arctan2(facing[:, 1], facing[:, 0])
    around = np.histogram(np.mod(angles, np.pi / 2), 90, (0, np.pi / 2), weights=areas)[0]
    smooth = np.convolve(np.r_[around[-3:], around, around[:3]], np.ones(7), "valid")
    first = (np.argmax(smooth) + 0.5) * np.pi / 180
    found = []
    for angle in first + np.arange(4) * np.pi / 2:
        normal = np.array([np.cos(angle), np.sin(angle), 0.0])
        along = facing @ normal > ALONG
        found.append(find_wall(points, cells[along], areas[along], normal, camera_height))
    return sorted((wall for wall in found if wall), key=lambda wall: -wall.inliers)


def find_wall(points: Array, cells: Array, areas: Array, normal: Array, camera_height: float) -> WallPlane | None:
    """The largest plane of a direction that is a wall; None: none is.

    Args:
        points: (N, 3) of all that is seen, floor frame.
        cells, areas: (M, 3), (M,) of the cells that face about along `normal` (3,).
        camera_height: metres above the ground.
    """
    offsets = cells @ normal
    if not (offsets < -FARTHER).any():
        return None  # the camera, at x = y = 0, is in front of a wall
    edges = np.arange(offsets.min() - STEP, -FARTHER + STEP, STEP)
    area = np.convolve(np.histogram(offsets, edges, weights=areas)[0], np.ones(NEAR), "same")
    found = None
    for at in find_peaks(area, MIN_WALL / 2):
        near = points[np.abs(points @ normal - edges[at]) < FARTHER]
        wall = fit_wall(near, camera_height, np.random.default_rng(0))
        if wall is None or wall.normal @ normal < ALONG or not is_wall(wall, points, cells, areas):
            continue
        if found is None or found.offset - DEEPEST < wall.offset < found.offset:
            found = wall  # what stood before it is furniture
    return found


def find_peaks(values: Array, least: float) -> list[int]:
    """Places of the largest values (N,), at least `least`, no two nearer than `NEAR`."""
    found = list[int]()
    for at in np.argsort(-values, kind="stable"):
        if values[at] < least:
            break
        if all(abs(at - other) > NEAR for other in found):
            found.append(int(at))
    return found


def is_wall(wall: WallPlane, points: Array, cells: Array, areas: Array) -> bool:
    """Whether a plane has a wall's area and height, and hardly anything behind it; see `find_wall`."""
    seen, across = points @ wall.normal - wall.offset, points @ np.array([-wall.normal[1], wall.normal[0], 0.0])
    off, cells_off = (np.maximum(PLANE_THRESHOLD, NOISE * (some[:, :2] ** 2).sum(axis=1)) for some in (points, cells))
    on = np.abs(seen) < off
    area = areas[np.abs(cells @ wall.normal - wall.offset) < 2 * cells_off].sum()
    if area < MIN_WALL or np.quantile(points[on, 2], 0.97) < TOP:
        return False
    left, right = np.quantile(across[on], [0.03, 0.97])
    within = (across > left) & (across < right) & (points[:, 2] > off)
    return bool((within & (seen < -FARTHER)).sum() < MAX_SHARE_BEHIND * within.sum())


def find_ceiling(points: Array, cells: Array, facing: Array, off: Array) -> Mask:
    """Pixels (H, W) of the level surface that faces down, and of what lies above it; no pixel: none is seen."""
    least, fewest = MIN_CEILING
    high = (facing[:, 2] < -LEVEL) & (cells[:, 2] > least)
    if high.sum() < fewest:
        return np.zeros(off.shape, dtype=bool)
    return np.asarray(points[..., 2] > float(np.median(cells[high, 2])) - off)
