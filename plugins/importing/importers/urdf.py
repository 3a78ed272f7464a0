"""URDF, articulated or not."""

from pathlib import Path

from roomkin.plugins.importing.hinges import mark_buttons, read_semantics
from roomkin.plugins.importing.importers import Importer
from roomkin.stages.articulated.model import RobotModel
from roomkin.stages.articulated.urdf_reader import read_urdf


def read(path: Path, folder: Path) -> RobotModel:
    """The model of a URDF, its buttons marked."""
    return mark_buttons(read_urdf(path, folder), read_semantics(path, folder))


IMPORTER = Importer(read)
