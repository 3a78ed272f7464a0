"""What the page that corrects shows of a picture, and the corrections.json that it reads and writes."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roomkin.stages.contracts import Annotations, Camera, read_json
from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.hand import (
    CORRECTIONS,
    MEASURED,
    Correction,
    Corrections,
    Unmatched,
    digest_of_picture,
    find_hand_file,
    read_corrections,
)
from roomkin.stages.contracts.images import read_depth, read_rgb
from roomkin.stages.contracts.matched import digest_masks, match_corrections, show_masks
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


class Said:
    """What a person said of the picture of a folder; `path`: where that is kept."""

    def __init__(self, folder: Path) -> None:
        self._digest = digest_of_picture(folder)
        self.path = find_hand_file(folder, CORRECTIONS, lambda: self._digest)
        self._unmatched: dict[str, Unmatched] = {}  # by keys: all that the page may have seen

    def read(self, masks: NDArray[np.uint16]) -> tuple[dict[int, Correction], list[UnmatchedLine]]:
        """The corrections by the values of masks (H, W); those of what is not found there now.

        Raises:
            InputError: what was saved is broken.
        """
        saved = read_corrections([self.path] if self.path.is_file() else [])
        matched = match_corrections(saved, masks, self._digest)
        keys = [sha256(one.model_dump_json().encode()).hexdigest()[:12] for one in matched.unmatched]
        self._unmatched |= zip(keys, matched.unmatched, strict=True)
        return matched.corrections, [UnmatchedLine(key=key, text=matched.lines[k]) for k, key in enumerate(keys)]

    def state(
        self,
        corrections: Sequence[Correction],
        unmatched: Sequence[UnmatchedLine],
        masks: NDArray[np.uint16],
        labels: Mapping[int, str],
    ) -> Corrections:
        """What is to be written: with the picture, and what the masks (H, W), called by `labels`, show."""
        named = {mask for item in corrections for mask in item.named_masks}
        return Corrections(
            digest=self._digest,
            size=(masks.shape[1], masks.shape[0]),
            masks=digest_masks(masks),
            shown=show_masks(named, masks, labels),
            objects=list(corrections),
            unmatched=[self._unmatched[one.key] for one in unmatched],
        )


def find_changes(before: Correction, now: ShownThing) -> dict[str, Any]:
    """What a person says otherwise of a thing than was found."""
    given = now.model_dump(exclude={"id", "mask", "gone"}, exclude_defaults=True)
    changes = {name: value for name, value in given.items() if getattr(now, name) != getattr(before, name)}
    return changes | ({"mounting": MEASURED} if before.mounting is not None and now.mounting is None else {})
