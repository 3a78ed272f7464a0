"""STL."""

from plugins.importing.mesh_files.ply_off import read_stl
from stages.articulated.mesh_files import MeshReader

READER = MeshReader(read_stl)
