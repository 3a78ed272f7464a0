"""What a policy that goes by the handle needs (`handle` of a hyper-parameter set): the package `handle` brings it."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import torch
from torch import Tensor

from stages.plugins import load


class Marker(NamedTuple):
    """Finds the points of the handle and flags them with -1; metres, robot base frame.

    Attributes:
        mark: clouds (B, P, 4), flagged, and the upright planes (B, 3) of the fronts: normal x, y, offset.
        mark_episodes: the same of episodes of these lengths, end to end; zeros where the front does not stand still.
        vary: sequences (`training.dataset.Batch`) in which the handle alone tells where the hand must go.
        find_middles: of flagged clouds (..., P, 4) the middle of the handle, and how many points it has: (..., 4).
        offsets: from the hand (..., T, 3) to that.
    """

    mark: Callable[[Tensor], tuple[Tensor, Tensor]]
    mark_episodes: Callable[[Tensor, Sequence[int]], tuple[Tensor, Tensor]]
    vary: Callable[[Any, torch.Generator], Any]
    find_middles: Callable[[Tensor], Tensor]
    offsets: Callable[[Tensor, Tensor], Tensor]


@cache
def load_marker() -> Marker:
    """The marker of the package `handle`; asked for in every step, so looked for once."""
    marker: Marker = load("markers", "handle")
    return marker
