"""URDF, articulated or not."""

from plugins.importing.importers import Importer
from stages.articulated.urdf_reader import read_urdf

IMPORTER = Importer(read_urdf)
