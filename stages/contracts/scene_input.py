"""The input folder of a scene: rgb.png, camera.json, depth.npz, masks.png, annotations.json, checked together."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, write_atomically, write_json
from roomkin.stages.contracts.images import check_shown, check_size, orientation_of, read_depth, read_masks, read_rgb
from roomkin.stages.contracts.scenes import Annotations, Camera
from roomkin.stages.contracts.things import read_things
from roomkin.stages.geometry.depth_forms import find_flatter


@dataclass(frozen=True)
class SceneInput:
    """One picture with all that is known of its pixels.

    rgb (H, W, 3) uint8; depth (H, W) float32 metres along the optical axis, 0: unknown;
    masks (H, W) uint16, values as named by `annotations`; exact: the depth has no error at all, as a renderer's.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]
    camera: Camera
    annotations: Annotations
    exact: bool


def read_scene_input(folder: Path) -> SceneInput:
    """Read and cross-check the five files. Mask values that have no name in `annotations.json`, nor are left out in
    `things.json`, are printed.

    Raises:
        InputError: a file is missing, broken, or disagrees with the others; the file is named.
    """
    camera = read_json(Camera, folder / "camera.json")
    rgb, depth, exact = _pictures(folder, camera)
    annotations, masks = read_annotations(folder / "annotations.json")
    if camera.floor_from_camera is None and any(
        item.box is not None or item.front is not None for item in annotations.objects
    ):
        what = "has box or front of an object, in the floor frame, but camera.json has no floor_from_camera."
        fix = "write floor_from_camera, or leave out box and front"
        raise InputError(folder / "annotations.json", what, fix, code="E-FLOOR-FRAME")
    check_size(folder / "masks.png", masks, camera.width, camera.height, "camera.json")
    found = read_things(folder)
    left_out = [item.mask for item in found.left_out] if found else []
    nameless = sorted(set(np.unique(masks).tolist()) - {0, *annotations.values, *left_out})
    if nameless:
        values = ", ".join(map(str, nameless[:8])) + (", ..." if nameless[8:] else "")
        print(f"{folder / 'masks.png'}: annotations.json does not name the mask values {values}: they are not used")
    return SceneInput(rgb, depth, masks, camera, annotations, exact)


def write_scene_input(
    folder: Path,
    rgb: NDArray[np.uint8],
    depth: NDArray[np.float32],
    camera: Camera,
    masks: NDArray[np.uint16] | None = None,
    annotations: Annotations | None = None,
    exact: bool = False,
) -> None:
    """Write the five files, see `SceneInput`; without masks and annotations the first three alone."""
    with write_atomically(folder / "rgb.png") as path:
        cv2.imwrite(str(path), rgb[..., ::-1])
    with write_atomically(folder / "depth.npz") as path:
        arrays: dict[str, Any] = {"depth": depth} | ({"exact": np.array(True)} if exact else {})
        np.savez_compressed(path, **arrays)
    write_json(folder / "camera.json", camera)
    if masks is not None:
        with write_atomically(folder / "masks.png") as path:
            cv2.imwrite(str(path), masks)
    if annotations is not None:
        write_json(folder / "annotations.json", annotations)


def _pictures(folder: Path, camera: Camera) -> tuple[NDArray[np.uint8], NDArray[np.float32], bool]:
    rgb = read_rgb(folder / "rgb.png")
    check_shown(folder / "rgb.png", rgb)
    check_size(folder / "rgb.png", rgb, camera.width, camera.height, "camera.json")
    depth, exact = read_depth(folder / "depth.npz")
    check_size(folder / "depth.npz", depth, camera.width, camera.height, "camera.json")
    if (turned := orientation_of(folder / "rgb.png")) > 1:
        print(f"{folder / 'rgb.png'}: is turned by its EXIF data ({turned}); depth and masks are taken to be upright")
    bent = "" if exact else find_flatter(depth, np.array(camera.intrinsics, dtype=float))
    if bent == "ray":
        doubt = "floor and walls are flat if it is the distance along each pixel's ray"
        print(f"{folder / 'depth.npz'}: in doubt: {doubt}")
    return rgb, depth, exact


def read_annotations(path: Path) -> tuple[Annotations, NDArray[np.uint16]]:
    """annotations.json and the masks.png beside it, which shows at least one of its objects."""
    annotations = read_json(Annotations, path)
    masks = read_masks(path.with_name("masks.png"))
    found = set(np.unique(masks).tolist())
    if not found & {item.mask for item in annotations.objects}:
        values = ", ".join(map(str, sorted(found)[:8]))
        what = f"shows no object of annotations.json: its values are {values}."
        fix = "objects.mask is the value of the object's pixels"
        raise InputError(path.with_name("masks.png"), what, fix, code="E-MASK-VALUE")
    return annotations, masks


def check_camera(path: Path) -> None:
    """camera.json, and the picture and depth beside it."""
    _pictures(path.parent, read_json(Camera, path))
