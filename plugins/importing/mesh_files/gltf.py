"""glTF with files beside it."""

from plugins.importing.mesh_files.gltf_file import read_gltf
from stages.articulated.mesh_files import MeshReader

READER = MeshReader(read_gltf)
