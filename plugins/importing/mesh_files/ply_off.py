"""PLY and OFF: polygons of any shape, colours of corners or of faces; STL, whose colours are not read."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Scene, Trimesh

from stages.articulated.mesh_files.polygons import split
from stages.articulated.mesh_resolver import MeshResolver

COLOURS = ("red", "green", "blue", "alpha")


def read_ply(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of a file as trimesh reads it; polygons of more than three corners are filled again."""
    scene = trimesh.load_scene(path, resolver=files)
    for name, mesh in scene.geometry.items():
        raw: Any = mesh.metadata.get("_ply_raw", {})
        if isinstance(mesh, Trimesh) and (polygons := _polygons(raw)):
            if hasattr(mesh.visual, "uv"):
                continue  # a picture is laid on the corners that trimesh made
            corners = raw["vertex"]["data"]
            vertices = np.column_stack([corners[axis] for axis in "xyz"]).astype(float)
            scene.geometry[name] = _fill_polygons(vertices, polygons, _colours(corners), _colours(raw["face"]["data"]))
    return scene, []


def read_off(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The mesh of a file.

    Raises:
        ValueError: it is broken, or of more than three dimensions.
    """
    words = (line.split("#")[0].split() for line in path.read_text(encoding="utf-8", errors="replace").splitlines())
    lines = [line for line in words if line]
    kind, rest = lines[0][0].upper() if lines else "", lines[0][1:] if lines else []
    if kind.removeprefix("ST").removeprefix("C").removeprefix("N") != "OFF":
        raise ValueError(f"it is no OFF file of three dimensions ('{kind[:20]}')")
    start = 1 if rest else 2
    corners, faces = (int(word) for word in (rest or lines[1])[:2])
    vertices = np.array(lines[start : start + corners], dtype=float)
    face_lines = lines[start + corners : start + corners + faces]
    polygons = [np.array(line[1 : 1 + int(line[0])], dtype=np.int64) for line in face_lines]
    if len(face_lines) < faces or any(len(one) and not 0 <= one.min() <= one.max() < len(vertices) for one in polygons):
        raise ValueError(f"a face names corners that are not among the {len(vertices)} of the file")
    skipped = 6 if "N" in kind.removesuffix("OFF") else 3
    own = vertices[:, skipped : skipped + 4] if "C" in kind.removesuffix("OFF") else None
    painted = [line[1 + int(line[0]) :][:4] for line in face_lines]
    of_faces = None
    if own is None and len({len(colour) for colour in painted}) == 1 and len(painted[0]) >= 3:
        of_faces = np.array(painted, dtype=float)
    return Scene(_fill_polygons(vertices[:, :3], polygons, own, of_faces)), []


def read_stl(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of a file as trimesh reads it, and whether faces have colours: programs write them in several ways."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    binary = len(data) == 84 + 50 * count
    flags = np.frombuffer(data, np.uint8, offset=84).reshape(-1, 50)[:, 49] >> 7 if binary else np.zeros(0, np.uint8)
    painted = (flags == (0 if b"COLOR=" in data[:80] else 1)).any()  # of a face's own colour
    return trimesh.load_scene(path, resolver=files), [f"{path.name}: its colours are not read"] * bool(painted)


def _fill_polygons(
    vertices: NDArray[np.float64], polygons: list[Any], of_corners: Any | None, of_faces: Any | None
) -> Trimesh:
    """Triangles of polygons with the colours (N, 3 or 4), 0 to 1 or to 255, of their corners or faces."""
    faces, numbers = split(vertices, polygons)
    painted = None if of_corners is None else _bytes(of_corners)
    by_face = None if of_faces is None or of_corners is not None else _bytes(of_faces)[numbers]
    return Trimesh(vertices, faces, process=False, vertex_colors=painted, face_colors=by_face)


def _bytes(colours: Any) -> NDArray[np.uint8]:
    values = np.asarray(colours, dtype=float)
    values = values * 255 if values.size and values.max() <= 1 and (values % 1).any() else values
    return values.round().clip(0, 255).astype(np.uint8)


def _polygons(raw: Any) -> list[NDArray[np.int64]]:
    """The faces of a PLY file as trimesh has read them, if some have more than three corners; else none."""
    data = raw.get("face", {}).get("data")
    names = data if isinstance(data, dict) else getattr(getattr(data, "dtype", None), "names", None) or ()
    name = next((name for name in ("vertex_indices", "vertex_index") if name in names), None)
    if name is None or data is None:
        return []
    rows = data[name] if isinstance(data, dict) else data[name]["f1"]
    polygons = [np.asarray(row, dtype=np.int64).ravel() for row in rows]
    return polygons if any(len(polygon) > 3 for polygon in polygons) else []


def _colours(data: Any) -> Any | None:
    """(N, 3 or 4) of an element of a PLY file; None: it has none."""
    names = data if isinstance(data, dict) else getattr(getattr(data, "dtype", None), "names", None) or ()
    found = [data[name] for name in COLOURS if name in names]
    return np.column_stack(found) if len(found) >= 3 else None
