"""Paths of the hand, and clearance on them: spheres on arm and hand against points on the surfaces around."""

import itertools
from collections.abc import Sequence
from copy import copy

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from roomkin.stages.geometry.solids import sample_triangles, split_solids
from roomkin.stages.simulation.kinematics import Array, pose_error
from roomkin.stages.simulation.target import Target

SURFACE_POINTS = 20_000  # on either part of an object: one about every centimetre on a cabinet; chosen for time
INNER_POINTS = 500  # within each of their convex pieces; chosen for time
CLEARANCE = 0.005  # metres of air between the arm and what it must not touch; chosen

# Spheres around the meshes of Franka's Panda: frame, center in that frame, radius; metres. Frame j is that of joint
# j + 1, -1 the tool center point. Fingers move with their joints: y is outwards of the pad.
ARM = np.array(
    [
        (3, 0.0, 0.0, 0.0, 0.07),
        (4, 0.0, 0.03, -0.22, 0.06),
        (4, 0.0, 0.05, -0.14, 0.05),
        (4, 0.0, 0.05, -0.06, 0.05),
        (5, 0.0, 0.0, 0.0, 0.065),
        (5, 0.08, 0.0, 0.0, 0.055),
        (6, 0.0, 0.0, 0.05, 0.055),
        *((-1, 0.0, y, -0.08, 0.028) for y in (-0.075, -0.045, -0.015, 0.015, 0.045, 0.075)),
    ]
)
FINGER = np.array([(-1, 0.0, y, z, 0.0075) for y, z in ((0.0076, 0.002), (0.0076, -0.012), (0.013, -0.03))])
BASE = np.array([(x, 0.0, z, 0.11) for x in (-0.09, 0.02) for z in (0.08, 0.18, 0.28)])  # link 0, shoulder; base frame


class Surroundings:
    """Points on the fixed and the moving part of an object, and on obstacles around it.

    Args:
        target: the object's joint, its meshes in the asset frame with all joints closed.
    """

    def __init__(self, target: Target) -> None:
        self.target = target
        self._moving, self._fixed = (_tree(solid_points(mesh)) for mesh in (target.moving, target.fixed))
        self._obstacles: cKDTree | None = None

    def with_obstacles(self, obstacles: Array) -> "Surroundings":
        """The same object with obstacles: points (N, 3) on what does not move, asset frame."""
        other = copy(self)
        other._obstacles = _tree(obstacles)
        return other

    def gaps(self, centers: Array, radii: Array, values: Array) -> Array:
        """(K, S) free distance around spheres (K, S, 3), (S,) in the asset frame with the joint at `values` (K,).

        Distances of centers are cut off at the largest radius plus twice `CLEARANCE`.
        """
        motions = self.target.motions(values)
        in_moving = (centers - motions[:, None, :3, 3]) @ motions[:, :3, :3]
        reach = radii.max() + 2 * CLEARANCE
        nearest = np.full(centers.shape[:2], reach)
        for tree, points in ((self._moving, in_moving), (self._fixed, centers), (self._obstacles, centers)):
            if tree is not None:
                nearest = np.minimum(nearest, tree.query(points, distance_upper_bound=reach)[0])
        return np.asarray(nearest - radii)

    def clear(self, centers: Array, radii: Array, values: Array) -> bool:
        """Whether spheres (K, S, 3), (S,) in the asset frame touch nothing with the joint at `values` (K,)."""
        return bool((self.gaps(centers, radii, values) > CLEARANCE).all())


def surface_points(mesh: trimesh.Trimesh, count: int = SURFACE_POINTS) -> Array:
    """(count, 3) points on a mesh, always the same ones; none on an empty mesh."""
    if len(mesh.faces) == 0:
        return np.zeros((0, 3))
    return sample_triangles(mesh.triangles, mesh.area_faces, count)


def solid_points(mesh: trimesh.Trimesh) -> Array:
    """Points on and inside the convex pieces of a mesh, so that a finger inside a knob is noticed, too."""
    points = [surface_points(mesh)]
    share = np.random.default_rng(0).uniform(size=(INNER_POINTS, 1)) ** (1 / 3)  # of the way out; even in a ball
    for corners in split_solids(mesh) if len(mesh.faces) else []:
        triangles = mesh.vertices[corners]
        areas = trimesh.triangles.area(triangles)
        middle = np.average(triangles.mean(axis=1), weights=areas, axis=0)
        points.append(middle + share * (sample_triangles(triangles, areas, INNER_POINTS) - middle))
    return np.concatenate(points)


def arm_spheres(frames: Array, fingers: float | None, held: Array | None = None) -> tuple[Array, Array]:
    """Spheres of an arm with joint frames (K, 8, 4, 4): centers (K, S, 3) in the frame of `frames`, radii (S,).

    Args:
        frames: of the joints and, last, of the tool center point (`Chain.frames`).
        fingers: position of the finger joints in metres; None leaves the fingers out (they hold something).
        held: (M, 4) center in the tool frame and radius of spheres on a held object.
    """
    spheres = _spheres(fingers, held)
    owners = frames[:, spheres[:, 0].astype(int)]
    centers = np.einsum("ksij,sj->ksi", owners[..., :3, :3], spheres[:, 1:4]) + owners[..., :3, 3]
    return centers, spheres[:, 4]


def gripper_spheres(fingers: float) -> tuple[Array, Array]:
    """Spheres of hand and fingers: centers (S, 3) in the tool frame, radii (S,); `fingers` as of `arm_spheres`."""
    spheres = _spheres(fingers)
    gripper = spheres[spheres[:, 0] < 0]
    return gripper[:, 1:4], gripper[:, 4]


def _spheres(fingers: float | None, held: Array | None = None) -> Array:
    """(S, 5) rows as of `ARM`."""
    rows = [ARM]
    if fingers is not None:
        opened = np.add(FINGER, [0, 0, fingers, 0, 0])
        rows += [opened, opened * [1, 1, -1, 1, 1]]
    if held is not None:
        rows.append(np.column_stack([np.full(len(held), -1), held]))
    return np.concatenate(rows)


def _tree(points: Array) -> cKDTree | None:
    # Built in half the time, asked no slower: it is asked but a few hundred times.
    return cKDTree(points, compact_nodes=False, balanced_tree=False) if len(points) else None


ANGLE_WEIGHT = 0.15  # metres that a radian counts for in the length of a path; chosen
POSE_SPACING = 0.005  # metres between the poses of a path, in that length; chosen


def measure_distance(a: Array, b: Array) -> Array:
    """(N,) path length between poses (N, 4, 4): metres, with radians at `ANGLE_WEIGHT`."""
    error = pose_error(a, b)
    return np.asarray(np.linalg.norm(error[:, :3], axis=1) + ANGLE_WEIGHT * np.linalg.norm(error[:, 3:], axis=1))


def make_line(start: Array, end: Array) -> Array:
    """(K, 4, 4) poses from `start` to `end`, both included; rotation about one axis."""
    count = max(2, 1 + int(np.ceil(measure_distance(start[None], end[None])[0] / POSE_SPACING)))
    error = pose_error(end[None], start[None])[0]
    fraction = np.linspace(0, 1, count)[:, None]
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 3] = start[:3, 3] + fraction * error[:3]
    poses[:, :3, :3] = Rotation.from_rotvec(fraction * error[3:]).as_matrix() @ start[:3, :3]
    return poses


def join_lines(way: Sequence[Array]) -> Array:
    """(K, 4, 4) poses straight from each pose to the next one."""
    legs = [make_line(a, b) for a, b in itertools.pairwise(way)]
    return np.concatenate([legs[0], *[leg[1:] for leg in legs[1:]]])


def make_handle_path(target: Target, grasp: Array, start: float, goal: float, follow: float) -> Array:
    """(K, 4, 4) poses of a hand that holds the handle while the joint goes from `start` to `goal`, asset frame.

    Args:
        grasp: (4, 4) pose of the hand when the joint is closed.
        follow: share of the door's rotation that the hand makes; at 0 the handle turns between the fingers.
    """
    ends = target.motions(np.array([start, goal])) @ grasp
    count = max(2, 1 + int(np.ceil(measure_distance(ends[:1], ends[1:])[0] / POSE_SPACING)))
    values = np.linspace(start, goal, count)
    poses = target.motions(values) @ grasp
    if target.revolute:
        turns = Rotation.from_rotvec(follow * (values - target.lower)[:, None] * target.axis)
        poses[:, :3, :3] = turns.as_matrix() @ grasp[:3, :3]
    return np.asarray(poses)


class Pursuit:
    """Follows a path by progress: aims at the pose `lookahead` past the nearest one, never backwards.

    Aiming by progress and not by time keeps the aim on the arc when the hand lags behind; an aim that runs ahead
    cuts the arc of a door and pulls the handle out of the fingers.
    """

    def __init__(self, path: Array, lookahead: float) -> None:
        self.path = path
        steps = measure_distance(path[1:], path[:-1])
        self.length = np.concatenate([[0.0], np.cumsum(steps)])
        self.lookahead = lookahead
        self.nearest = 0

    def aim(self, pose: Array) -> Array:
        """(4, 4) pose to move to from `pose`."""
        window = self.path[self.nearest : self.nearest + 1 + int(2 * self.lookahead / POSE_SPACING)]
        gaps = measure_distance(window, np.broadcast_to(pose, window.shape))
        self.nearest += int(gaps.argmin())
        ahead = np.searchsorted(self.length, self.length[self.nearest] + self.lookahead)
        return np.asarray(self.path[min(int(ahead), len(self.path) - 1)])

    @property
    def progress(self) -> float:
        """Length of the path already behind the hand."""
        return float(self.length[self.nearest])

    @property
    def left(self) -> float:
        """Length of the path still ahead of the hand."""
        return float(self.length[-1]) - self.progress
