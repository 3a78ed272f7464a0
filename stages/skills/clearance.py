"""Whether the arm keeps clear of the object: spheres on the arm against points on the object's surfaces."""

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from stages.simulation.kinematics import Array
from stages.simulation.target import Target

POINTS = 20_000  # on the object; about a centimetre apart on a cabinet
MARGIN = 0.005  # for the gaps between them

# (frame, centre in that frame, radius) in metres; frame j < 7 is that of joint j + 1, frame 7 the tool centre point.
ARM = (
    (3, (0.0, 0.0, 0.0), 0.07),
    (4, (0.0, 0.03, -0.22), 0.06),
    (4, (0.0, 0.05, -0.14), 0.05),
    (4, (0.0, 0.05, -0.06), 0.05),
    (5, (0.0, 0.0, 0.0), 0.065),
    (5, (0.08, 0.0, 0.0), 0.055),
    (6, (0.0, 0.0, 0.05), 0.055),
)
HAND = tuple((7, (0.0, y, -0.08), 0.028) for y in (-0.075, -0.045, -0.015, 0.015, 0.045, 0.075))
FINGER = ((0.0076, 0.002), (0.0076, -0.012), (0.013, -0.03))  # (y outwards of the finger joint, z) in the tool frame
FINGER_RADIUS = 0.0075


class Surroundings:
    """Points on the fixed and on the moving part of an object, in the asset frame with its joints closed."""

    def __init__(self, target: Target) -> None:
        rng = np.random.default_rng(0)
        moving, fixed = (_sample(mesh, rng) for mesh in (target.moving, target.fixed))
        self.moving, self.fixed = cKDTree(moving), cKDTree(fixed) if len(fixed) else None
        self.target = target

    def clear(self, centers: Array, radii: Array, value: float) -> bool:
        """Whether spheres (N, 3), (N,) in the asset frame touch nothing with the joint at `value`."""
        motion = self.target.motions(np.array([value]))[0]
        in_moving = (centers - motion[:3, 3]) @ motion[:3, :3]
        gaps = self.moving.query(in_moving, distance_upper_bound=0.1)[0] - radii
        if self.fixed is not None:
            gaps = np.minimum(gaps, self.fixed.query(centers, distance_upper_bound=0.1)[0] - radii)
        return bool((gaps > MARGIN).all())


def _sample(mesh: trimesh.Trimesh, rng: np.random.Generator) -> Array:
    if len(mesh.faces) == 0:
        return np.zeros((0, 3))
    return np.asarray(trimesh.sample.sample_surface(mesh, POINTS, seed=rng)[0])


def arm_spheres(frames: Array, fingers: float | None) -> tuple[Array, Array]:
    """Spheres of an arm with joint frames (8, 4, 4): centres (N, 3) in the base frame and radii (N,).

    `fingers` is the position of the finger joints in metres; None leaves the fingers out (they hold the handle).
    """
    spheres = [*ARM, *HAND]
    if fingers is not None:
        spheres += [(7, (0.0, side * (fingers + y), z), FINGER_RADIUS) for side in (-1, 1) for y, z in FINGER]
    centers = np.array([frames[frame, :3, :3] @ center + frames[frame, :3, 3] for frame, center, _ in spheres])
    return centers, np.array([radius for _, _, radius in spheres])
