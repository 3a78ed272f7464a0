"""The input of reconstruction: a picture with depth, masks and annotations."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import Annotations
from roomkin.stages.contracts.objects import DepthError
from roomkin.stages.contracts.scene_input import read_scene_input

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
