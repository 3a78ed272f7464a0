"""What the page that corrects shows: things of a picture, and of one with depth that has no masks yet."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roomkin.stages.contracts import Annotations, Camera, read_json
from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.images import read_depth, read_rgb
from roomkin.stages.contracts.scene_input import SceneInput, write_scene_input
from roomkin.stages.contracts.types import Id
from roomkin.stages.perception.camera.surfaces import find_surfaces
from roomkin.stages.perception.read.frame import TILT
from roomkin.stages.perception.read.mask_pieces import remove_edges
from roomkin.stages.perception.segmentation.proposal import RoomView
from roomkin.stages.perception.write import FRAME_OPTIONS, write_config


class ShownThing(Correction):
    """An object, the floor or a wall as the page shows it, with every value and not only the corrected ones."""

    id: Id


class UnmatchedLine(Contract):
    """A correction of what is not found in the picture now, as the page shows it."""

    key: str
    text: str


class ShownPicture(Contract):
    """All that is in a picture, as a person sees it."""

    objects: list[ShownThing] = Field([], max_length=1000)
    unmatched: list[UnmatchedLine] = Field([], max_length=1000)


def name_drawn(mask: int) -> str:
    """The id of a thing that the folder's annotations do not name."""
    return f"drawn_{mask}"


def is_bare(folder: Path) -> bool:
    """Whether a folder has a picture with depth and no masks, as `perception from-rgbd` writes it without them."""
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
    """Make the folder an input folder, as `perception from-rgbd --masks` does."""
    depth = remove_edges(given.depth, masks)
    write_scene_input(folder, given.rgb, depth, given.camera, masks, annotations, given.exact)
    write_config(folder, **FRAME_OPTIONS)
