"""Places for an object inside another one: its surface, by rejection sampling (paper A.4)."""

import numpy as np
import trimesh

from roomkin.plugins.bowl.region import Region
from roomkin.stages.geometry.frames import invert_transform, make_transform, yaw_matrix
from roomkin.stages.planning.clearance import CLEARANCE
from roomkin.stages.planning.path import ANGLE_WEIGHT
from roomkin.stages.simulation.kinematics import Array

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
