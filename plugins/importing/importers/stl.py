"""STL, rigid, without colors."""

from plugins.importing.importers import Importer
from plugins.importing.single_body import read_mesh

IMPORTER = Importer(read_mesh, has_up=False)
