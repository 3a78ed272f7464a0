"""glTF in several files; +y is up there."""

from plugins.importing.importers import Importer
from plugins.importing.single_body import read_mesh

IMPORTER = Importer(read_mesh, up="+y")
