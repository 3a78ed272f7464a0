"""Models of sensors: noise, smeared and lost edges, holes and lighting, weak or strong."""

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.segmenter.training.pictures import Picture
from plugins.segmenter.training.solids import Array, Rng
from stages.geometry.frames import rigid

TILT, OFF = 1.2, 0.02  # degrees and share of the camera's height by which the level frame errs


def sense_depth(picture: Picture, rng: Rng) -> Array:
    """Depth (H, W) as stereo, structured light, time of flight or a network measures it, metres; 0: unknown."""
    depth = picture.depth.astype(float)
    shape = depth.shape
    wide = shape[1] / 160
    if rng.random() < 0.04:
        return np.zeros(shape)
    if rng.random() < 0.4:  # coarse: measured at fewer pixels and blended between
        small = cv2.resize(depth, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST)
        depth = np.asarray(cv2.resize(small, shape[::-1], interpolation=cv2.INTER_LINEAR))
    if rng.random() < 0.7:  # ragged edges
        rows, columns = np.indices(shape)
        spread = rng.uniform(0.2, 0.7)
        row = np.clip(rows + np.rint(rng.normal(0, spread, shape)).astype(int), 0, shape[0] - 1)
        column = np.clip(columns + np.rint(rng.normal(0, spread, shape)).astype(int), 0, shape[1] - 1)
        depth = depth[row, column]
    strength = 0.004 * rng.random() ** 2
    noise = strength * _grain(shape, rng.choice([0.0, 1.0, 2.0]) * wide, rng) * depth**2
    bent = rng.uniform(0, 0.01) * _grain(shape, 25 * wide, rng) * depth  # slow errors over the picture
    noisy = (depth + noise + bent) * (1 + rng.normal(0, 0.008))
    lost = (depth <= 0) | (noisy < rng.uniform(0.2, 0.4)) | (noisy > rng.choice([4.5, 7.0, 20.0]))
    lost |= picture.cosine < 255 * rng.uniform(0.0, 0.15)
    if rng.random() < 0.4:
        lost |= _shadow(depth, wide * rng.uniform(1.0, 4.0))
    if rng.random() < 0.5:  # patches: glass, dark, shiny
        lost |= _grain(shape, rng.uniform(2, 12) * wide, rng) > rng.uniform(1.2, 2.6)
    lost |= rng.random(shape) < rng.choice([0.0, 0.002, 0.02])
    return np.where(lost, 0.0, noisy)


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


def photograph(rgb: NDArray[np.uint8], rng: Rng) -> NDArray[np.uint8]:
    """Colours (H, W, 3) in another light: gain, gamma, tint, shadows, blur, noise; at times grey, or nothing."""
    if rng.random() < 0.08:
        return np.full_like(rgb, 128)
    image = (rgb / 255.0) ** rng.uniform(0.6, 1.5)
    if rng.random() < 0.1:
        image = np.repeat(image.mean(axis=-1, keepdims=True), 3, axis=-1)
    soft = 1 + rng.uniform(0, 0.25) * _grain(rgb.shape[:2], rng.uniform(6, 30) * rgb.shape[1] / 160, rng)
    image = image * soft.clip(0.2, 2)[..., None] * rng.uniform(0.6, 1.4) * (1 + rng.normal(0, 0.05, 3))
    if rng.random() < 0.3:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.3, 1.0))
    image = image + rng.normal(0, rng.uniform(0, 0.04), image.shape)
    return np.asarray((255 * image).clip(0, 255), dtype=np.uint8)


def tilt_frame(frame: Array, rng: Rng, tilt: float = TILT, off: float = OFF) -> Array:
    """`floor_from_camera` (4, 4) with the error of an estimate: degrees, and a share of the camera's height."""
    x, y = np.deg2rad(rng.normal(0, tilt, 2))
    turn = np.array([[1, 0, y], [0, 1, -x], [-y, x, 1]])
    left, _, right = np.linalg.svd(turn)
    return np.asarray(rigid(left @ right, [0, 0, rng.normal(0, off) * frame[2, 3]]) @ frame)


def sense_as_kinect(picture: Picture, rng: Rng) -> Array:
    """Depth (H, W) as the first Kinect measures it, metres; 0: unknown.

    Disparity is of eighths of a pixel at a focal length of 580 pixels and a base of 7.5 cm, so that steps grow as the
    square of depth, 2.9 mm at 1 m, and so does noise (Khoshelham and Oude Elberink 2012). Nothing is measured in the
    projector's shadow, at edges, at grazing sight, and on many dark or glossy things.
    """
    depth = picture.depth.astype(float)
    shape = depth.shape
    wide = shape[1] / 160
    per_metre = 580 * 0.075 * 8  # eighths of a pixel of disparity at 1 m
    rows, columns = np.indices(shape)
    spread = rng.uniform(0.3, 0.9)  # pixels by which edges are smeared
    row = np.clip(rows + np.rint(rng.normal(0, spread, shape)).astype(int), 0, shape[0] - 1)
    column = np.clip(columns + np.rint(rng.normal(0, spread, shape)).astype(int), 0, shape[1] - 1)
    moved = depth[row, column]
    disparity = per_metre / np.maximum(moved, 0.1) + rng.uniform(0.2, 0.8) * _grain(shape, wide, rng)
    noisy = per_metre / np.maximum(np.rint(disparity), 1.0) * (1 + rng.normal(0, 0.006))
    lost = (moved <= 0) | (noisy < 0.5) | (noisy > rng.choice([4.5, 8.0]))
    lost |= picture.cosine < 255 * rng.uniform(0.1, 0.3)
    lost |= _shadow(depth, wide * rng.uniform(2.0, 5.0))
    edges = np.asarray(cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))) > 0.05 * moved
    lost |= edges & (rng.random(shape) < rng.uniform(0.0, 0.8))
    for owner in np.unique(picture.owner[picture.owner > 1]):
        if rng.random() < 0.12:  # dark or glossy: seen in patches
            lost |= (picture.owner == owner) & (_grain(shape, rng.uniform(1, 6) * wide, rng) > rng.uniform(-1.0, 1.0))
    return np.where(lost, 0.0, noisy)
