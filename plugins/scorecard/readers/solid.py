"""A thing as a surface: its box along its own axes, and that surface in it."""

from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.plugins.scorecard.truth import About, RoomScene, SubmittedRoom
from roomkin.stages.geometry.frames import make_transform, yaw_matrix

Floats = NDArray[np.float64]
THIN = 1e-3  # metres: no extent is less


def find_yaw(rotation: Floats) -> float:
    """The heading, radians, of a thing's front: its own x axis if its z axis is upright, as in URDF and MJCF; its own
    z axis if y is, as in glTF.

    Args:
        rotation: (3, 3) of its own axes in a frame with z up.
    """
    upright = int(np.argmax(np.abs(rotation[2])))
    front = rotation[:, 2] if upright == 1 else rotation[:, 0] if upright == 2 else rotation[:, 1]
    return float(np.arctan2(front[1], front[0]))


def describe_solid(
    name: str, meshes: list[trimesh.Trimesh], rotation: Floats
) -> tuple[dict[str, Any], trimesh.Trimesh]:
    """A thing for a submission, and its surface in the frame of its box.

    Args:
        meshes: its parts, in a frame with z up, metres.
        rotation: (3, 3) of its own axes there.
    """
    yaw = find_yaw(rotation)
    turn = yaw_matrix(yaw)
    bare = [trimesh.Trimesh(mesh.vertices, mesh.faces, process=False) for mesh in meshes]
    whole = trimesh.util.concatenate(bare).apply_transform(make_transform(turn.T, np.zeros(3)))
    low, high = whole.bounds
    size = np.maximum(high - low, THIN)
    thing = {"name": name, "center": (turn @ ((low + high) / 2)).tolist(), "size": size.tolist(), "yaw": yaw}
    return thing, whole.apply_translation(-(low + high) / 2)


def make_scene(
    things: list[dict[str, Any]], camera: Floats, about: About, solids: dict[int, trimesh.Trimesh] | None = None
) -> RoomScene:
    """A scene in a floor frame of its own, in metres if its method was given a length.

    Args:
        things: as a submission has them.
        camera: (4, 4) its pose there: x right, y down, z forward.
        solids: surfaces by place in `things`.
    """
    scale = "metric" if {"depth", "length"} & {*about.given} else "free"
    room = {"frame": "floor", "floor_from_camera": camera.tolist(), "scale": scale, "things": things}
    return RoomScene(SubmittedRoom.model_validate(room), solids or {})
