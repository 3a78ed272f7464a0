"""PLY, as trimesh reads it."""

from pathlib import Path

import trimesh
from trimesh import Scene

from roomkin.stages.articulated.mesh_files import MeshReader
from roomkin.stages.articulated.mesh_resolver import MeshResolver


def read_plain(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of a file."""
    return trimesh.load_scene(path, resolver=files), []


READER = MeshReader(read_plain)
