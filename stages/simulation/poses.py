"""Matrices as the batched poses that ManiSkill takes."""

import numpy as np
import sapien
import torch
from mani_skill.utils.structs import Pose

from stages.simulation.kinematics import Array


def to_poses(matrices: Array) -> Pose:
    """(N, 4, 4) -> a batched pose."""
    return Pose.create(torch.as_tensor(np.stack([_raw(m) for m in matrices]), dtype=torch.float32))


def _raw(matrix: Array) -> Array:
    pose = sapien.Pose(matrix)
    return np.concatenate([pose.p, pose.q])
