"""A depth camera's errors: the noise of extraction, and what it does not measure."""

import numpy as np
from numpy.typing import NDArray

from plugins.names.training.pictures import Picture
from plugins.names.training.solids import Array, Rng
from stages.config.extraction import DepthNoiseConfig
from stages.extraction.noise import noisy_depth, smooth_field
from stages.geometry.frames import make_transform

TILT, OFF = 1.7, 0.025  # degrees and share of the camera's height by which the level frame errs; chosen


def sense_depth(picture: Picture, rng: Rng) -> Array:
    """Depth (H, W) as stereo, structured light, time of flight or a network measures it, metres; 0: unknown."""
    noise = DepthNoiseConfig(range_constant=0.001, range_quadratic=0.004 * rng.random() ** 2, scale=0.008)
    depth = noisy_depth(picture.depth.astype(np.float32), noise, rng).astype(float)
    lost = (depth < rng.uniform(0.2, 0.5)) | (depth > rng.choice([4.5, 8.0, 20.0]))
    lost |= picture.cosine < rng.uniform(0.0, 0.3)
    lost |= _shadow(picture.depth, rng.uniform(0.0, 10.0))
    lost |= smooth_field((depth.shape[0], depth.shape[1]), rng.uniform(4, 24), rng) > rng.uniform(1.2, 4.0)  # glossy
    lost |= rng.random(depth.shape) < rng.choice([0.0, 0.002, 0.02])
    return np.where(lost, 0.0, depth)


def _shadow(depth: Array, pixels: float) -> NDArray[np.bool_]:
    """Where the second eye sees what is nearer: a band beside every step, as wide as the step in 1 / depth."""
    inverse = np.where(depth > 0, 1 / np.maximum(depth, 1e-3), 0.0)
    lands = np.arange(depth.shape[1]) + pixels * inverse
    return np.asarray(lands < np.maximum.accumulate(lands, axis=1) - 0.5)


def tilt_frame(frame: Array, rng: Rng) -> Array:
    """`floor_from_camera` (4, 4) with the error of an estimate: degrees, and a share of the camera's height."""
    x, y = np.deg2rad(rng.normal(0, TILT, 2))
    turn = np.array([[1, 0, y], [0, 1, -x], [-y, x, 1]])
    left, _, right = np.linalg.svd(turn)
    return np.asarray(make_transform(left @ right, [0, 0, rng.normal(0, OFF) * frame[2, 3]]) @ frame)
