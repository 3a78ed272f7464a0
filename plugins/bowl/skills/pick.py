"""The Pick skill (paper A.4): Move to a grasp, Grasp, Lift; grasps are antipodal pairs on the object's cloud."""

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from roomkin.plugins.bowl.carry import CANDIDATES, CarrySkill, Movable, make_held_spheres, shift_pose
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points
from roomkin.stages.planning.articulation import HALF_PAD
from roomkin.stages.planning.clearance import CLEARANCE, gripper_spheres, join_lines, make_line
from roomkin.stages.planning.rollout import ON_THE_WAY, Stretch, plan_homing
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import GRIPPER_OPEN, REST
from roomkin.stages.skills.motion import CLOSED, EMPTY, OPEN, Motion

LEAN = 0.6  # radians of an approach from straight down, and of a contact's normal from the closing axis; chosen
TURNS = 16  # approach directions tried about each closing axis; chosen


@dataclass(frozen=True)
class ObjectCloud:
    """Points (N, 3) and outward normals (N, 3) on an object's surface, in its own frame."""

    points: Array
    normals: Array


def sample_object_cloud(mesh: trimesh.Trimesh) -> ObjectCloud:
    """Points evenly over a closed surface; the same mesh gives the same points."""
    points, faces = trimesh.sample.sample_surface(mesh, 4000, seed=0)
    return ObjectCloud(np.asarray(points), np.asarray(mesh.face_normals[faces]))


def sample_grasps(cloud: ObjectCloud, object_pose: Array, floor: float, opening: float, seed: int) -> Array:
    """(N, 4, 4) poses of the tool center point that close on an object, in the frame that `object_pose` is in.

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
    level = np.flatnonzero(np.abs(normals[:, 2]) <= np.sin(LEAN))  # an approach within the cone is across these
    for first in rng.choice(level, min(CANDIDATES, len(level)), replace=False):
        second = find_opposite(points, normals, first, 2 * (opening - CLEARANCE))
        if second is None:
            continue
        closing = -normals[first]
        middle = points[first] + closing * ((points[second] - points[first]) @ closing) / 2
        for approach in list_approaches(closing):
            poses.append(make_transform(np.stack([np.cross(closing, approach), closing, approach], axis=1), middle))
    return keep_free_grasps(np.array(poses).reshape(-1, 4, 4), points, floor, opening)


def find_opposite(points: Array, normals: Array, first: int, widest: float) -> int | None:
    """The nearest point that a line from point `first` through the object comes out at, facing away.

    None if there is none, if what lies between them is thicker than `widest`, or too thin to tell it from nothing.
    """
    offset = points - points[first]
    along = -(offset @ normals[first])
    aside = np.linalg.norm(offset + along[:, None] * normals[first], axis=1)
    facing = normals @ normals[first] < -np.cos(LEAN)
    candidates = np.flatnonzero((along > 2 * EMPTY) & (along < widest) & (aside < CLEARANCE) & facing)
    return int(candidates[along[candidates].argmin()]) if len(candidates) else None


def list_approaches(closing: Array) -> Array:
    """(N, 3) directions at a right angle to the closing axis (3,), within a cone about straight down."""
    across = np.cross(closing, [0.0, 0.0, 1.0])
    if np.linalg.norm(across) < 0.1:
        across = np.cross(closing, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    angles = 2 * np.pi * np.arange(TURNS) / TURNS
    around = np.cos(angles)[:, None] * np.cross(closing, across) + np.sin(angles)[:, None] * across
    return np.asarray(around[around[:, 2] < -np.cos(LEAN)])


def keep_free_grasps(poses: Array, points: Array, floor: float, opening: float) -> Array:
    """Those of the poses (N, 4, 4) at which an open gripper touches neither the points (P, 3) nor the floor.

    Each is first moved along its approach until the pads reach past the edge of what they hold: a contact below an edge
    is gripped at the edge, as the palm has no room below it. One that is more than a pad's length below it is left out:
    the wall there may be another one.
    """
    rotations, centers = poses[:, :3, :3], poses[:, :3, 3]
    local = np.swapaxes(points @ rotations - centers[:, None] @ rotations, 1, 2)  # (N, 3, P)
    near = np.hypot(local[:, 0], local[:, 1]) < 2 * HALF_PAD
    depth = np.where(near, local[:, 2], 0.0).min(axis=1) + HALF_PAD
    poses = poses.copy()
    poses[:, :3, 3] += depth[:, None] * poses[:, :3, 2]
    spheres, radii = gripper_spheres(opening)
    placed = spheres @ np.swapaxes(rotations, 1, 2) + poses[:, None, :3, 3]  # (N, S, 3)
    gaps = np.minimum(cKDTree(points).query(placed)[0], placed[..., 2] - floor) - radii
    return np.asarray(poses[(gaps > CLEARANCE).all(axis=1) & (depth > -2 * HALF_PAD)])


def sort_by_turn(poses: Array, hand: Array) -> Array:
    """Grasps (N, 4, 4), those with the least change of orientation from `hand` (4, 4) first.

    A gripper looks the same after half a turn: the nearer of the two orientations is used. Among equal turns, to one
    of the `TURNS`, the nearest to the hand comes first: a bowl offers two opposite rims at the same turn, and where
    demonstrations take either, a policy closes between them (9 of 37 rollouts, none since).
    """
    flipped = poses @ np.diag([-1.0, -1.0, 1.0, 1.0])
    turns = np.stack([measure_turn(ways, hand) for ways in (poses, flipped)])
    nearer = np.where((turns[0] <= turns[1])[:, None, None], poses, flipped)
    distance = np.linalg.norm(poses[:, :3, 3] - hand[:3, 3], axis=1)
    return np.asarray(nearer[np.lexsort([distance, np.round(turns.min(axis=0) * TURNS / (2 * np.pi))])])


def measure_turn(poses: Array, hand: Array) -> Array:
    """(N,) radians between the orientations of poses (N, 4, 4) and of `hand` (4, 4)."""
    return np.asarray(Rotation.from_matrix(poses[:, :3, :3] @ hand[:3, :3].T).magnitude())


class Skill(CarrySkill):
    """Picks up the movable object from wherever it stands."""

    def attempt(self, motion: Motion, number: int) -> str:
        item = self.movable()
        floor = float(transform_points(item.base_from_object, item.mesh.vertices)[:, 2].min())
        grasps = sample_grasps(sample_object_cloud(item.mesh), item.base_from_object, floor, GRIPPER_OPEN, number)
        if len(grasps) == 0:
            return "no_grasp"
        plan = self.first(self._plans(sort_by_turn(grasps, self.rest), item))
        if plan is None:
            return "no_plan"
        cause = self.reach(motion, plan[:2], OPEN, "move")
        if cause:
            return cause
        motion.grasp()
        gripped = invert_transform(self.task.hand()) @ item.base_from_object
        if not self.holds(gripped):
            return "grasp"
        return self.reach(motion, plan[2:], CLOSED, "lift") or ("" if self.holds(gripped) else "slip")

    @property
    def rest(self) -> Array:
        """(4, 4) pose of the hand at rest. Grasps near its orientation suit the arm; those near the one in which the
        hand let go of a handle turn the wrist on to its limits."""
        return np.asarray(self.task.chain.pose(REST[None])[0])

    def _plans(self, grasps: Array, item: Movable) -> list[tuple[Stretch, Stretch, Stretch]]:
        """Move, the last part of it, and Lift, for every grasp (N, 4, 4), base frame: straight there, or backing off
        from a handle first, or from there through the rest pose, where no joint is near its limits."""
        hand, back = self.task.hand(), self.options.pregrasp
        off = shift_pose(hand, back * self.task.env.base_from_asset()[:3, 0])  # the way that a drawer opens
        joint = (self.joint(), self.joint())
        to_rest = plan_homing(self.task.chain, self.task.joints()[:7], off)
        plans = []
        for grasp in grasps:
            above = shift_pose(grasp, -back * grasp[:3, 2])
            held = make_held_spheres(item.mesh, invert_transform(grasp) @ item.base_from_object)
            down = Stretch(make_line(above, grasp), GRIPPER_OPEN, joint)
            lift = Stretch(make_line(grasp, shift_pose(grasp, np.array([0.0, 0.0, back]))), None, joint, held)
            home = np.concatenate([to_rest, make_line(to_rest[-1], above)[1:]])
            for way in (make_line(hand, above), join_lines([hand, off, above]), home):
                plans.append((Stretch(way, GRIPPER_OPEN, joint, slack=ON_THE_WAY), down, lift))
        return plans
