"""URDF, articulated or not."""

from pathlib import Path

from plugins.importing.buttons import mark_buttons, read_semantics
from plugins.importing.importers import Importer
from stages.articulated.model import RobotModel
from stages.articulated.urdf_reader import read_urdf


def read(path: Path, folder: Path) -> RobotModel:
    """The model of a URDF, its buttons marked."""
    return mark_buttons(read_urdf(path, folder), read_semantics(path, folder))


IMPORTER = Importer(read)
