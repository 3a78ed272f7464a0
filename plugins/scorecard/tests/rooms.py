"""A room of the data set for tests: a table with a mug on it, a cabinet with a door at the wall, a chair."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from roomkin.plugins.scorecard.truth import PictureTruth, TrueThing, as_plain
from roomkin.stages.contracts import write_json
from roomkin.stages.geometry.frames import make_transform

TABLE = TrueThing(
    number=1, name="table", model="m_table", pack="p", kind="table", label="dining table", doors=0, drawers=0,
    symmetry="half_turn", position=(2.0, 2.0, 0.4), size=(0.8, 1.4, 0.8), yaw=0.2, support="floor", wall="",
    pixels=900, seen=1.0, cut=False, named=True,
)  # fmt: skip
MUG = replace(
    TABLE, number=2, name="mug", model="m_mug", kind="mug", label="cup", symmetry="full", position=(2.0, 2.2, 0.85),
    size=(0.1, 0.1, 0.1), yaw=0.0, support="1",
)  # fmt: skip
CABINET = replace(
    TABLE, number=3, name="cabinet", model="m_cabinet", kind="base_cabinet", label="cupboard", symmetry="none",
    position=(0.31, 1.0, 0.45), size=(0.6, 0.6, 0.9), yaw=0.0, wall="west", doors=1, opens=("left",),
)  # fmt: skip
CLUTTER = replace(TABLE, number=4, name="clutter", model="m_clutter", kind="clutter", label="", named=False)
# Level, at 1.4 m, looking along y: x right, y down, z forward.
POSE = make_transform([[1, 0, 0], [0, 0, 1], [0, -1, 0]], (2.0, 0.3, 1.4))
TRUTH = PictureTruth(
    name="toy_room_1", half="toy", kind="living", device="stereo", focal=500.0, size=(4.0, 4.0),
    world_from_camera=POSE.tolist(), things=[TABLE, MUG, CABINET, CLUTTER], joined={},
)  # fmt: skip
HEAD: dict[str, Any] = {
    "version": 1,
    "method": "mine",
    "given": ["depth"],
    "code": "here",
    "by": "me",
    "seen": "nothing",
}


def write_rooms(data: Path, *truths: PictureTruth) -> Path:
    """A data set of a set `toy`, with plain pictures."""
    for truth in truths or (TRUTH,):
        folder = data / "toy" / truth.name
        folder.mkdir(parents=True)
        write_json(folder / "truth.json", as_plain(truth))
        cv2.imwrite(str(folder / "rgb.png"), np.full((480, 640, 3), 200, np.uint8))
        cv2.imwrite(str(folder / f"depth_{truth.device}.png"), np.full((480, 640), 2000, np.uint16))
        masks = np.zeros((480, 640), np.uint16)
        for thing in truth.things:
            masks[100 * thing.number : 100 * thing.number + 60, 200:300] = thing.number
        cv2.imwrite(str(folder / "masks_exact.png"), masks)
        camera = {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 239.5}
        write_json(folder / "camera.json", camera)
    return data


def say(thing: TrueThing, **said: Any) -> dict[str, Any]:
    """A thing as it is submitted, in the world: right, but for what is said."""
    plain = {"name": thing.label, "center": list(thing.position), "size": list(thing.size), "yaw": thing.yaw}
    return plain | ({"opens": list(thing.opens)} if thing.opens else {}) | said


def room(*things: dict[str, Any], **said: Any) -> dict[str, Any]:
    """A room of a submission, in the frame of the truth's floor."""
    return {"frame": "floor", "floor_from_camera": POSE.tolist(), "things": list(things)} | said
