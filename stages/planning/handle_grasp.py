"""Grasps of a handle, the preferred ones first (paper A.4)."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.handle import Handle
from roomkin.stages.geometry.frames import make_transform, yaw_matrix
from roomkin.stages.planning.clearance import CLEARANCE
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.target import Target

HALF_PAD = 0.009  # from the middle of a finger's pad, which is the tool center point, to the fingertip, metres

# Tilt and pitch for the horizontal bar of a drawer where nothing else will do, or only with the arm at its limits: from
# above, with the fingertips, as the upper finger comes near the panel.
FROM_ABOVE = ((0.7, 0.35), (-0.7, 0.35), (0.35, 0.5))


@dataclass(frozen=True)
class Grasp:
    """A way to hold a handle. Angles in radians.

    tilt: turn of the approach about the closing axis. pitch: turn from above, about a horizontal handle. follow: share
    of a door's turn that the hand makes. depth: of the tool center point behind the foremost surface, metres. over:
    fingers above and below a knob, not at its sides. swing: turn of the approach about the vertical.
    """

    tilt: float
    pitch: float
    follow: float
    depth: float = HALF_PAD
    over: bool = False
    swing: float = 0.0


def list_grasps(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates, the preferred ones first: always in the same order, so that demonstrations are consistent."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    tilts = (0.7, 1.0, 0.35, 0.0) if upright else (0.0, 0.35, -0.35, 0.7, -0.7)
    follows = (1.0, 0.5, 0.0) if target.revolute else (1.0,)
    if target.flap:  # it comes down towards the robot; the less its bar turns between the fingers, the less it slips
        yield from (Grasp(0.0, pitch, follow) for follow in follows for pitch in (0.0, 0.35, 0.7))
    yield from (Grasp(tilt, 0.0, follow) for follow in follows for tilt in tilts)
    if not target.revolute and not upright:
        yield from (Grasp(tilt, pitch, 1.0, 0.0) for tilt, pitch in FROM_ABOVE)
    if not handle.elongated:  # another knob next to it leaves no room for a finger
        yield from (Grasp(tilt, 0.0, follow, over=True) for follow in follows for tilt in (0.0, 0.35, -0.35, 0.7, -0.7))


def list_last_resorts(target: Target, handle: Handle) -> Iterator[Grasp]:
    """Candidates for a wide door that no other grasp opens: the hand comes from the side of the hinge, where the front
    stays near the robot as it turns; to a horizontal bar from above, so that the arm need not turn with the front."""
    upright = not (handle.elongated and abs(handle.axis[2]) < 0.5)
    for follow in (0.5, 1.0, 0.0) if target.side else ():
        if upright:
            for swing in (0.35, 0.7):
                yield from (Grasp(tilt, 0.0, follow, swing=-target.side * swing) for tilt in (0.7, 0.35, 1.0, 0.0))
        else:
            for pitch in (0.35, 0.7):
                yield from (Grasp(tilt, pitch, follow) for tilt in (0.0, 0.35, -0.35, 0.7, -0.7))


def grasp_pose(handle: Handle, grasp: Grasp, hand: Array) -> Array:
    """(4, 4) pose of the tool center point on a handle, asset frame, closed.

    The fingers close across the handle's long direction (on a knob sideways, or from above and below). Of the two
    ways it is the one nearer to the present pose `hand` (4, 4); for a horizontal bar, which is equally far from both,
    always the one that takes the last joint away from its limit. A tilt raises the wrist (for a horizontal bar: turns
    it sideways).
    """
    closing = np.array([0.0, 0.0, 1.0] if grasp.over else [0.0, 1.0, 0.0])
    if handle.elongated:
        closing = np.cross(handle.axis, [1.0, 0.0, 0.0])
    if (closing[2] if abs(closing[2]) > 0.5 else closing @ hand[:3, 1]) < 0:
        closing = -closing
    straight_in = np.array([-1.0, 0.0, 0.0])
    up = np.cross(closing, straight_in)
    lift = np.sign(up[2]) if abs(up[2]) > 0.5 else 1.0
    approach = Rotation.from_rotvec(-closing * grasp.tilt * lift).apply(straight_in)
    thick = handle.elongated and handle.width > 2 * HALF_PAD
    depth = max(grasp.depth, handle.width / 2) if thick else grasp.depth  # nearer to its front the pads slip off
    depth = float(np.clip(handle.protrusion - HALF_PAD - CLEARANCE, 0.0, depth))
    rotation = np.stack([np.cross(closing, approach), closing, approach], axis=1)
    from_above = Rotation.from_rotvec([0.0, -grasp.pitch, 0.0]).as_matrix()
    return make_transform(yaw_matrix(grasp.swing) @ from_above @ rotation, handle.position + depth * straight_in)
