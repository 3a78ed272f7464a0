"""What the common steps start from, and the checked reading of an input folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.contracts import Annotations, Camera, InputError, read_json


@dataclass(frozen=True)
class AnnotatedImage:
    """One picture with all that is known of its pixels.

    rgb (H, W, 3) uint8; depth (H, W) float32 metres along the optical axis, 0: unknown;
    masks (H, W) uint16, values as named by `annotations`; intrinsics (3, 3) in pixels; exact: the depth
    has no error at all, as a renderer's.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]
    intrinsics: NDArray[np.float64]
    annotations: Annotations
    exact: bool = False


K_FORM = "write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels"


def _image(path: Path, flags: int) -> NDArray[Any]:
    if not path.is_file():
        raise InputError(path, "no such file.", "see docs/scenes.md for what an input folder holds")
    image = cv2.imdecode(np.fromfile(path, dtype=np.uint8), flags) if path.stat().st_size else None
    if image is None:
        raise InputError(path, "is not a readable image.", "save it again as PNG")
    return image


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """An 8-bit picture (H, W, 3); grey is repeated, an alpha channel is laid on white."""
    image = _image(path, cv2.IMREAD_UNCHANGED)
    if image.dtype != np.uint8:
        raise InputError(path, f"has {image.dtype} pixels.", "save it with 8 bits per channel")
    if image.ndim == 2:
        return np.repeat(image[..., None], 3, axis=2)
    if image.shape[2] == 4:
        alpha = image[..., 3:] / 255.0
        image = np.rint(image[..., :3] * alpha + 255.0 * (1 - alpha)).astype(np.uint8)
    return np.ascontiguousarray(image[..., ::-1])


def read_masks(path: Path) -> NDArray[np.uint16]:
    """A one-channel label image (H, W)."""
    image = _image(path, cv2.IMREAD_UNCHANGED)
    if image.ndim != 2:
        raise InputError(
            path, f"has {image.shape[2]} channels.", "write one channel of 16 bits with a value per object"
        )
    return image.astype(np.uint16)


def read_depth(path: Path) -> tuple[NDArray[np.float32], bool]:
    """The array `depth` of an npz file (negative and non-finite values become 0, unknown), and its flag `exact`."""
    if not path.is_file():
        raise InputError(path, "no such file.", "see docs/scenes.md for what an input folder holds")
    try:
        with np.load(path, allow_pickle=False) as arrays:
            depth = np.asarray(arrays["depth"], dtype=np.float32)
            exact = bool(arrays["exact"]) if "exact" in arrays else False
    except KeyError:
        raise InputError(path, "has no array named 'depth'.", "np.savez(path, depth=...)") from None
    except Exception as error:  # numpy and zipfile raise many kinds for a broken file
        raise InputError(path, f"is not a readable npz file ({error.__class__.__name__}).") from None
    if depth.ndim != 2:
        raise InputError(path, f"depth has shape {depth.shape}.", "write an array (height, width) in metres")
    return np.where(np.isfinite(depth) & (depth > 0), depth, 0).astype(np.float32), exact


def read_camera(path: Path) -> tuple[Camera, NDArray[np.float64]]:
    """The camera and its K as an array."""
    camera = read_json(Camera, path)
    if len(camera.intrinsics) != 3 or any(len(row) != 3 for row in camera.intrinsics):
        raise InputError(
            path, "intrinsics is not a 3x3 matrix.", "write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels"
        )
    matrix = np.array(camera.intrinsics, dtype=float)
    if not np.isfinite(matrix).all() or matrix[0, 0] <= 0 or matrix[1, 1] <= 0 or not np.allclose(matrix[2], [0, 0, 1]):
        raise InputError(
            path, "intrinsics is not a camera matrix.", "write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels"
        )
    return camera, matrix


def read_folder(folder: Path) -> AnnotatedImage:
    """Read and cross-check rgb.png, camera.json, depth.npz, masks.png and annotations.json.

    Raises:
        InputError: a file is missing, broken, or disagrees with the others; the file is named.
    """
    rgb = read_rgb(folder / "rgb.png")
    camera, intrinsics = read_camera(folder / "camera.json")
    (depth, exact), masks = read_depth(folder / "depth.npz"), read_masks(folder / "masks.png")
    annotations = read_json(Annotations, folder / "annotations.json")
    size = (camera.height, camera.width)
    for name, shape in (("rgb.png", rgb.shape[:2]), ("depth.npz", depth.shape), ("masks.png", masks.shape)):
        if shape != size:
            raise InputError(
                folder / name,
                f"is {shape[1]}x{shape[0]} pixels, but camera.json says {size[1]}x{size[0]}.",
                "all files of an input folder have one size",
            )
    values = [item.mask for item in annotations.objects] + annotations.walls
    values += [] if annotations.floor is None else [annotations.floor]
    if min(values, default=1) < 1 or len(set(values)) < len(values):
        raise InputError(folder / "annotations.json", "mask values must be 1 or more, each used once.")
    return AnnotatedImage(rgb, depth, masks, intrinsics, annotations, exact)
