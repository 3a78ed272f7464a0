"""Models of depth sensors: noise, smeared and lost edges, holes, weak or strong."""

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.names.training.pictures import Picture
from plugins.names.training.solids import Array, Rng
from stages.geometry.frames import rigid

TILT, OFF = 1.7, 0.025  # degrees and share of the camera's height by which the level frame errs; chosen


def sense_depth(picture: Picture, rng: Rng) -> Array:
    """Depth (H, W) as stereo, structured light, time of flight or a network measures it, metres; 0: unknown."""
    depth = picture.depth
    shape = depth.shape
    wide = shape[1] / 160
    if rng.random() < 0.04:
        return np.zeros(shape)
    if rng.random() < 0.4:  # coarse: measured at fewer pixels and blended between
        small = cv2.resize(depth, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST)
        depth = np.asarray(cv2.resize(small, shape[::-1], interpolation=cv2.INTER_LINEAR))
    if rng.random() < 0.7:  # ragged edges
        depth = _fray(depth, rng.uniform(0.2, 0.7), rng)
    strength = 0.004 * rng.random() ** 2
    noise = strength * _grain(shape, rng.choice([0.0, 1.0, 2.0]) * wide, rng) * depth**2
    bent = rng.uniform(0, 0.01) * _grain(shape, 25 * wide, rng) * depth  # slow errors over the picture
    noisy = (depth + noise + bent) * (1 + rng.normal(0, 0.008))
    lost = (depth <= 0) | (noisy < rng.uniform(0.2, 0.4)) | (noisy > rng.choice([4.5, 7.0, 20.0]))
    lost |= picture.cosine < rng.uniform(0.0, 0.15)
    if rng.random() < 0.4:
        lost |= _shadow(depth, wide * rng.uniform(1.0, 4.0))
    if rng.random() < 0.5:  # patches: glass, dark, shiny
        lost |= _grain(shape, rng.uniform(2, 12) * wide, rng) > rng.uniform(1.2, 2.6)
    lost |= rng.random(shape) < rng.choice([0.0, 0.002, 0.02])
    return np.where(lost, 0.0, noisy)


def _fray(depth: Array, spread: float, rng: Rng) -> Array:
    """Depth (H, W) whose edges are smeared over about so many pixels."""
    places = (np.indices(depth.shape) + np.rint(rng.normal(0, spread, (2, *depth.shape)))).astype(int)
    row, column = (np.clip(place, 0, side - 1) for place, side in zip(places, depth.shape, strict=True))
    return np.asarray(depth[row, column])


def _grain(shape: tuple[int, ...], grain: float, rng: Rng) -> Array:
    """Normal noise alike over some pixels, of standard deviation 1."""
    if grain < 0.3:
        return rng.standard_normal(shape)
    step = max(1, int(grain / 2))
    small = rng.standard_normal([side // step + 2 for side in shape])
    smooth = cv2.GaussianBlur(small, (0, 0), max(0.5, grain / step))
    field = np.asarray(cv2.resize(smooth, shape[::-1], interpolation=cv2.INTER_LINEAR), np.float64)
    return field / max(float(field.std()), 1e-9)


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
    return np.asarray(rigid(left @ right, [0, 0, rng.normal(0, OFF) * frame[2, 3]]) @ frame)


def sense_as_kinect(picture: Picture, rng: Rng) -> Array:
    """Depth (H, W) as the first Kinect measures it, metres; 0: unknown.

    Disparity is of eighths of a pixel at a focal length of 580 pixels and a base of 7.5 cm, so that steps grow as the
    square of depth, 2.9 mm at 1 m, and so does noise (Khoshelham and Oude Elberink 2012). Nothing is measured in the
    projector's shadow, at edges, at grazing sight, and on many dark or glossy things.
    """
    depth = picture.depth
    shape = depth.shape
    wide = shape[1] / 160
    per_metre = 580 * 0.075 * 8  # eighths of a pixel of disparity at 1 m
    moved = _fray(depth, rng.uniform(0.3, 0.9), rng)
    disparity = per_metre / np.maximum(moved, 0.1) + rng.uniform(0.2, 0.8) * _grain(shape, wide, rng)
    noisy = per_metre / np.maximum(np.rint(disparity), 1.0) * (1 + rng.normal(0, 0.006))
    lost = (moved <= 0) | (noisy < 0.5) | (noisy > rng.choice([4.5, 8.0]))
    lost |= picture.cosine < rng.uniform(0.1, 0.3)
    lost |= _shadow(depth, wide * rng.uniform(2.0, 5.0))
    edges = np.asarray(cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))) > 0.05 * moved
    lost |= edges & (rng.random(shape) < rng.uniform(0.0, 0.8))
    for owner in np.unique(picture.owner[picture.owner > 1]):
        if rng.random() < 0.12:  # dark or glossy: seen in patches
            lost |= (picture.owner == owner) & (_grain(shape, rng.uniform(1, 6) * wide, rng) > rng.uniform(-1.0, 1.0))
    return np.where(lost, 0.0, noisy)
