"""STL, as trimesh reads it."""

from roomkin.plugins.importing.mesh_files.ply import read_plain
from roomkin.stages.articulated.mesh_files import MeshReader

READER = MeshReader(read_plain)
