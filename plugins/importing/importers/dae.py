"""COLLADA, rigid; in metres, and read as its file says which way is up."""

from pathlib import Path

import numpy as np

from roomkin.plugins.importing.importers import Importer
from roomkin.plugins.importing.mesh_files.dae import up_of
from roomkin.plugins.importing.single_body import read_mesh
from roomkin.stages.articulated.model import RobotModel, change_root
from roomkin.stages.geometry.frames import make_transform

TURNS = {  # rows: x, y and z of a model whose file faces +z, as with glTF
    "X_UP": [[0, 0, 1], [0, -1, 0], [1, 0, 0]],
    "Y_UP": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
}


def read_dae(path: Path, folder: Path) -> RobotModel:
    """A file as a thing of one link, z up; a file that does not say what is up has y up, as COLLADA wants it.

    Raises:
        InputError: it cannot be read, or is flat.
    """
    robot, up = read_mesh(path, folder), up_of(path) or "Y_UP"
    return change_root(robot, make_transform(np.array(TURNS[up], dtype=float), np.zeros(3))) if up in TURNS else robot


IMPORTER = Importer(read_dae)
