"""glTF in one file; +y is up there."""

from roomkin.plugins.importing.importers import Importer
from roomkin.plugins.importing.single_body import read_mesh

IMPORTER = Importer(read_mesh, up="+y")
