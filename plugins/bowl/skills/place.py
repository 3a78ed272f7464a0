"""The Place skill (paper A.4): Move to a place inside another object, found by rejection sampling; Ungrasp, Lift."""

import itertools

import numpy as np
import trimesh

from roomkin.plugins.bowl.carry import CANDIDATES, CarrySkill, Region, make_held_spheres, shift_pose
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points, yaw_matrix
from roomkin.stages.planning.clearance import ANGLE_WEIGHT, CLEARANCE, join_lines, make_line
from roomkin.stages.planning.rollout import ON_THE_WAY, Stretch
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import GRIPPER_OPEN
from roomkin.stages.skills.motion import CLOSED, OPEN, Motion

DROP = (0.012, 0.16)  # metres above the surface at which it is let go: a deep drawer has no room for the hand; chosen


def find_places_inside(region: Region, mesh: trimesh.Trimesh) -> Array:
    """(N, 3) places for an upright object's axis on the region, where no part of it reaches past the region's walls."""
    return region.places(float(np.linalg.norm(mesh.vertices[:, :2], axis=1).max()) + CLEARANCE)


def sample_placements(
    places: Array, mesh: trimesh.Trimesh, hand: Array, hand_from_object: Array, count: int, seed: int
) -> Array:
    """(count, 4, 4) poses of the hand that put a held object upright at one of the places; least turn and fall first.

    Args:
        places: (N, 3) where the object's axis may meet the surface, in a frame whose z is up.
        hand: (4, 4) present pose, same frame.
        hand_from_object: (4, 4) how the object is held.
        seed: of places and turns.
    """
    if len(places) == 0:
        return np.zeros((0, 4, 4))
    rng = np.random.default_rng(seed)
    now = hand @ hand_from_object
    tipped = now[:3, 2]  # the object may have tilted between the fingers: it is set upright again
    yaw = np.arctan2(now[1, 0], now[0, 0]) if abs(tipped[2]) > 0.5 else 0.0
    turns, drops = rng.uniform(-np.pi / 2, np.pi / 2, count), rng.uniform(*DROP, count)
    chosen = places[rng.integers(len(places), size=count)]
    chosen[:, 2] += drops - float(mesh.bounds[0, 2])
    order = np.argsort(ANGLE_WEIGHT * np.abs(turns) + drops)
    objects = [make_transform(yaw_matrix(yaw + turns[i]), chosen[i]) for i in order]
    return np.stack(objects) @ invert_transform(hand_from_object)


OVER = (0.06, 0.02)  # metres above what a held object is lifted over, tried in turn; chosen


class Skill(CarrySkill):
    """Puts the object that the hand holds where the task wants it."""

    def is_done(self) -> bool:
        return self.movable().there

    def attempt(self, motion: Motion, number: int) -> str:
        item, hand = self.movable(), self.task.hand()
        hand_from_object = invert_transform(hand) @ item.base_from_object
        if not motion.holds:
            return "dropped"
        places = transform_points(item.base_from_region, find_places_inside(item.region, item.mesh))
        poses = sample_placements(places, item.mesh, hand, hand_from_object, CANDIDATES, number)
        held = make_held_spheres(item.mesh, hand_from_object)
        poses = poses[self.can_hold_at(poses, None, held)] if len(poses) else poses
        if len(poses) == 0:
            return "no_place"
        plan = self.first(self._plans(poses, hand, held))
        if plan is None:
            return "no_plan"
        cause = self.reach(motion, plan[:2], CLOSED, "move")
        if not cause and not self.holds(hand_from_object):
            return "let_go" if self.movable().there else "dropped"
        return cause or ("" if motion.release() else "ungrasp") or self.reach(motion, plan[2:], OPEN, "retreat")

    def _plans(self, poses: Array, hand: Array, held: Array) -> list[tuple[Stretch, Stretch, Stretch]]:
        """Move, the last part of it, and Lift, for every placement: over what stands around it, then down."""
        joint = (self.joint(), self.joint())
        plans = []
        for pose, over in itertools.product(poses, OVER):
            top = self._rim() + over
            low = float(transform_points(pose, held[:, :3])[:, 2].min())
            above = shift_pose(pose, np.array([0.0, 0.0, max(0.02, top - low)]))
            high = hand.copy()
            high[2, 3] = max(hand[2, 3], above[2, 3])
            down = Stretch(make_line(above, pose), None, joint, held)
            up = shift_pose(pose, np.array([0.0, 0.0, max(self.options.pregrasp, top - pose[2, 3])]))
            retreat = Stretch(make_line(pose, up), GRIPPER_OPEN, joint)
            way = join_lines([hand, high, above] if high[2, 3] > hand[2, 3] else [hand, above])
            plans.append((Stretch(way, None, joint, held, ON_THE_WAY), down, retreat))
        return plans

    def _rim(self) -> float:
        """Height of the moving part, base frame: a held object is carried over it."""
        env = self.task.env
        return float(transform_points(env.base_from_asset(), env.target.moving.vertices)[:, 2].max())
