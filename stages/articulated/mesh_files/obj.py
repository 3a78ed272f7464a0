"""Wavefront OBJ: polygons of any shape, indices that count backwards, colors of corners, materials with transparency
and pictures that are moved."""

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Scene

from roomkin.stages.articulated.mesh_files import MeshReader
from roomkin.stages.articulated.mesh_files.mtl import Material, materials_in
from roomkin.stages.articulated.mesh_files.polygons import triangles_of
from roomkin.stages.articulated.mesh_resolver import MeshResolver

FACES = re.compile(
    r"^[ \t]*f[ \t]+(?:(?:\S+[ \t]+){3,}\S|[^\n]*-\d)", re.MULTILINE
)  # not triangles that count forwards
CORNERS = re.compile(r"^[ \t]*v[ \t]+(.+)$", re.MULTILINE)
COLORED = re.compile(r"^[ \t]*v(?:[ \t]+[-+.\w]+){6,}[ \t]*$", re.MULTILINE)
LIBRARIES = re.compile(r"^[ \t]*mtllib[ \t]+(.+)$", re.MULTILINE)
USED = re.compile(r"^[ \t]*usemtl[ \t]+(.+)$", re.MULTILINE)
OTHERS = {"l": "lines", "p": "points", "curv": "curves", "surf": "free-form surfaces"}
OTHER = re.compile(rf"^[ \t]*({'|'.join(OTHERS)})[ \t]", re.MULTILINE)


def read_obj(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of a file, one per material, and what was not read of it, a line each."""
    text = decode_text(path.read_bytes()).replace("\t", " ").replace("\\\r\n", " ").replace("\\\n", " ")
    materials, lines = _materials(text, path, files)
    colored = COLORED.search(text) is not None and not any(one.picture for one in materials.values())
    if colored:
        text = LIBRARIES.sub("", USED.sub("", text))
    if colored or FACES.search(text):
        text = _triangulate_text(text, colored)
    library = "materials.mtl"
    text = f"mtllib {library}\n{LIBRARIES.sub('', text)}" if materials else LIBRARIES.sub("", text)
    files.made[library] = "".join(material.text() for material in materials.values()).encode()
    scene = trimesh.load_scene(io.BytesIO(text.encode()), file_type="obj", resolver=files)
    for mesh in scene.geometry.values():
        _move_picture(mesh, materials)
    if found := sorted({OTHERS[kind] for kind in OTHER.findall(text)}):
        lines.append(f"{path.name}: its {', '.join(found)} are not read")
    return scene, lines


def decode_text(data: bytes) -> str:
    """The text of a file, which older programs wrote in their own alphabet."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _materials(text: str, path: Path, files: MeshResolver) -> tuple[dict[str, Material], list[str]]:
    """The materials of all libraries that the file names, and what was not read of them or is in none of them."""
    materials, lines, missing = dict[str, Material](), list[str](), False
    for named in LIBRARIES.findall(text):
        whole = named.strip()
        for name in [whole] if files.find(whole) or ".mtl " not in whole.lower() else whole.split():
            try:
                more, notes = materials_in(decode_text(files.get(name)), Path(name).name)
            except FileNotFoundError:
                missing = True
                continue
            materials |= more
            lines += notes
    unknown = sorted({name.strip() for name in USED.findall(text)} - materials.keys())
    if unknown and not missing:
        names = ", ".join(f"'{name[:60]}'" for name in unknown[:3])
        lines.append(f"{path.name}: {len(unknown)} of its materials ({names}) are in no material file: shown grey")
    return materials, lines


def _triangulate_text(text: str, bare: bool) -> str:
    """The text with triangles alone, their indices counted from the file's beginning; bare: those of corners alone."""
    corners = np.array([_numbers(line) for line in CORNERS.findall(text)]).reshape(-1, 3)
    counts, lines = {"v": 0, "vt": 0, "vn": 0}, list[str]()
    for line in text.splitlines():
        kind, rest = [*line.split(None, 1), "", ""][:2]
        if kind in counts:
            counts[kind] += 1
        elif kind == "f":
            words = [_absolute(word, counts) for word in rest.split("#")[0].split()]
            if bare:
                words = [word.split("/")[0] for word in words]
            indices = [int(word.split("/")[0]) - 1 for word in words]
            if indices and not 0 <= min(indices) <= max(indices) < len(corners):
                raise ValueError(f"a face names corners that are not among the {len(corners)} of the file")
            if len(words) >= 3:
                lines += [f"f {words[a]} {words[b]} {words[c]}" for a, b, c in triangles_of(corners[indices])]
            continue
        lines.append(line)
    return "\n".join(lines)


def _numbers(line: str) -> list[float]:
    return [float(word) for word in line.split()[:3]]


def _absolute(word: str, counts: dict[str, int]) -> str:
    """A corner of a face, as 3/7/2, with what counts backwards from here counted from the beginning."""
    parts = word.split("/")
    for number, (part, count) in enumerate(zip(parts, counts.values(), strict=False)):
        if part.startswith("-"):
            parts[number] = str(count + 1 + int(part))
    return "/".join(parts)


def _move_picture(mesh: Any, materials: dict[str, Material]) -> None:
    """Put the mesh's picture where its material moves it."""
    material = materials.get(getattr(getattr(mesh.visual, "material", None), "name", None) or "")
    uv: NDArray[np.float64] | None = getattr(mesh.visual, "uv", None)
    if material is not None and uv is not None and (material.scale, material.offset) != ((1.0, 1.0), (0.0, 0.0)):
        mesh.visual.uv = np.asarray(uv) * material.scale + material.offset


READER = MeshReader(read_obj)
