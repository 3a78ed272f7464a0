"""Grasps of a handle: how the hand stands to it, the preferred ways first (paper A.4)."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from stages.articulated.handle import Handle
from stages.geometry.frames import rigid
from stages.simulation.kinematics import Array
from stages.simulation.target import Target

FINGERTIP = 0.0145  # pad centre to fingertip, and 5 mm of air between fingertip and panel
MAX_DEPTH = 0.009  # pad centre behind the foremost surface: pads of 18 mm then cover a bar


@dataclass(frozen=True)
class Grasp:
    """A way to hold a handle: turn of the approach about the closing axis, and the share of a door's turn to make."""

    tilt: float
    follow: float


def grasps(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates, the preferred ones first: always the same order, so that demonstrations look alike."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    tilts = (0.7, 1.0, 0.35, 0.0) if upright else (0.0, 0.35, -0.35, 0.7, -0.7)
    for follow in (1.0, 0.5, 0.0) if target.revolute else (1.0,):
        for tilt in tilts:
            yield Grasp(tilt, follow)


def grasp_pose(handle: Handle, tilt: float, hand: Array) -> Array:
    """(4, 4) pose of the tool centre point on a handle, asset frame, closed.

    The fingers close across the handle's long direction (sideways on a knob), of the two ways the one nearer to
    the present pose `hand` (4, 4). `tilt` raises the wrist (for a horizontal bar: turns it sideways).
    """
    closing = np.array([0.0, 1.0, 0.0])
    if handle.elongated:
        closing = np.cross(handle.axis, [1.0, 0.0, 0.0])
    if closing @ hand[:3, 1] < 0:
        closing = -closing
    straight_in = np.array([-1.0, 0.0, 0.0])
    up = np.cross(closing, straight_in)
    lift = np.sign(up[2]) if abs(up[2]) > 0.5 else 1.0
    approach = Rotation.from_rotvec(-closing * tilt * lift).apply(straight_in)
    depth = float(np.clip(handle.protrusion - FINGERTIP, 0.0, MAX_DEPTH))
    rotation = np.stack([np.cross(closing, approach), closing, approach], axis=1)
    return rigid(rotation, handle.position + depth * straight_in)
