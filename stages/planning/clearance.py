"""Whether the arm keeps clear of what is about it: spheres on arm and hand against points on surfaces."""

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from stages.simulation.kinematics import Array
from stages.simulation.target import Target

POINTS = 20_000  # on the moving and on the fixed part of an object; about a centimetre apart on a cabinet
SMALL, CELL = 0.1, 1e-6  # metres: middle extent of what is filled with points as well, m^3 for each of them
MARGIN = 0.005  # for the gaps between them
FAR = 0.1  # metres; what is farther off counts as this far

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
    """Points on the fixed and on the moving part of an object, and on obstacles about it.

    Args:
        target: the object's joint, its meshes in the asset frame with all joints closed.
        obstacles: (N, 3) points on what else stands about and does not move, asset frame.
    """

    def __init__(self, target: Target, obstacles: Array | None = None) -> None:
        self.target = target
        self._moving, self._fixed = (_tree(solid_points(mesh)) for mesh in (target.moving, target.fixed))
        self._obstacles = _tree(obstacles)

    def beside(self, obstacles: Array | None) -> "Surroundings":
        """The same object with other obstacles (N, 3), asset frame; its own surfaces are not sampled again."""
        other = object.__new__(Surroundings)
        other.__dict__.update(self.__dict__, _obstacles=_tree(obstacles))
        return other

    def gaps(self, centers: Array, radii: Array, values: Array) -> Array:
        """(K, S) free distance around spheres (K, S, 3), (S,) in the asset frame with the joint at `values` (K,)."""
        motions = self.target.motions(values)
        in_moving = (centers - motions[:, None, :3, 3]) @ motions[:, :3, :3]
        nearest = np.full(centers.shape[:2], FAR)
        for tree, points in ((self._moving, in_moving), (self._fixed, centers), (self._obstacles, centers)):
            if tree is not None:
                nearest = np.minimum(nearest, tree.query(points, distance_upper_bound=FAR)[0])
        return np.asarray(nearest - radii)

    def clear(self, centers: Array, radii: Array, values: Array) -> bool:
        """Whether spheres (K, S, 3), (S,) in the asset frame touch nothing with the joint at `values` (K,)."""
        return bool((self.gaps(centers, radii, values) > MARGIN).all())


def surface_points(mesh: trimesh.Trimesh, count: int = POINTS) -> Array:
    """(count, 3) points on a mesh, always the same ones; none on an empty mesh."""
    if len(mesh.faces) == 0:
        return np.zeros((0, 3))
    return np.asarray(trimesh.sample.sample_surface(mesh, count, seed=np.random.default_rng(0))[0])


def solid_points(mesh: trimesh.Trimesh) -> Array:
    """Points on the convex pieces of a mesh, and in the small ones: a finger inside a knob is far from its surface."""
    points = [surface_points(mesh)]
    for piece in mesh.split() if len(mesh.faces) else []:
        if np.median(piece.extents) < SMALL:
            surface = surface_points(piece, int(np.clip(piece.volume / CELL, 10, 500)))
            share = np.random.default_rng(0).uniform(size=(len(surface), 1)) ** (1 / 3)
            points.append(piece.centroid + share * (surface - piece.centroid))
    return np.concatenate(points)


def arm_spheres(frames: Array, fingers: float | None, held: Array | None = None) -> tuple[Array, Array]:
    """Spheres of an arm with joint frames (K, 8, 4, 4): centres (K, S, 3) in the frame of `frames`, radii (S,).

    Args:
        frames: of the joints and, last, of the tool centre point (`Chain.frames`).
        fingers: position of the finger joints in metres; None leaves the fingers out (they hold something).
        held: (M, 4) centre in the tool frame and radius of spheres on a held object.
    """
    spheres = [*ARM, *HAND]
    if fingers is not None:
        spheres += [(7, (0.0, side * (fingers + y), z), FINGER_RADIUS) for side in (-1, 1) for y, z in FINGER]
    if held is not None:
        spheres += [(7, (x, y, z), radius) for x, y, z, radius in held.tolist()]
    owners = frames[:, [frame for frame, _, _ in spheres]]
    local = np.array([center for _, center, _ in spheres])
    centers = np.einsum("ksij,sj->ksi", owners[..., :3, :3], local) + owners[..., :3, 3]
    return centers, np.array([radius for _, _, radius in spheres])


def _tree(points: Array | None) -> cKDTree | None:
    return cKDTree(points) if points is not None and len(points) else None
