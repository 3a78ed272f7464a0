"""Level planes of a depth image: floors and table tops."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stages.geometry.planes import fit_plane

SAMPLED = 40_000  # points that planes are fitted to
UP_IN_IMAGE = np.array([0.0, -1.0, 0.0])  # camera frame: y is down
TILT = np.deg2rad(75)  # largest angle between image-up and a level plane's normal
FLAT = 0.006  # metres at 1 m, within which a point belongs to a plane
ACROSS = np.deg2rad(45)  # least angle between a level plane and a wall, of a camera that is not
PARALLEL, LEVELS, LARGE = np.deg2rad(8), 4, 0.1  # further planes: angle to the first, how many, share of its points


class Level(NamedTuple):
    """A level plane, camera frame: up is normal; points p of it have normal . p = offset. How many points it has."""

    up: NDArray[np.float64]
    offset: float
    points: int

    def height(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of points (..., 3) above the plane."""
        return np.asarray(points @ self.up - self.offset)


def sampled(points: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """At most `SAMPLED` of points (N, 3)."""
    return points[np.sort(rng.choice(len(points), min(SAMPLED, len(points)), replace=False))]


def level_planes(points: NDArray[np.float64], rng: np.random.Generator) -> list[Level]:
    """Planes in points (N, 3) whose normals point up in the image, largest first, all parallel to that one."""
    if not len(points):
        return []
    threshold = FLAT * float(np.median(points[:, 2]))
    found: list[Level] = []
    along, limit = _upright(points, threshold, rng), float(np.cos(PARALLEL))
    for _ in range(LEVELS):

        def level(
            normals: NDArray[np.float64], along: NDArray[np.float64] = along, limit: float = limit
        ) -> NDArray[np.bool_]:
            return np.abs(normals @ along) > limit

        plane = fit_plane(points, threshold, 1000, rng, level)
        if plane is None or (found and plane.inliers.sum() < LARGE * found[0].points):
            break
        sign = float(np.sign(plane.normal @ UP_IN_IMAGE))
        found.append(Level(sign * plane.normal, sign * plane.offset, int(plane.inliers.sum())))
        points = points[~plane.inliers]
        along = found[0].up
    return found


def _upright(points: NDArray[np.float64], threshold: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """The normal of the floors and tables in points (N, 3), or image-up.

    Seen from above a wall's normal points up in the image, too: of two planes across each other, the one that shows
    more area for its tilt is level.
    """
    best, most = UP_IN_IMAGE, 0.0
    across = np.zeros(3)
    for _ in range(2):

        def plausible(normals: NDArray[np.float64], across: NDArray[np.float64] = across) -> NDArray[np.bool_]:
            return (np.abs(normals @ UP_IN_IMAGE) > np.cos(TILT)) & (np.abs(normals @ across) < np.cos(ACROSS))

        plane = fit_plane(points, threshold, 1000, rng, plausible)
        if plane is None:
            break
        area = float(plane.inliers.sum() * (plane.normal @ UP_IN_IMAGE) ** 2)
        if area > most:
            best, most = plane.normal, area
        points, across = points[~plane.inliers], plane.normal
    return best
