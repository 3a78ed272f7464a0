"""Readers of model files, one per suffix: the importer `glb` reads `.glb`, `mjcf` reads `.xml`."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from roomkin.stages.articulated.model import RobotModel

Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
IMPORTERS = (  # in this order, unless the config names others
    "roomkin.plugins.importing.importers.urdf",
    "roomkin.plugins.importing.importers.mjcf",
    "roomkin.plugins.importing.importers.glb",
    "roomkin.plugins.importing.importers.gltf",
    "roomkin.plugins.importing.importers.obj",
    "roomkin.plugins.importing.importers.dae",
    "roomkin.plugins.importing.importers.ply",
    "roomkin.plugins.importing.importers.stl",
)
MESH_FILES = (  # found by their suffix; named here so that an edit of one imports models anew
    "roomkin.plugins.importing.mesh_files.dae",
    "roomkin.plugins.importing.mesh_files.glb",
    "roomkin.plugins.importing.mesh_files.gltf",
    "roomkin.plugins.importing.mesh_files.ply",
    "roomkin.plugins.importing.mesh_files.stl",
)


@dataclass(frozen=True)
class Importer:
    """How a kind of file is read.

    read: from the file and the user's folder that it lies in (no path may lead out of it) to a model in the file's own
    frame and unit. up: direction up in such a file, unless the notes beside it say otherwise. has_up: whether such
    files are agreed to have one. suffix: of such files; None: the importer's name.
    """

    read: Callable[[Path, Path], RobotModel]
    up: Axis = "+z"
    has_up: bool = True
    suffix: str | None = None
