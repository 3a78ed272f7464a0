"""glTF with files beside it."""

from roomkin.plugins.importing.mesh_files.gltf_file import read_gltf
from roomkin.stages.articulated.mesh_files import MeshReader

READER = MeshReader(read_gltf)
