"""The front of what has a back: chairs and sofas face away from what is highest of them."""

import numpy as np
import trimesh

from stages.articulated.attributes import seen_of
from stages.articulated.forward_kinematics import link_frames
from stages.articulated.model import Matrix, RobotModel

BACKED = ("armchair", "bed", "bench", "chair", "sofa")
POINTS, TOP = 5000, 0.2  # on its surface; share of its height that is its top
ASIDE = 0.25  # of its extent, from its middle: what the top of a back lies aside at least


def front_before_back(robot: RobotModel, category: str) -> Matrix | None:
    """Horizontal axis (a unit vector of the root frame, z up) that a thing with a back faces; None: nothing tells."""
    looks = seen_of(robot, robot.links, link_frames(robot)) if category in BACKED else None
    if looks is None:
        return None
    points = np.asarray(trimesh.sample.sample_surface(looks, POINTS, seed=np.random.default_rng(0))[0])
    low, high = looks.bounds
    top = points[points[:, 2] > high[2] - TOP * (high[2] - low[2])]
    aside = ((top.mean(axis=0) - (low + high) / 2) / np.maximum(high - low, 1e-9))[:2]
    axis = int(np.abs(aside).argmax())
    if abs(aside[axis]) < ASIDE:
        return None
    front = np.zeros(3)
    front[axis] = -np.sign(aside[axis])
    return front
