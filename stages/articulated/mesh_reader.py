"""Read mesh files with trimesh, and cut them into convex pieces to collide."""

import importlib.util
import json
import struct
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image
from trimesh import Trimesh

from stages.contracts.errors import InputError

SUFFIXES = {".obj", ".glb", ".gltf", ".stl", ".ply", ".dae", ".off"}
DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
MOST_PIECES = 64
FLAT = 1e-4  # metres: a piece thinner than this gets that thickness
FARTHEST = 1e6  # coordinates beyond it are a slip, in whatever unit


def load_meshes(path: Path) -> list[Trimesh]:
    """All meshes of a file, in the file's own frame.

    Raises:
        InputError: the file is of no known kind, cannot be read, or holds no triangle that has an area.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(path, f"'{path.suffix}' is not a mesh file that is read here.", ", ".join(sorted(SUFFIXES)))
    _check_uncompressed(path)
    try:
        scene = trimesh.load_scene(path)
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, Trimesh) and len(mesh.faces)]
    except Exception as error:  # mesh readers raise whatever they stumble over
        reason = (str(error).splitlines() or [error.__class__.__name__])[0][:200]
        raise InputError(path, f"cannot be read as a mesh: {reason}.") from None
    vertices = [np.asarray(mesh.vertices) for mesh in meshes]
    if not all(np.isfinite(points).all() and np.abs(points).max() < FARTHEST for points in vertices):
        raise InputError(path, f"has coordinates that are no numbers or beyond {FARTHEST:g}.")
    meshes = [mesh for mesh in meshes if mesh.area > 0]
    if not meshes:
        raise InputError(path, "holds no triangles that have an area.")
    return meshes


def _check_uncompressed(path: Path) -> None:
    """Refuse glTF that trimesh would read as zeros.

    Raises:
        InputError: says what would read it.
    """
    if path.suffix.lower() not in (".glb", ".gltf"):
        return
    try:
        data = path.read_bytes()
        text = data[20 : 20 + struct.unpack("<I", data[12:16])[0]] if data[:4] == b"glTF" else data
        needed = json.loads(text).get("extensionsRequired", [])
    except (OSError, ValueError, struct.error, AttributeError):  # said when it is read
        return
    if DRACO in needed and importlib.util.find_spec("DracoPy") is None:
        raise InputError(path, f"is compressed ({DRACO}).", "pip install DracoPy, or export it uncompressed")
    if MESHOPT in needed:
        raise InputError(path, f"is compressed ({MESHOPT}).", "export it uncompressed")


def texture_of(mesh: Trimesh) -> Image.Image | None:
    """The image that the mesh comes with."""
    material = getattr(mesh.visual, "material", None)
    images = (getattr(material, key, None) for key in ("image", "baseColorTexture"))
    return next((image for image in images if image is not None and not _is_placeholder(image)), None)


def has_texture(mesh: Trimesh) -> bool:
    """Whether the mesh comes with an image."""
    return texture_of(mesh) is not None


def _is_placeholder(image: Image.Image) -> bool:
    """Whether trimesh made up the image, for a material whose file is missing."""
    made_up = trimesh.visual.material.empty_material().image
    return bool(image.size == made_up.size and image.tobytes() == made_up.tobytes())


def convex_pieces(mesh: Trimesh) -> list[Trimesh]:
    """Convex hulls of the mesh's connected bodies, or one hull if there are too many."""
    welded = Trimesh(mesh.vertices, mesh.faces, process=True)
    bodies = welded.split(only_watertight=False)
    if not 1 <= len(bodies) <= MOST_PIECES:
        bodies = [welded]
    return [_hull(body) for body in bodies if len(body.vertices) >= 3]


def thickened(mesh: Trimesh) -> Trimesh:
    """The convex piece, or the box around it if it is too thin to collide."""
    if mesh.extents.min() >= FLAT:
        return mesh
    center, size = mesh.bounds.mean(axis=0), np.maximum(mesh.extents, FLAT)
    return trimesh.creation.box(bounds=np.array([center - size / 2, center + size / 2]))


def _hull(mesh: Trimesh) -> Trimesh:
    if mesh.extents.min() < FLAT:
        return thickened(mesh)
    try:
        return mesh.convex_hull
    except Exception:  # qhull: all points in a slanted plane
        return trimesh.creation.box(bounds=mesh.bounds)
