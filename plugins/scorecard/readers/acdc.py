"""What the paper's authors' code writes: scene_<n>_info.json (github.com/cremebrule/digital-cousins, generation.py).

It holds the pose of each object's root link, not of its box: that origin is taken for the box's center, which models of
that library have close to it. Written from the code; no output of it was at hand.
"""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.plugins.scorecard.truth import RoomScene, SubmittedRoom
from roomkin.stages.geometry.frames import OPENGL, make_transform, yaw_of_matrix


def read(document: dict[str, Any]) -> RoomScene:
    """The objects of a scene, in its floor frame: z up, the camera at `cam_pose` (position, quaternion xyzw), which
    looks along its -z; `tf_from_cam` (4, 4) is that of an object in the camera's frame."""
    position, quaternion = document["cam_pose"]
    floor_from_view = make_transform(Rotation.from_quat(quaternion).as_matrix(), position)
    things = []
    for item in document["objects"].values():
        pose = floor_from_view @ np.array(item["tf_from_cam"], dtype=float)
        mount = item.get("mount") or {}
        hangs = bool(mount.get("wall")) and not mount.get("floor")
        size = [float(extent) for extent in item["bbox_extent"]]
        thing = {"name": str(item["category"]), "center": pose[:3, 3].tolist(), "size": size}
        things.append(thing | {"yaw": yaw_of_matrix(pose[:3, :3]), "support": "wall" if hangs else None})
    room = {"frame": "floor", "floor_from_camera": (floor_from_view @ OPENGL).tolist(), "things": things}
    return RoomScene(SubmittedRoom.model_validate(room))
