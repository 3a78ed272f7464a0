"""Candidate motions, simulated with the same IK that executes actions, to find those without a collision."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from roomkin.stages.geometry.frames import invert_transform
from roomkin.stages.planning.clearance import Surroundings, arm_spheres, make_line, measure_distance
from roomkin.stages.simulation.kinematics import Array, Chain, pose_error, track
from roomkin.stages.simulation.robot import REST

ROLLOUT_STEP = 0.03  # path length between rolled-out poses, radians between those on the way to rest; chosen for time
TOLERANCE = np.array([0.008, 0.1])  # metres and radians off a pose at which the hand has reached it; chosen
BATCH = (2, 32)  # candidates rolled out at once: at first, as mostly one of these will do, and at most; chosen for time
ON_THE_WAY = 4.0  # times the tolerance, at poses that are only passed; chosen


@dataclass(frozen=True)
class Stretch:
    """A stretch of a candidate: where the hand goes, and in what state robot and object then are.

    path: (K, 4, 4) poses of the hand in the base frame. fingers: the finger joints in metres; None: they hold
    something, and may touch it. joint: the target joint at both ends. held: (M, 4) spheres of a held object, see
    `arm_spheres`. slack: times the tolerance that the arm may miss a pose by: on the way the place is not important.
    """

    path: Array
    fingers: float | None
    joint: tuple[float, float]
    held: Array | None = None
    slack: float = 1.0


def find_feasible(
    chain: Chain,
    joints: Array,
    candidates: Iterable[Sequence[Stretch]],
    base_from_asset: Array,
    surroundings: Surroundings,
    spare: float = 0.0,
) -> int | None:
    """Index of the first candidate that the arm can follow from `joints` (7,) and that touches nothing.

    Args:
        spare: radians that every joint should keep from its limits; if no candidate does, the one that keeps most.
    """
    best, widest = None, -np.inf
    untried, start, (size, largest) = iter(candidates), 0, BATCH
    while batch := list(islice(untried, size)):
        sketches = [[thin_path(stretch.path) for stretch in candidate] for candidate in batch]
        slack = [
            np.concatenate([np.full(len(path), stretch.slack) for path, stretch in zip(sketch, candidate, strict=True)])
            for sketch, candidate in zip(sketches, batch, strict=True)
        ]
        rollouts, reached = roll_out(chain, joints, [np.concatenate(sketch) for sketch in sketches], slack)
        for index, (candidate, sketch) in enumerate(zip(batch, sketches, strict=True)):
            margin = chain.margin(rollouts[index]).min()
            if not reached[index] or margin <= widest:
                continue
            parts = np.split(rollouts[index], np.cumsum([len(path) for path in sketch])[:-1])
            if all(
                _is_clear(chain, part, stretch, base_from_asset, surroundings)
                for part, stretch in zip(parts, candidate, strict=True)
            ):
                best, widest = start + index, margin
                if margin >= spare:
                    return best
        start, size = start + len(batch), min(2 * size, largest)
    return best


def measure_deviation(goals: Array, poses: Array) -> Array:
    """(N, 2) how far poses (N, 4, 4) are from their goals: metres, radians."""
    error = pose_error(goals, poses)
    return np.stack([np.linalg.norm(error[:, :3], axis=1), np.linalg.norm(error[:, 3:], axis=1)], axis=1)


def plan_homing(chain: Chain, joints: Array, off: Array) -> Array:
    """(K, 4, 4) poses of a hand that goes straight to `off` (4, 4), from where the joints go to rest.

    A straight way of the hand would turn some joint to its limit. Nor can the poses be those that the joints pass on a
    straight way to rest: having a joint more than a pose needs, the arm would come to them bent in another way. So
    every pose is a step towards rest from the joints with which the arm comes to the one before.
    """
    way = list(make_line(chain.pose(joints[None])[0], off))
    for pose in thin_path(np.stack(way)):
        joints = track(chain, joints[None], pose[None])[0]
    for left in range(int(np.ceil(np.abs(REST - joints).max() / ROLLOUT_STEP)), 0, -1):
        way.append(chain.pose((joints + (REST - joints) / left)[None])[0])
        joints = track(chain, joints[None], way[-1][None])[0]
    return np.stack(way)


def thin_path(path: Array) -> Array:
    """Every `ROLLOUT_STEP` of a path, the last pose included, the first one not."""
    length = np.concatenate([[0.0], np.cumsum(measure_distance(path[1:], path[:-1]))])
    count = max(1, int(np.ceil(length[-1] / ROLLOUT_STEP)))
    return np.asarray(path[np.searchsorted(length, np.linspace(0, length[-1], count + 1)[1:] - 1e-9)])


def roll_out(
    chain: Chain, joints: Array, paths: Sequence[Array], slack: Sequence[Array]
) -> tuple[list[Array], list[bool]]:
    """Track all paths (K_i, 4, 4) at once: per path (K_i, 7) joints, and whether every pose was reached.

    Args:
        slack: (K_i,) per path, times the tolerance of every pose.
    """
    longest = max(len(path) for path in paths)
    padded = np.stack([np.concatenate([path, np.tile(path[-1:], (longest - len(path), 1, 1))]) for path in paths])
    slacks = np.stack([np.append(one, np.full(longest - len(one), one[-1])) for one in slack])
    q = np.tile(joints, (len(paths), 1))
    reached = np.ones(len(paths), bool)
    history = []
    for step in range(longest):
        q = track(chain, q, padded[:, step])
        reached &= (measure_deviation(padded[:, step], chain.pose(q)) < TOLERANCE * slacks[:, step, None]).all(axis=1)
        history.append(q)
    joined = np.stack(history, axis=1)
    return [joined[i, : len(path)] for i, path in enumerate(paths)], reached.tolist()


def _is_clear(
    chain: Chain, rollout: Array, stretch: Stretch, base_from_asset: Array, surroundings: Surroundings
) -> bool:
    """Whether arm, hand, fingers and what they hold stay clear along a rollout (K, 7) of a stretch."""
    frames = invert_transform(base_from_asset) @ chain.frames(rollout)
    start, end = stretch.joint
    values = start + (end - start) * np.arange(1, len(rollout) + 1) / len(rollout)
    return surroundings.clear(*arm_spheres(frames, stretch.fingers, stretch.held), values)
