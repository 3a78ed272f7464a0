"""Matrices as the batched poses that ManiSkill takes."""

import numpy as np
import sapien
import torch
from mani_skill.utils.structs import Pose

from roomkin.stages.simulation.kinematics import Array


def batch_poses(matrices: Array) -> Pose:
    """(N, 4, 4) -> a batched pose."""
    raw = [np.concatenate([pose.p, pose.q]) for pose in map(sapien.Pose, matrices)]
    return Pose.create(torch.as_tensor(np.stack(raw), dtype=torch.float32))
