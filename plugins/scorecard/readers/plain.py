"""The JSON of the scorecard itself, and the meshes that its things name."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from roomkin.plugins.scorecard.truth import RoomScene, SubmittedRoom
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import Y_UP, invert_transform, make_transform, yaw_matrix

LARGEST = 50_000_000  # bytes of a mesh
FORWARD = make_transform(yaw_matrix(np.pi / 2), np.zeros(3))  # from front -y to front +x
TURNS = {".glb": FORWARD @ invert_transform(Y_UP), ".obj": np.eye(4)}


def read(document: Any, folder: Path) -> RoomScene:
    """A room, with the meshes of its things.

    Args:
        document: as JSON has it.
        folder: that the JSON lies in; its meshes lie there or below.

    Raises:
        ValidationError: it does not say what it must.
        InputError: a mesh is missing, broken, or elsewhere.
    """
    room = SubmittedRoom.model_validate(document)
    return RoomScene(room, {place: read_mesh(folder, one.mesh) for place, one in enumerate(room.things) if one.mesh})


def read_mesh(folder: Path, name: str) -> trimesh.Trimesh:
    """The surface in a GLB (y up, front +z) or OBJ (z up, front +x), around the middle of its box: z up, front +x.

    It is read from its bytes alone: no file that it names is opened.

    Raises:
        InputError: it is missing, too large, broken, or lies outside the folder, also by a link.
    """
    path = (folder / name.replace("\\", "/")).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise InputError(name, "lies outside the submission's folder.", "copy it there", code="E-FILE-OUTSIDE")
    if path.suffix.casefold() not in TURNS or not path.is_file() or path.stat().st_size > LARGEST:
        what = f"is no GLB or OBJ of {LARGEST // 10**6} MB at most beside the JSON."
        raise InputError(name, what, "mend `mesh`", code="E-FILE-UNREADABLE")
    kind = path.suffix.casefold()
    try:
        scene = trimesh.load_scene(io.BytesIO(path.read_bytes()), file_type=kind[1:], skip_materials=True)
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
        bare = [trimesh.Trimesh(mesh.vertices, mesh.faces, process=False) for mesh in meshes]
        whole = trimesh.util.concatenate(bare).apply_transform(TURNS[kind])
        return whole.apply_translation(-whole.bounds.mean(axis=0))
    except Exception as error:  # a library's, on a file from elsewhere
        raise InputError(name, f"has no mesh that can be read ({error}).", code="E-FILE-UNREADABLE") from None
