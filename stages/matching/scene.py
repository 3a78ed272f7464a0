"""Reading what extraction left of a scene: picture, masks, depth, and each object's view of them."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError, Objects, read_json
from stages.contracts.objects import SceneObject
from stages.matching.crop import View


class Scene:
    """`objects.json` with `masks.png` and `depth.npz` beside it, and the picture.

    Depth may be missing (then no normals are compared); masks may not.
    """

    def __init__(self, objects: Path, image: Path) -> None:
        self.objects = read_json(Objects, objects)
        folder = objects.parent
        self._rgb = np.ascontiguousarray(_image(image, cv2.IMREAD_COLOR)[..., ::-1])
        self._masks = _image(folder / "masks.png", cv2.IMREAD_UNCHANGED)
        self._depth = _depth(folder / "depth.npz")
        size = (self.objects.height, self.objects.width)
        arrays = {image: self._rgb, folder / "masks.png": self._masks, folder / "depth.npz": self._depth}
        for path, array in arrays.items():
            if array is not None and array.shape[:2] != size:
                raise InputError(path, f"has shape {array.shape[:2]}, objects.json says (height, width) = {size}.")
        if self._masks.ndim != 2:
            raise InputError(folder / "masks.png", "has several channels.", "one 16-bit channel holds the mask values")
        self._intrinsics = np.array(self.objects.intrinsics, dtype=float)
        self._up = np.array(self.objects.floor_from_camera, dtype=float)[2, :3]

    def view(self, item: SceneObject) -> View:
        """The object as the camera sees it; the mask may be empty."""
        return View(self._rgb, self._masks == item.mask, self._depth, self._intrinsics, self._up)


def _image(path: Path, mode: int) -> NDArray[Any]:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise InputError(path, "is no readable image." if path.is_file() else "no such file.")
    return np.asarray(image)


def _depth(path: Path) -> NDArray[np.float32] | None:
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return np.nan_to_num(arrays["depth"].astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(path, f"holds no readable array 'depth' ({error.__class__.__name__}).") from None
