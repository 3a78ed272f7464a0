"""PLY, rigid."""

from stages.assets.importers import Importer
from stages.assets.single_body import read_mesh

IMPORTER = Importer(read_mesh, has_up=False)
