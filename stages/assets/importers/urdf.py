"""URDF, articulated or not."""

from stages.articulated.urdf_reader import read_urdf
from stages.assets.importers import Importer

IMPORTER = Importer(read_urdf)
