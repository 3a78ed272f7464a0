"""Readers of mesh files, which report what they leave out: a module per suffix, with its `READER`.

The core has that of its own assets, OBJ; others are in packages (docs/your-models.md).
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from trimesh import Scene

from roomkin.stages.articulated.mesh_resolver import MeshResolver


class MeshReader(NamedTuple):
    """How a kind of file is read.

    read: from the file, and what resolves the files that it names, to plain triangles; and what of it is lost, a line
    each. up: the direction up that a file says, X_UP, Y_UP or Z_UP; empty: it says none, as most.
    """

    read: Callable[[Path, MeshResolver], tuple[Scene, list[str]]]
    up: Callable[[Path], str] = lambda path: ""
