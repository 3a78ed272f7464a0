"""Which way is up in a picture with depth: the direction for which most surfaces are level or upright."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

IMAGE_UP = np.array([0.0, -1.0, 0.0])  # camera frame: y is down
CELLS = 64  # cells across a picture, a normal of each: enough noise is averaged out at 4 m of a stereo camera
MIN_KNOWN = 0.6  # share of a cell's pixels of known depth; below it lies at an edge or a hole
NOISE = 0.0025  # metres of depth at 1 m, growing with the square of the distance: of a stereo camera
WITHIN = np.sin(np.deg2rad(8))  # a surface counts as level or upright up to here: the error of a normal at 4 m
LEVEL = np.sqrt(1 - WITHIN**2)  # cosine of the same angle
NO_LEVEL, MUCH_LEVEL = 0.01, 0.1  # shares of a picture's cells that face up; right frames have 0.04 at least
ROUNDS = 10  # of the refinement; it stands still after three or four
Array = NDArray[np.float64]


def cell_normals(points: Array, known: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Centers (N, 3) and unit normals (N, 3), towards the camera, of the picture's flat cells.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
    """
    side = max(2, points.shape[1] // CELLS)
    height, width = (length // side * side for length in known.shape)
    weight = known[:height, :width].astype(float)
    place = np.where(known[..., None], points, 0.0)[:height, :width]
    x, y, z = np.moveaxis(place, -1, 0)
    moments = np.stack([weight, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z], axis=-1)
    sums = moments.reshape(height // side, side, width // side, side, -1).mean(axis=(1, 3))
    sums = uniform_filter(sums, (3, 3, 1), mode="constant")  # of the 3 x 3 cells around each
    kept = sums[..., 0] > MIN_KNOWN
    mean = sums[kept][:, 1:] / sums[kept][:, :1]
    first, second = mean[:, :3], mean[:, [3, 4, 5, 4, 6, 7, 5, 7, 8]].reshape(-1, 3, 3)
    spread, axes = np.linalg.eigh(second - first[:, :, None] * first[:, None, :])
    flat = spread[:, 0] < np.minimum(0.5 * spread[:, 1], 0.02 * spread[:, 1] + (NOISE * first[:, 2] ** 2) ** 2)
    first, normals = first[flat], axes[flat][..., 0]
    return first, np.where(((first * normals).sum(-1) > 0)[:, None], -normals, normals)


def find_up(points: Array, known: NDArray[np.bool_], max_tilt: float) -> Array | None:
    """The unit vector (3,) against gravity in the camera frame; None: no surface tells.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
        max_tilt: largest angle to image-up, degrees.
    """
    return estimate_up(cell_normals(points, known)[1], max_tilt)


def is_upside_down(points: Array, known: NDArray[np.bool_], max_tilt: float) -> bool:
    """Whether nothing level faces up, and much does if the picture is turned over.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
        max_tilt: largest angle to image-up, degrees.
    """
    normals = cell_normals(points, known)[1]
    up, down = (_share_level(normals * [1, side, 1], max_tilt) for side in (1, -1))
    return up < NO_LEVEL and down > MUCH_LEVEL


def _share_level(normals: Array, max_tilt: float) -> float:
    up = estimate_up(normals, max_tilt)
    return 0.0 if up is None else float((normals @ up > LEVEL).mean())


def estimate_up(normals: Array, max_tilt: float) -> Array | None:
    """Likewise, by the normals of surfaces.

    A surface that faces up counts twice, an upright one and a ceiling once: a lone table top is upright, too, to
    every level direction.

    Args:
        normals: (N, 3) as of `cell_normals`.
        max_tilt: largest angle to image-up, degrees.
    """
    if len(normals) < 3:
        return None
    rng = np.random.default_rng(0)
    some = normals[rng.permutation(len(normals))[:1500]]
    pairs = np.cross(some, some[rng.permutation(len(some))])  # of two walls, where no level surface is seen
    tried = np.concatenate([some, -some, pairs, -pairs])
    lengths = np.linalg.norm(tried, axis=1)
    tried = tried[lengths > 0.5] / lengths[lengths > 0.5, None]
    tried = tried[tried @ IMAGE_UP > np.cos(np.deg2rad(max_tilt))]
    if not len(tried):
        return None
    along = tried @ some.T
    faces_up, others = along > LEVEL, (along < -LEVEL) | (np.abs(along) < WITHIN)
    up = tried[np.argmax((2 * faces_up.sum(axis=1) + others.sum(axis=1)) * (tried @ IMAGE_UP))]
    for _ in range(ROUNDS):
        along = normals @ up
        level, upright = normals[np.abs(along) > LEVEL], normals[np.abs(along) < WITHIN]
        axis = np.linalg.eigh(upright.T @ upright - level.T @ level)[1][:, 0]
        up = axis if axis @ up > 0 else -axis
    return up
