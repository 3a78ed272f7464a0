"""A frame with depth and no masks yet: ground and walls by geometry, things by a person's clicks."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.proposal import RoomView
from plugins.eyes.surfaces import find_surfaces
from plugins.inputs.own_scene import write_config
from plugins.inputs.rgbd.edges import remove_edges
from plugins.inputs.rgbd.frame import TILT
from plugins.inputs.rgbd.write import FRAME_OPTIONS
from stages.contracts import Annotations, Camera, read_json
from stages.contracts.depth import read_depth
from stages.contracts.images import read_rgb
from stages.contracts.scene_input import SceneInput, write_scene_input


def is_bare(folder: Path) -> bool:
    """Whether a folder has a picture with depth and no masks, as `inputs from-rgbd` writes it without them."""
    return (folder / "depth.npz").is_file() and not (folder / "annotations.json").is_file()


def read_bare(folder: Path) -> SceneInput:
    """The frame with masks of its ground, 1, and its walls, from 2 on; nothing level is seen: with none."""
    camera, rgb = read_json(Camera, folder / "camera.json"), read_rgb(folder / "rgb.png")
    depth, exact = read_depth(folder / "depth.npz")
    masks = np.zeros(depth.shape, dtype=np.uint16)
    annotations = Annotations.model_construct(objects=[], floor=None, walls=[])  # what is drawn comes to it
    room = view_room(rgb, depth, camera)
    if room is not None:
        masks[room.surfaces.ground] = annotations.floor = 1
        for value, mask in enumerate(room.surfaces.wall_masks, 2):
            masks[mask] = value
            annotations.walls.append(value)
    return SceneInput(rgb, depth, masks, camera, annotations, exact)


def view_room(rgb: NDArray[np.uint8], depth: NDArray[np.float32], camera: Camera) -> RoomView | None:
    """A frame with its ground and walls; None: nothing level is seen."""
    intrinsics, known = np.array(camera.intrinsics, dtype=float), depth.astype(float)
    surfaces = find_surfaces(known, intrinsics, TILT)
    return None if surfaces is None else RoomView(rgb, known, intrinsics, surfaces)


def write_masks(folder: Path, given: SceneInput, masks: NDArray[np.uint16], annotations: Annotations) -> None:
    """Make the folder an input folder, as `inputs from-rgbd --masks` does."""
    depth = remove_edges(given.depth, masks)
    write_scene_input(folder, given.rgb, depth, given.camera, masks, annotations, given.exact)
    write_config(folder, **FRAME_OPTIONS)
