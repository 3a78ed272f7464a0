"""STL, as trimesh reads it."""

from plugins.importing.mesh_files.ply import read_plain
from stages.articulated.mesh_files import MeshReader

READER = MeshReader(read_plain)
