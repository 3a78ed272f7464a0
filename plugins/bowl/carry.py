"""What Pick and Place share: the object and where it goes, how much room it takes in the hand, which plan to follow."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import trimesh
from scipy.ndimage import distance_transform_edt

from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.clearance import CLEARANCE, Surroundings, arm_spheres, surface_points
from roomkin.stages.planning.rollout import TOLERANCE, Stretch, find_feasible, measure_deviation
from roomkin.stages.simulation.kinematics import MAX_JOINT_STEP, Array, Chain, track
from roomkin.stages.skills.motion import LOST, OPEN, Motion, RetryingSkill

CELL = 0.005  # metres between rays; hits this close in height are one surface; chosen


@dataclass(frozen=True)
class Region:
    """The largest level surface that is seen from above, in the frame of its mesh; metres.

    height: of the surface. origin: (2,) x, y of the first cell's center. room: (X, Y) distance from each cell to the
    nearest one where the surface ends (a wall, an edge); 0 where there is no surface.
    """

    height: float
    origin: Array
    room: Array

    @property
    def low(self) -> Array:
        """(3,) corner of the box around the surface."""
        return np.append(self.origin + CELL * (np.argwhere(self.room > 0).min(axis=0) - 0.5), self.height)

    @property
    def high(self) -> Array:
        """(3,) the opposite corner, at the same height."""
        return np.append(self.origin + CELL * (np.argwhere(self.room > 0).max(axis=0) + 0.5), self.height)

    def places(self, radius: float) -> Array:
        """(N, 3) centers of the cells on which a disc of `radius` lies wholly within the surface."""
        cells = np.argwhere(self.room >= radius + CELL / 2)
        return np.column_stack([self.origin + CELL * cells, np.full(len(cells), self.height)])


def find_level_region(mesh: trimesh.Trimesh) -> Region | None:
    """The largest level surface among the first hits of rays from above; None if nothing is level."""
    low, high = mesh.bounds
    axes = [np.arange(low[i] + CELL / 2, high[i], CELL) for i in (0, 1)]
    origins = np.stack(np.meshgrid(*axes, [high[2] + 0.1], indexing="ij"), axis=-1).reshape(-1, 3)
    directions = np.tile([0.0, 0.0, -1.0], (len(origins), 1))
    hits, rays, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    if len(hits) == 0:
        return None
    depth = np.full(len(origins), -np.inf)
    depth[rays] = hits[:, 2]
    heights = np.sort(hits[:, 2])
    counts = np.searchsorted(heights, heights + CELL, side="right") - np.arange(len(heights))
    best = int(counts.argmax())
    height = float(np.median(heights[best : best + counts[best]]))
    level = (np.abs(depth - height) <= CELL).reshape(len(axes[0]), len(axes[1]))
    room = CELL * distance_transform_edt(np.pad(level, 1))[1:-1, 1:-1]
    return Region(height, np.array([axes[0][0], axes[1][0]]), room)


def measure_headroom(region: Region, above: trimesh.Trimesh, most: float = 1.0) -> float:
    """Distance in metres from a surface up to the lowest part of a mesh over it, at most `most`."""
    places = region.places(0.0)[::4]
    places[:, 2] += 1e-3
    up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    hits, _, _ = above.ray.intersects_location(places, up, multiple_hits=False)
    return min(most, float(hits[:, 2].min()) - region.height) if len(hits) else most


@dataclass(frozen=True)
class Movable:
    """An object as it stands now; poses (4, 4) in the robot base frame.

    mesh: in its own frame, upright. region: what it is put into, in the frame that `base_from_region` says, which moves
    with a drawer. there: whether the object is where it belongs, in the gripper or not.
    """

    mesh: trimesh.Trimesh
    base_from_object: Array
    region: Region
    base_from_region: Array
    there: bool


@runtime_checkable
class CarryEnv(Protocol):
    """An environment with something to carry."""

    def movable(self) -> Movable:
        """The object that Pick and Place move, in the first environment."""


CANDIDATES = 128  # grasps and plans that are tried; chosen for time


def shift_pose(pose: Array, by: Array) -> Array:
    """The pose (4, 4) moved by a vector (3,)."""
    moved = pose.copy()
    moved[:3, 3] += by
    return moved


def make_held_spheres(mesh: trimesh.Trimesh, hand_from_object: Array) -> Array:
    """(M, 4) center in the tool frame and radius of spheres on an object that the hand holds."""
    points = transform_points(hand_from_object, surface_points(mesh, 60))  # as spheres
    return np.column_stack([points, np.full(len(points), CLEARANCE)])


def can_hold(
    chain: Chain, joints: Array, poses: Array, stretch: Stretch, base_from_asset: Array, surroundings: Surroundings
) -> Array:
    """(N,) whether the arm, near its `joints` (7,), can hold the hand at poses (N, 4, 4) without touching anything.

    It is cheaper than a whole candidate, and rules out useless poses early.

    Args:
        stretch: the state of robot and object; its path is ignored.
    """
    across = int(np.ceil(np.ptp([chain.lower, chain.upper], axis=0).max() / MAX_JOINT_STEP))  # of the widest range
    q = track(chain, np.tile(joints, (len(poses), 1)), poses, across)
    reached = (measure_deviation(poses, chain.pose(q)) < TOLERANCE).all(axis=1)
    spheres = arm_spheres(invert_transform(base_from_asset) @ chain.frames(q), stretch.fingers, stretch.held)
    gaps = surroundings.gaps(*spheres, np.full(len(poses), stretch.joint[0]))
    return np.asarray(reached & (gaps > CLEARANCE).all(axis=1))


class CarrySkill(RetryingSkill):
    """Does something with the movable object of a task."""

    final = ("no_grasp", "no_place", "no_plan", "dropped", "timeout")

    def movable(self) -> Movable:
        """The object, as it stands."""
        env = self.task.env
        assert isinstance(env, CarryEnv), "the task has nothing to carry"
        return env.movable()

    def holds(self, hand_from_object: Array) -> bool:
        """Whether the hand still has the object about where it had it, at the pose (4, 4)."""
        now = invert_transform(self.task.hand()) @ self.movable().base_from_object
        return bool(np.linalg.norm(now[:3, 3] - hand_from_object[:3, 3]) < LOST)

    def can_hold_at(self, poses: Array, fingers: float | None, held: Array | None) -> Array:
        """(N,) whether the arm can hold the hand, and a `held` object, at poses (N, 4, 4) without touching anything."""
        task = self.task
        state = Stretch(poses, fingers, (self.joint(), self.joint()), held)
        where = (task.env.base_from_asset(), self.surroundings())
        return can_hold(task.chain, task.joints()[:7], poses, state, *where)

    def first(self, plans: Sequence[Sequence[Stretch]]) -> Sequence[Stretch] | None:
        """The first plan that the arm can follow without touching anything; None if none of the first ones can."""
        task = self.task
        where = (task.env.base_from_asset(), self.surroundings())
        index = find_feasible(task.chain, task.joints()[:7], plans[:CANDIDATES], *where)
        return None if index is None else plans[index]

    def reach(self, motion: Motion, stretches: Sequence[Stretch], gripper: float, name: str) -> str:
        """Follow stretches as one path; returns `name` if it cannot be followed to its end, or 'timeout'."""
        path = np.concatenate([stretches[0].path, *[stretch.path[1:] for stretch in stretches[1:]]])
        options = self.options  # with an object in it the hand swings if it is fast
        lookahead = options.approach_lookahead if gripper == OPEN else options.articulate_lookahead
        cause, _ = motion.reach(path, lookahead, gripper)
        return name if cause == "stall" else cause
