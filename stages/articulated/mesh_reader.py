"""Read mesh files with trimesh, and cut them into convex pieces to collide."""

import importlib.util
import json
import re
import struct
from base64 import b64decode
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image
from trimesh import Trimesh

from stages.articulated.beside import Beside, fault_of
from stages.articulated.urdf_tree import LARGEST, MOST_SHAPES
from stages.contracts.errors import InputError

SUFFIXES = {".obj", ".glb", ".gltf", ".stl", ".ply", ".dae", ".off"}
DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
NO_NUMBER = re.compile(rb"^v\s[^\n]*(?:nan|inf)", re.IGNORECASE | re.MULTILINE)
MOST_PIECES = 64
TEXTURES = ("baseColorTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture", "emissiveTexture")
FLAT = 1e-4  # metres: a piece thinner than this gets that thickness


def load_meshes(path: Path, folder: Path) -> tuple[list[Trimesh], list[str]]:
    """All meshes of a file, in the file's own frame; and what of their looks is lost, a line each.

    Args:
        path: of the file.
        folder: no picture or material is read outside of it.

    Raises:
        InputError: the file is of no known kind, cannot be read, or holds no triangle that has an area.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(
            path,
            f"'{path.suffix}' is not a mesh file that is read here.",
            ", ".join(sorted(SUFFIXES)),
            code="E-MESH-KIND",
        )
    header, binary = _gltf(path)
    _check_uncompressed(path, header)
    if isinstance(nodes := header.get("nodes"), list) and len(nodes) > MOST_SHAPES:
        raise InputError(path, f"has {len(nodes)} nodes.", f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")
    files, lost = Beside(path, folder), _lost_inside(path, header, binary)
    try:
        scene = trimesh.load_scene(path, resolver=files)
        if lost:
            _drop_broken(scene.geometry.values())
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, Trimesh) and len(mesh.faces)]
    except Exception as error:  # mesh readers raise whatever they stumble over
        reason = (str(error).splitlines() or [error.__class__.__name__])[0][:200]
        raise InputError(path, f"cannot be read as a mesh: {reason}.", code="E-MESH-BROKEN") from None
    vertices = [np.asarray(mesh.vertices) for mesh in meshes]
    if not all(np.isfinite(points).all() and np.abs(points).max() < LARGEST for points in vertices):
        raise InputError(path, f"has coordinates that are no numbers or beyond {LARGEST:g}.", code="E-MESH-BROKEN")
    meshes = [mesh for mesh in meshes if mesh.area > 0]
    if not meshes:
        raise InputError(path, "holds no triangles that have an area.", code="E-MESH-BROKEN")
    if path.suffix.lower() == ".obj" and NO_NUMBER.search(path.read_bytes()):
        lost.append(f"{path.name}: corners that are no numbers are left out")
    return meshes, list(dict.fromkeys([*files.lost, *lost]))


def _gltf(path: Path) -> tuple[dict[str, Any], bytes]:
    """The header and the binary part of a glTF file; empty for other files, and for what is said when it is read."""
    if path.suffix.lower() not in (".glb", ".gltf"):
        return {}, b""
    try:
        data = path.read_bytes()
        if data[:4] != b"glTF":
            return dict(json.loads(data)), b""
        end = 20 + struct.unpack("<I", data[12:16])[0]
        return dict(json.loads(data[20:end])), data[end + 8 :]
    except (OSError, ValueError, TypeError, struct.error):
        return {}, b""


def _lost_inside(path: Path, header: dict[str, Any], binary: bytes) -> list[str]:
    """A line for every picture inside a glTF file that cannot be shown."""
    lost = []
    for number, image in enumerate(header.get("images", [])):
        try:
            if "bufferView" in image:
                view = header["bufferViews"][image["bufferView"]]
                start = view.get("byteOffset", 0)
                data = binary[start : start + view["byteLength"]]
            elif image.get("uri", "").startswith("data:"):
                data = b64decode(image["uri"].partition(",")[2])
            else:
                continue
            fault = fault_of(data)
        except (ValueError, TypeError, KeyError, IndexError, AttributeError):
            fault = "is not in the file"
        if fault:
            lost.append(f"{path.name} is shown without its picture {number}, which {fault}")
    return lost


def _drop_broken(meshes: Iterable[Trimesh]) -> None:
    """Take pictures that cannot be read out of the materials of meshes: they would stop whoever copies them."""
    for mesh in meshes:
        material = getattr(mesh.visual, "material", None)
        for key in ("image", *TEXTURES):
            picture = getattr(material, key, None)
            try:
                if picture is not None:
                    picture.load()
            except (OSError, ValueError, SyntaxError):
                setattr(material, key, None)


def _check_uncompressed(path: Path, header: dict[str, Any]) -> None:
    """Refuse glTF that trimesh would read as zeros.

    Raises:
        InputError: says what would read it.
    """
    needed = header.get("extensionsRequired", [])
    if DRACO in needed and importlib.util.find_spec("DracoPy") is None:
        raise InputError(
            path,
            f"is compressed ({DRACO}).",
            "pip install DracoPy, or export it uncompressed",
            code="E-MESH-COMPRESSED",
        )
    if MESHOPT in needed:
        raise InputError(path, f"is compressed ({MESHOPT}).", "export it uncompressed", code="E-MESH-COMPRESSED")


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
