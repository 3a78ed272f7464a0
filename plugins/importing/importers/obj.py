"""Wavefront OBJ."""

from roomkin.plugins.importing.importers import Importer
from roomkin.plugins.importing.single_body import read_mesh

IMPORTER = Importer(read_mesh, has_up=False)
