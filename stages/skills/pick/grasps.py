"""Grasps sampled on an object's cloud (paper A.4): antipodal pairs that a parallel gripper can close on."""

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from stages.geometry.frames import rigid
from stages.simulation.kinematics import Array

POINTS = 4000  # of an object's cloud
CONTACTS = 120  # of them tried as the first contact
ASIDE = 0.003  # the second contact is this near to the line through the first along its normal, metres
FACING = 0.85  # cosine between the normal of one contact and the opposite normal of the other
WIDEST, THINNEST = 0.07, 0.002  # between the contacts, metres
TURNS = 16  # approach directions tried about each closing axis
CONE = 0.6  # radians between an approach and straight down
DEPTH = 0.011  # that the pads' centres reach past the edge of what they hold, metres
BESIDE = 0.015  # how far from the line of approach that edge is looked for, metres
FARTHEST = 0.025  # that a contact may be below the edge, metres: beyond, the wall there may be another one
NEAR = 2000  # points that the gripper is kept clear of
# Boxes (low, high) of one open finger (y outwards of its inner face) and of the hand, in the frame of the tool centre.
FINGER_BOX = np.array([[-0.011, 0.0, -0.045], [0.011, 0.024, 0.0105]])
HAND_BOX = np.array([[-0.033, -0.105, -0.13], [0.033, 0.105, -0.044]])
ALIKE = 0.4  # radians: turns of the hand that are no reason to prefer one grasp to another
SLACK = 0.002  # metres kept between the gripper and the cloud


@dataclass(frozen=True)
class ObjectCloud:
    """Points (N, 3) and outward normals (N, 3) on an object's surface, in its own frame."""

    points: Array
    normals: Array


def object_cloud(mesh: trimesh.Trimesh, count: int = POINTS) -> ObjectCloud:
    """Points evenly over a closed surface; the same mesh gives the same points."""
    points, faces = trimesh.sample.sample_surface(mesh, count, seed=0)
    return ObjectCloud(np.asarray(points), np.asarray(mesh.face_normals[faces]))


def sample_grasps(cloud: ObjectCloud, object_pose: Array, floor: float, opening: float, seed: int) -> Array:
    """(N, 4, 4) poses of the tool centre point that close on an object, in the frame that `object_pose` is in.

    Args:
        cloud: of the object, in its own frame.
        object_pose: (4, 4) in a frame whose z is up.
        floor: height of what the object stands on, in that frame; the open gripper stays above it.
        opening: of one finger joint when the gripper is open, metres.
        seed: of the contacts that are tried.
    """
    rng = np.random.default_rng(seed)
    points = cloud.points @ object_pose[:3, :3].T + object_pose[:3, 3]
    normals = cloud.normals @ object_pose[:3, :3].T
    poses = []
    level = np.flatnonzero(np.abs(normals[:, 2]) <= np.sin(CONE))  # an approach within the cone is across these
    for first in rng.choice(level, min(CONTACTS, len(level)), replace=False):
        second = opposite(points, normals, first)
        if second is None:
            continue
        closing = -normals[first]
        middle = points[first] + closing * ((points[second] - points[first]) @ closing) / 2
        for approach in approaches(closing):
            poses.append(rigid(np.stack([np.cross(closing, approach), closing, approach], axis=1), middle))
    return fitting(np.array(poses).reshape(-1, 4, 4), points[:: len(points) // NEAR], floor, opening)


def opposite(points: Array, normals: Array, first: int) -> int | None:
    """The nearest point that a line from point `first` through the object comes out at, facing away; None if none."""
    offset = points - points[first]
    along = -(offset @ normals[first])
    aside = np.linalg.norm(offset + along[:, None] * normals[first], axis=1)
    candidates = np.flatnonzero(
        (along > THINNEST) & (along < WIDEST) & (aside < ASIDE) & (normals @ normals[first] < -FACING)
    )
    return int(candidates[along[candidates].argmin()]) if len(candidates) else None


def approaches(closing: Array) -> Array:
    """(N, 3) directions at a right angle to the closing axis (3,), within a cone about straight down."""
    across = np.cross(closing, [0.0, 0.0, 1.0])
    if np.linalg.norm(across) < 0.1:
        across = np.cross(closing, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    angles = 2 * np.pi * np.arange(TURNS) / TURNS
    around = np.cos(angles)[:, None] * np.cross(closing, across) + np.sin(angles)[:, None] * across
    return np.asarray(around[around[:, 2] < -np.cos(CONE)])


def fitting(poses: Array, points: Array, floor: float, opening: float) -> Array:
    """Those of the poses (N, 4, 4) at which an open gripper touches neither the points (P, 3) nor the floor.

    Each is first moved along its approach to where the pads reach `DEPTH` past the edge of what they hold: a contact
    far below an edge is gripped at the edge, as the palm has no room below it.
    """
    rotations, centers = poses[:, :3, :3], poses[:, :3, 3]
    local = np.swapaxes(points @ rotations - centers[:, None] @ rotations, 1, 2).astype(np.float32)  # (N, 3, P)
    near = local[:, 0] ** 2 + local[:, 1] ** 2 < BESIDE**2
    depth = np.where(near, local[:, 2], 0.0).min(axis=1) + DEPTH
    poses = poses.copy()
    poses[:, :3, 3] += depth[:, None] * poses[:, :3, 2]
    local[:, 2] -= depth[:, None]
    good = depth > -FARTHEST
    finger = FINGER_BOX + np.array([0.0, opening, 0.0])
    for box in (HAND_BOX, finger, finger * [1, -1, 1]):
        low, high = box.min(axis=0) - SLACK, box.max(axis=0) + SLACK
        inside = np.logical_and.reduce([(local[:, i] > low[i]) & (local[:, i] < high[i]) for i in range(3)])
        good &= ~inside.any(axis=1)
        corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
        heights = corners @ poses[:, 2, :3].T + poses[:, 2, 3]
        good &= heights.min(axis=0) > floor + SLACK
    return np.asarray(poses[good])


def by_turn(poses: Array, hand: Array) -> Array:
    """Grasps (N, 4, 4), those with the least change of orientation from `hand` (4, 4) first.

    A gripper is the same turned half round: of the two ways the nearer one is taken. Of those that turn alike, within
    `ALIKE`, the nearest to the hand comes first: a bowl offers two opposite rims at the same turn, and where
    demonstrations take either, a policy closes between them (docs/results/742a43a/table3-why.md).
    """
    flipped = poses @ np.diag([-1.0, -1.0, 1.0, 1.0])
    turns = np.stack([turn_between(ways, hand) for ways in (poses, flipped)])
    nearer = np.where((turns[0] <= turns[1])[:, None, None], poses, flipped)
    distance = np.linalg.norm(poses[:, :3, 3] - hand[:3, 3], axis=1)
    return np.asarray(nearer[np.lexsort([distance, np.round(turns.min(axis=0) / ALIKE)])])


def turn_between(poses: Array, hand: Array) -> Array:
    """(N,) radians between the orientations of poses (N, 4, 4) and of `hand` (4, 4)."""
    return np.asarray(Rotation.from_matrix(poses[:, :3, :3] @ hand[:3, :3].T).magnitude())
