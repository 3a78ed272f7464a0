"""Reading what extraction left of a scene: picture, masks, depth, and each object's view of them."""

from pathlib import Path

import numpy as np

from roomkin.stages.contracts import Objects, read_json
from roomkin.stages.contracts.extracted import read_metres, read_object_masks
from roomkin.stages.contracts.images import check_size, read_rgb
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.crop import View


class Scene:
    """`objects.json` with `masks.png` and `depth.npz` beside it, and the picture.

    Depth may be missing (then no normals are compared); masks may not.
    """

    def __init__(self, objects: Path, image: Path) -> None:
        self.objects = read_json(Objects, objects)
        self._rgb = read_rgb(image)
        check_size(image, self._rgb, self.objects.width, self.objects.height, objects.name)
        self._masks = read_object_masks(objects, self.objects)
        self._depth = read_metres(objects, self.objects)
        self._intrinsics = np.array(self.objects.intrinsics, dtype=float)
        self._up = np.array(self.objects.floor_from_camera, dtype=float)[2, :3]

    def view(self, item: SceneObject) -> View:
        """The object as the camera sees it; the mask may be empty."""
        return View(self._rgb, self._masks == item.mask, self._depth, self._intrinsics, self._up)
