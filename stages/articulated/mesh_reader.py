"""Read mesh files with trimesh, and cut them into convex pieces to collide."""

import re
from collections.abc import Iterable
from copy import copy
from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image
from trimesh import Scene, Trimesh

from roomkin.stages.articulated.mesh_files import MeshReader
from roomkin.stages.articulated.mesh_resolver import MeshResolver
from roomkin.stages.articulated.urdf_tree import MAX_NUMBER, THIN
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.plugins import list_available, load

NO_NUMBER = re.compile(rb"^v\s[^\n]*(?:nan|inf)", re.IGNORECASE | re.MULTILINE)
MOST_PIECES = 64
TEXTURES = ("baseColorTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture", "emissiveTexture")
COMMA = re.compile(r"\s*[A-Za-z ]*\s-?\d+,\d+(e[+-]?\d+)?\s")  # a line of STL, OBJ or PLY in another locale


def find_reader(path: Path) -> MeshReader:
    """How files of this kind are read, by the suffix.

    Raises:
        InputError: no package that is here reads them.
    """
    if (reader := _reader(path.suffix.lower().lstrip("."))) is None:
        what, kinds = f"'{path.suffix}' is not a mesh file that is read here.", sorted(list_available("mesh_files"))
        raise InputError(path, what, ", ".join(f".{kind}" for kind in kinds), code="E-MESH-KIND")
    return reader


@cache
def _reader(kind: str) -> MeshReader | None:
    return load("mesh_files", kind) if kind in list_available("mesh_files") else None


def has_decimal_comma(path: Path) -> bool:
    """Whether a file that is text has lines of numbers such as 0,5."""
    try:
        with path.open(encoding="utf-8") as file:
            return any(COMMA.match(file.readline()) for _ in range(50))
    except (OSError, UnicodeDecodeError):
        return False


def load_meshes(path: Path, folder: Path) -> tuple[list[Trimesh], list[str]]:
    """All meshes of a file, in the file's own frame; and what of their looks is lost, a line each.

    `metadata["nodes"]` of each: the names of its node, of those above that, and its own.

    Args:
        folder: no picture or material is read outside of it.

    Raises:
        InputError: the file is of no known kind, cannot be read, or holds no triangle that has an area.
    """
    reader = find_reader(path)
    files = MeshResolver(path, folder)
    try:
        scene, lost = reader.read(path, files)
        if lost:
            _drop_broken(scene.geometry.values())
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, Trimesh) and len(mesh.faces)]
        for mesh in meshes:
            mesh.metadata["nodes"] = _list_nodes(scene, mesh)
        if unplaced := [mesh for mesh in meshes if has_texture(mesh) and getattr(mesh.visual, "uv", None) is None]:
            lost.append(f"{path.name} is shown without a picture that it places nowhere")
            _drop_pictures(unplaced)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # mesh readers raise whatever they stumble over
        reason = (str(error).splitlines() or [explain(error)])[0][:200]
        mend = ""
        if has_decimal_comma(path):
            reason, mend = "its numbers have a decimal comma", "export it with a decimal point (an English locale)"
        raise InputError(path, f"cannot be read as a mesh: {reason}.", mend, code="E-MESH-BROKEN") from None
    vertices = [np.asarray(mesh.vertices) for mesh in meshes]
    if not all(np.isfinite(points).all() and np.abs(points).max() < MAX_NUMBER for points in vertices):
        raise InputError(path, f"has coordinates that are no numbers or beyond {MAX_NUMBER:g}.", code="E-MESH-BROKEN")
    meshes = [mesh for mesh in meshes if mesh.area > 0]
    if not meshes:
        why = f": {lost[0]}" if lost else ""
        raise InputError(path, f"holds no triangles that have an area{why}.", code="E-MESH-BROKEN")
    if path.suffix.lower() == ".obj" and NO_NUMBER.search(path.read_bytes()):
        lost.append(f"{path.name}: corners that are no numbers are left out")
    return meshes, list(dict.fromkeys([*files.lost, *lost]))


def _list_nodes(scene: Scene, mesh: Trimesh) -> list[str]:
    """The names of a mesh's node, of those above it, and its own."""
    above, names = scene.graph.transforms.parents, [mesh.metadata.get("node", "")]
    while names[-1] in above:
        names.append(above[names[-1]])
    return [str(name) for name in (*names, mesh.metadata.get("name", "")) if name != scene.graph.base_frame]


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


def _drop_pictures(meshes: Iterable[Trimesh]) -> None:
    """Take all pictures out of the materials of meshes."""
    for mesh in meshes:
        material = copy(getattr(mesh.visual, "material", None))  # which other meshes share
        for key in ("image", *TEXTURES):
            if getattr(material, key, None) is not None:
                setattr(material, key, None)
        mesh.visual = trimesh.visual.TextureVisuals(material=material)


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


def thicken_piece(mesh: Trimesh) -> Trimesh:
    """The convex piece, or the box around it if it is too thin to collide."""
    if mesh.extents.min() >= THIN:
        return mesh
    center, size = mesh.bounds.mean(axis=0), np.maximum(mesh.extents, THIN)
    return trimesh.creation.box(bounds=np.array([center - size / 2, center + size / 2]))


def _hull(mesh: Trimesh) -> Trimesh:
    if mesh.extents.min() < THIN:
        return thicken_piece(mesh)
    try:
        return mesh.convex_hull
    except Exception:  # qhull: all points in a slanted plane
        return trimesh.creation.box(bounds=mesh.bounds)
