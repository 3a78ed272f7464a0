"""The robot's place before a door: the usual one, or one from which its arm can follow the handle all the way."""

from collections.abc import Callable, Iterator

import numpy as np

from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points
from roomkin.stages.planning.articulation import choose_open_goals, plan_articulation
from roomkin.stages.planning.clearance import BASE, Surroundings
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import REST, panda_chain
from roomkin.stages.simulation.target import Target
from roomkin.stages.tasks.initial_state import InitialState, base_pose, object_motion

# Metres farther out from the front and towards the hinge, in this order.
NEARBY = tuple((out, towards) for out in (0.1, 0.2) for towards in (0.15, 0.3, 0.45))
OFFICIAL_SUCCESS_FRACTION = 0.1  # of a joint's range, from here on it is opened by the official code
CLOSED = 0.1  # of a joint's range: open by less it counts as shut; chosen: what is not opened
MOTION = DemonstrationsConfig()


def find_success_opening(target: Target, options: TaskConfig) -> float:
    """The fraction of the range that counts as open: half, 60 degrees or 15 cm, whichever is less."""
    enough = np.deg2rad(options.success_angle) if target.revolute else options.success_distance
    return float(min(options.success_fraction, enough / (target.upper - target.lower)))


def place_robot_and_asset(
    setup: InitialState,
    target: Target,
    nominal: Array,
    options: TaskConfig,
    surroundings: Callable[[], Surroundings] | None,
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[Array, Array]:
    """(4, 4) poses of the robot's base and of the asset's root when an episode starts.

    Args:
        nominal: (3,) where the root is before the object is moved.
        surroundings: samples the asset's surfaces. Before a door the robot then stands where its arm can follow the
            handle. None: it stands at the usual place.
        shift: metres that the robot stands farther out, along y and up.
    """
    at = np.add(target.reference + nominal, shift)
    base = base_pose(at, target.side, setup, options, target.flap)
    root = object_motion(setup) @ make_transform(np.eye(3), nominal)
    if surroundings is not None and target.side and target.handle is not None:
        reached = reachable_base(base, root, REST + setup.joints, surroundings(), find_success_opening(target, options))
        base = base if reached is None else reached
    return base, root


def reachable_base(base: Array, root: Array, joints: Array, surroundings: Surroundings, opening: float) -> Array | None:
    """(4, 4) pose of the robot's base from which the arm follows a door's handle; None: there is none.

    Args:
        base: (4, 4) where it always stands; taken if it will do.
        root: (4, 4) pose of the asset, in the same frame.
        joints: (7,) of the arm.
        surroundings: of the asset and its door.
        opening: fraction of the range that counts as open.
    """
    for goal in choose_open_goals(surroundings.target, opening, MOTION.goal_margin):
        for place in nearby_bases(base, surroundings.target):
            base_from_asset = invert_transform(place) @ root
            if place is not base and not _passes(base_from_asset, surroundings, goal):
                continue
            if can_follow(base_from_asset, joints, surroundings, goal):
                return place
    return None


def can_follow(base_from_asset: Array, joints: Array, surroundings: Surroundings, goal: float) -> bool:
    """Whether the arm, from `joints` (7,), can move a joint from closed to a value."""
    start = surroundings.target.lower
    return plan_articulation(panda_chain(), joints, base_from_asset, surroundings, start, goal, MOTION) is not None


def nearby_bases(base: Array, target: Target) -> Iterator[Array]:
    """Places for the robot, first where it always stands."""
    yield base
    for out, towards in NEARBY:
        yield make_transform(np.eye(3), [out, -target.side * towards, 0.0]) @ base


def _passes(base_from_asset: Array, surroundings: Surroundings, goal: float) -> bool:
    """Whether the door passes by the robot's base."""
    values = np.linspace(surroundings.target.lower, goal, 20)
    centers = np.tile(transform_points(invert_transform(base_from_asset), BASE[:, :3]), (len(values), 1, 1))
    return surroundings.clear(centers, BASE[:, 3], values)
