"""The nodes of a glTF file: where its meshes stand, how often, and how their skins hold them."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from plugins.importing.mesh_files.accessors import Accessors, Header, Numbers
from stages.articulated.urdf_tree import MOST_SHAPES

INSTANCES, VISIBILITY = "EXT_mesh_gpu_instancing", "KHR_node_visibility"


class Placed(NamedTuple):
    """A mesh where it stands: (4, 4) in the scene's frame; how much of each morph target; (J, 4, 4) that carry it
    along with the joints of its skin, in the scene's frame, or None."""

    mesh: int
    transform: Numbers
    weights: tuple[float, ...]
    joints: Numbers | None


def place_meshes(header: Header, accessors: Accessors) -> list[Placed]:
    """All meshes of the file's scene, as its nodes stand.

    Raises:
        ValueError: they are too many.
    """
    nodes, found = header.get("nodes", []), list[Placed]()
    tops = set(range(len(nodes))) - {child for node in nodes for child in node.get("children", [])}
    scenes = header.get("scenes")
    roots = scenes[header.get("scene", 0)].get("nodes", []) if scenes else sorted(tops)
    frames = _frames(nodes, tops)
    for number, frame in _frames(nodes, roots, hidden=False).items():
        node = nodes[number]
        if "mesh" not in node:
            continue
        weights = tuple(node.get("weights") or header["meshes"][node["mesh"]].get("weights") or ())
        if "skin" in node:  # its own place does not count: the joints' do
            joints = _joints(header["skins"][node["skin"]], frames, accessors)
            found.append(Placed(node["mesh"], np.eye(4), weights, joints))
        else:
            found += [Placed(node["mesh"], frame @ one, weights, None) for one in _instances(node, accessors)]
        if len(found) > MOST_SHAPES:
            raise ValueError(f"it shows more than {MOST_SHAPES} meshes")
    return found


def _frames(nodes: list[Header], roots: Iterable[int], hidden: bool = True) -> dict[int, Numbers]:
    """(4, 4) of the nodes below some nodes in the frame of those; with what is hidden, or without."""
    frames, waiting = dict[int, Numbers](), [(root, np.eye(4)) for root in roots]
    while waiting:
        number, above = waiting.pop(0)
        node = nodes[number]
        if number in frames or not (hidden or node.get("extensions", {}).get(VISIBILITY, {}).get("visible", True)):
            continue
        frames[number] = above @ _transform(node)
        waiting += [(child, frames[number]) for child in node.get("children", [])]
    return frames


def _transform(node: Header) -> Numbers:
    """(4, 4) of a node in its parent's frame."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    parts = (
        node.get(key, usual) for key, usual in (("translation", [0, 0, 0]), ("rotation", None), ("scale", [1, 1, 1]))
    )
    place, turn, scale = parts
    return _matrices(np.array([place]), np.array([turn or [0, 0, 0, 1]]), np.array([scale]))[0]


def _matrices(places: Numbers, turns: Numbers, scales: Numbers) -> Numbers:
    """(N, 4, 4) of translations, quaternions x, y, z, w, and scales."""
    result = np.tile(np.eye(4), (len(places), 1, 1))
    result[:, :3, :3] = Rotation.from_quat(turns).as_matrix() * scales[:, None, :]
    result[:, :3, 3] = places
    return result


def _instances(node: Header, accessors: Accessors) -> Numbers:
    """(N, 4, 4) of the copies of a node's mesh, in its frame: itself, unless it is repeated."""
    attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
    columns = {
        name: accessors.read(attributes[name]) for name in ("TRANSLATION", "ROTATION", "SCALE") if name in attributes
    }
    if not columns:
        return np.eye(4)[None]
    count = len(next(iter(columns.values())))
    usual = {"TRANSLATION": [0.0, 0, 0], "ROTATION": [0.0, 0, 0, 1], "SCALE": [1.0, 1, 1]}
    return _matrices(*(columns.get(name, np.tile(one, (count, 1))) for name, one in usual.items()))


def _joints(skin: Header, frames: dict[int, Numbers], accessors: Accessors) -> Numbers:
    """(J, 4, 4) that carry what is bound to each joint to where the joint stands."""
    stand = np.array([frames[joint] for joint in skin["joints"]])
    if "inverseBindMatrices" not in skin:
        return stand
    return np.asarray(
        stand @ accessors.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)[: len(stand)]
    )
