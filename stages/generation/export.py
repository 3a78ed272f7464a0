"""The scene as one GLB, for viewers and other simulators."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import trimesh

from stages.contracts import atomic
from stages.generation.meshes import visual_meshes
from stages.generation.placed import Placed
from stages.geometry.frames import rigid, yaw_matrix

Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # glTF's up axis is y


def write_glb(items: list[Placed], folders: Mapping[str, Path], out: Path) -> None:
    """Write every item's visual meshes at its place, one node per object. Units are metres, y is up as glTF wants."""
    scene = trimesh.Scene()
    for item in items:
        middle = (np.asarray(item.asset.box_min) + np.asarray(item.asset.box_max)) / 2
        turn = yaw_matrix(item.box.yaw)
        pose = Y_UP @ rigid(turn, item.center - turn @ middle)
        scene.graph.update(frame_to=item.id, frame_from="world", matrix=pose)
        for index, mesh in enumerate(visual_meshes(folders[item.id])):
            name = f"{item.id}_{index}"
            scene.add_geometry(mesh, node_name=name, geom_name=name, parent_node_name=item.id)
    with atomic(out) as path:
        path.write_bytes(scene.export(file_type="glb"))
