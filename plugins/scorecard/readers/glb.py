"""A binary glTF whose nodes are things: those below its root. y is up; the camera is a node called `camera` or
`input_camera`, or stands at the origin and looks along -z."""

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from roomkin.plugins.scorecard.readers.solid import describe_solid, make_scene
from roomkin.plugins.scorecard.truth import About, RoomScene
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import OPENGL, Y_UP, invert_transform

CAMERAS = ("camera", "input_camera")
ROOM = re.compile(r"(floor|ceiling|wall|ground)[\W_\d]*", re.IGNORECASE)


def read(path: Path, about: About) -> RoomScene:
    """The things of a GLB. It is read from its bytes alone: no file that it names is opened.

    A node's name is the thing's, or `category` or `label` in its extras.

    Raises:
        InputError: it has no thing.
    """
    scene = trimesh.load_scene(io.BytesIO(path.read_bytes()), file_type="glb")
    graph = scene.graph
    tree: dict[str, list[str]] = {}
    for child, parent in graph.transforms.parents.items():
        tree.setdefault(parent, []).append(child)
    z_up = invert_transform(Y_UP)
    things, solids = list[dict[str, Any]](), dict[int, trimesh.Trimesh]()
    camera = np.eye(4)
    for node in sorted(_list_things(tree, str(graph.base_frame), graph.nodes_geometry)):
        pose = z_up @ graph.get(node)[0]
        edge = graph.transforms.edge_data[graph.transforms.parents[node], node]
        about_node = edge.get("metadata") or {}
        if node.casefold() in CAMERAS:
            camera = graph.get(node)[0]
            continue
        meshes = [
            scene.geometry[graph[below][1]].copy().apply_transform(z_up @ graph[below][0])
            for below in _list_below(tree, node)
            if below in graph.nodes_geometry
        ]
        meshes = [mesh for mesh in meshes if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
        if not meshes or ROOM.fullmatch(node) or about_node.get("surface"):
            continue
        name = str(about_node.get("category") or about_node.get("label") or node)
        thing, solids[len(things)] = describe_solid(name, meshes, pose[:3, :3])
        things.append(thing)
    if not things:
        raise InputError(path.name, "has no node that is a thing.", "a node below the root for each", code="E-FORMAT")
    return make_scene(things, z_up @ camera @ OPENGL, about, solids)


def _list_things(tree: dict[str, list[str]], root: str, shown: list[str]) -> list[str]:
    """The nodes below the root; below a node that alone holds all, as some programs put over everything."""
    below = tree.get(root, [])
    return _list_things(tree, below[0], shown) if len(below) == 1 and below[0] not in shown else below


def _list_below(tree: dict[str, list[str]], node: str) -> list[str]:
    return [node, *(other for child in tree.get(node, []) for other in _list_below(tree, child))]
