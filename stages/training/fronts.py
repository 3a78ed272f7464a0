"""The handle in all frames of demonstrations, and the plane of the front behind it (docs/policies.md)."""

from collections.abc import Sequence

import torch
from torch import Tensor

from roomkin.stages.policies.handle_points import segment_handles

FRONT_TURNED, FRONT_PULLED = 0.07, 0.015  # radians, metres in two frames in a row: a front that moves; chosen


def segment_episodes(clouds: Tensor, lengths: Sequence[int]) -> tuple[Tensor, Tensor]:
    """Flagged clouds (F, P, 4) of episodes end to end, and their fronts (F, 3): the first frame's, 0 once it moves."""
    flagged, planes = segment_handles(clouds)
    fronts = torch.zeros_like(planes)
    first = 0
    for length in lengths:
        part = slice(first, first + length)
        fronts[part] = planes[first] * find_still(planes[part])[:, None]
        first += length
    return flagged, fronts


def find_still(planes: Tensor) -> Tensor:
    """Which frames (T,) of an episode come before its front has turned or been pulled; planes (T, 3)."""
    cosine = planes[:, :2] @ planes[0, :2]
    moved = (cosine < torch.cos(torch.tensor(FRONT_TURNED))) | ((planes[:, 2] - planes[0, 2]).abs() > FRONT_PULLED)
    twice = moved & torch.cat([moved[1:], moved[-1:]])
    return twice.cumsum(0) == 0
