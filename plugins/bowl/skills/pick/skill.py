"""The Pick skill (paper A.4): Move to a sampled grasp, Grasp, Lift."""

import numpy as np

from roomkin.plugins.bowl.carry import CarrySkill, make_held_spheres, shift_pose
from roomkin.plugins.bowl.movable import Movable
from roomkin.plugins.bowl.skills.pick.grasps import sample_grasps, sample_object_cloud, sort_by_turn
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.path import join_lines, make_line
from roomkin.stages.planning.rollout import ON_THE_WAY, Stretch, plan_homing
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import GRIPPER_OPEN, REST
from roomkin.stages.skills.motion import CLOSED, OPEN, Motion


class PickSkill(CarrySkill):
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
