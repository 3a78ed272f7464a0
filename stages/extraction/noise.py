"""The input of reconstruction: a picture with depth, under a model of the errors that estimated depth has (A.7).

In this order: near and far depth run into each other at outlines ("artifacts near object
boundaries"); a smooth relative error grows towards the border ("and the image periphery"); range
noise with sigma(z) = a + b z^2, correlated over a few pixels; one factor on the whole picture,
because a single image does not fix its scale. Unknown pixels (0) stay unknown.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.inputs import DepthNoiseConfig
from roomkin.stages.contracts import Annotations
from roomkin.stages.contracts.objects import DepthError
from roomkin.stages.contracts.scene_input import read_scene_input

# A.7 names the errors and gives no numbers: these are chosen.
EDGE = 0.03  # relative jump of depth that makes an outline; chosen
QUIET = 0.8  # central part of the image without periphery error; chosen
PERIPHERY = 0.03  # relative error at the image border; chosen
DRIFT = 0.1  # of the image width, over which that error varies; chosen
CORRELATION = 6.0  # pixels over which the range noise varies: estimated depth errs in patches; chosen
BLEEDING = 1.0  # pixels over which near and far depth run into each other at outlines; chosen


def smooth_field(shape: tuple[int, int], sigma: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Gaussian noise of unit variance, correlated over `sigma` pixels."""
    smooth = np.asarray(cv2.GaussianBlur(rng.standard_normal(shape), (0, 0), sigma), dtype=np.float64)
    return smooth / smooth.std()


def blur_outlines(depth: NDArray[np.floating]) -> NDArray[np.floating]:
    """Blur depth (H, W) where it jumps."""
    depth = depth.astype(np.float64)
    kernel = np.ones((3, 3), np.uint8)
    jump = cv2.dilate(depth, kernel) - cv2.erode(depth, kernel) > EDGE * np.maximum(depth, 1e-6)
    reach = 2 * int(np.ceil(BLEEDING)) + 1
    near_edge = cv2.dilate(jump.astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
    known = (depth > 0).astype(float)
    weight = cv2.GaussianBlur(known, (0, 0), BLEEDING)
    blurred = cv2.GaussianBlur(depth, (0, 0), BLEEDING) / np.maximum(weight, 1e-9)
    return np.where(near_edge & (depth > 0), blurred, depth)


def periphery_ramp(shape: tuple[int, int]) -> NDArray[np.float64]:
    """0 in the central 80 % of the image, rising to 1 at its border."""
    height, width = shape
    v = np.abs(np.linspace(-1, 1, height))[:, None]
    u = np.abs(np.linspace(-1, 1, width))[None, :]
    return np.clip((np.maximum(u, v) - QUIET) / (1 - QUIET), 0, 1)


def noisy_depth(depth: NDArray[np.float32], options: DepthNoiseConfig, rng: np.random.Generator) -> NDArray[np.float32]:
    """Disturb perfect depth (H, W) in metres; the same generator state gives the same picture."""
    scale = 1 + options.scale * rng.standard_normal()
    z = blur_outlines(depth)
    drift = smooth_field(depth.shape, DRIFT * depth.shape[1], rng)
    z = z * (1 + PERIPHERY * periphery_ramp(depth.shape) * drift)
    sigma = options.range_constant + options.range_quadratic * z**2
    z = (z + sigma * smooth_field(depth.shape, CORRELATION, rng)) * scale
    return np.where(depth > 0, np.maximum(z, 1e-3), 0).astype(np.float32)


EXACT = DepthError(0.0, 0.0)  # a renderer's depth


@dataclass(frozen=True)
class AnnotatedImage:
    """One picture with all that is known of its pixels.

    rgb (H, W, 3) uint8; depth (H, W) float32 metres along the optical axis, 0: unknown;
    masks (H, W) uint16, values as named by `annotations`; intrinsics (3, 3) in pixels;
    depth_error: of `depth`, None: it is measured at floor and walls; floor_from_camera (4, 4) where it is known.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]
    intrinsics: NDArray[np.float64]
    annotations: Annotations
    depth_error: DepthError | None = None
    floor_from_camera: NDArray[np.float64] | None = None


def read_folder(folder: Path) -> AnnotatedImage:
    """The files of an input folder, checked (`roomkin.stages.contracts.scene_input`)."""
    given = read_scene_input(folder)
    intrinsics = np.array(given.camera.intrinsics, dtype=float)
    known = given.camera.floor_from_camera
    frame = None if known is None else np.array(known, dtype=float)
    error = EXACT if given.exact else None
    return AnnotatedImage(given.rgb, given.depth, given.masks, intrinsics, given.annotations, error, frame)
