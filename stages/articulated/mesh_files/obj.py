"""Wavefront OBJ and its MTL: polygons of any shape in triangles, colors of corners, transparency, pictures."""

import io
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Scene

from roomkin.stages.articulated.mesh_files import MeshReader
from roomkin.stages.articulated.mesh_resolver import MeshResolver
from roomkin.stages.geometry.frames import ROUNDING

Corners = NDArray[np.float64]
Triangles = NDArray[np.int64]


def triangles_of(corners: Corners) -> Triangles:
    """Triangles (T, 3), as indices into the corners (N, 3) of a polygon that is about flat, in any plane."""
    steps = np.arange(1, len(corners) - 1)
    fan = np.stack([np.zeros_like(steps), steps, steps + 1], axis=1)
    if len(corners) == 3:
        return fan
    centerd = corners - corners.mean(axis=0)
    normal = np.cross(centerd, np.roll(centerd, -1, axis=0)).sum(axis=0)  # Newell's: twice the area
    least = ROUNDING * float(np.ptp(corners, axis=0).max()) ** 2
    if np.linalg.norm(normal) <= least or (_measure_facing_area(corners, fan, normal) >= -least).all():
        return fan
    import mapbox_earcut  # not where models are read that were imported before: they are of triangles

    flat = np.ascontiguousarray(np.delete(centerd, np.argmax(np.abs(normal)), axis=1))
    cut = mapbox_earcut.triangulate_float64(flat, np.array([len(corners)], dtype=np.uint32))
    if not len(cut):
        return fan
    ears = cut.reshape(-1, 3).astype(np.int64)
    return ears if _measure_facing_area(corners, ears, normal).sum() > 0 else ears[:, ::-1]


def split(vertices: Corners, polygons: Iterable[Triangles]) -> tuple[Triangles, Triangles]:
    """Triangles (T, 3) of polygons that index vertices (V, 3), and for each the number (T,) of its polygon."""
    triangles, numbers = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for number, polygon in enumerate(polygons):
        if len(polygon) >= 3:
            triangles.append(polygon[triangles_of(vertices[polygon])])
            numbers.append(np.full(len(triangles[-1]), number))
    return np.concatenate(triangles), np.concatenate(numbers)


def _measure_facing_area(corners: Corners, triangles: Triangles, normal: Corners) -> NDArray[np.float64]:
    """Twice the area of each triangle as seen along a polygon's normal: negative, it faces the other way."""
    one, two, three = (corners[triangles[:, column]] for column in range(3))
    return np.asarray(np.cross(two - one, three - one) @ (normal / np.linalg.norm(normal)))


PLAIN = ("ka", "ks", "ns")  # which trimesh reads as they are
ARGUMENTS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2}  # of a picture's options, at most; one of all others
BLACK = 1e-3


@dataclass
class MeshMaterial:
    """A material. color: linear. picture: a file's name. scale, offset: of its coordinates (u, v)."""

    name: str
    color: tuple[float, ...] | None = None
    opacity: float = 1.0
    picture: str = ""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    others: list[str] = field(default_factory=list)

    def text(self) -> str:
        """The material as trimesh reads it."""
        color = (1.0, 1.0, 1.0) if self.color is None and self.picture else self.color
        lines = [f"newmtl {self.name}", *self.others]
        if color is not None:
            alpha = () if self.opacity == 1.0 else (self.opacity,)
            lines.append(f"Kd {' '.join(f'{value:g}' for value in (*color, *alpha))}")
        if self.picture:
            lines.append(f"map_Kd {self.picture}")
        return "\n".join(lines) + "\n"


def materials_in(text: str, file: str) -> tuple[dict[str, MeshMaterial], list[str]]:
    """The materials of a library by name, and what of it is not read or taken otherwise, a line each."""
    materials, lines, masks = dict[str, MeshMaterial](), list[str](), list[str]()
    material = None
    for line in text.splitlines():
        key, rest = [*line.split(None, 1), "", ""][:2]
        key, rest = key.lower(), rest.strip()
        if key == "newmtl":
            material = materials[rest] = MeshMaterial(rest)
        elif material is None:
            continue
        elif key in PLAIN:
            material.others.append(f"{key} {rest}")
        elif key == "kd":
            material.color = _color(rest)
        elif key in ("d", "tr"):
            share = _color(rest.removeprefix("-halo"))
            if share:
                material.opacity = share[0] if key == "d" else 1 - share[0]
        elif key == "map_kd":
            _read_picture(material, rest)
        elif key == "map_d":
            masks.append(material.name)
    for one in materials.values():
        if one.opacity <= 0:  # programs that mean the opposite: nobody draws what cannot be seen
            one.opacity = 1.0
        if one.picture and one.color is not None and max(one.color) < BLACK:
            one.color = None
            lines.append(f"{file}: '{one.name}' would paint its picture black: its color is not used")
    if masks:
        lines.append(f"{file}: pictures of transparency (map_d of {', '.join(masks[:3])}) are not read")
    return materials, lines


def _color(text: str) -> tuple[float, ...] | None:
    """The first numbers of a text, three at most; None: there are none, as of a spectral curve."""
    values = []
    for word in text.split()[:3]:
        try:
            values.append(min(max(float(word), 0.0), 1.0))
        except ValueError:
            break
    return tuple(values * 3 if len(values) == 1 else values) or None


def _read_picture(material: MeshMaterial, text: str) -> None:
    """The picture's name behind its options; those that scale and move it."""
    words = text.split()
    while words and re.fullmatch(r"-[a-z]+", words[0]):
        option, words = words[0], words[1:]
        numbers = list[float]()
        for word in words[: ARGUMENTS.get(option, 1)]:
            try:
                numbers.append(float(word))
            except ValueError:
                break
        taken = len(numbers) if option in ARGUMENTS else 1
        words = words[taken:]
        if option in ("-s", "-o") and numbers:
            usual = 1.0 if option == "-s" else 0.0
            pair = (numbers[0], numbers[1] if len(numbers) > 1 else usual)
            material.scale, material.offset = (pair, material.offset) if option == "-s" else (material.scale, pair)
    material.picture = " ".join(words)


# Those that are no triangles, or count backwards.
FACES = re.compile(r"^[ \t]*f[ \t]+(?:(?:\S+[ \t]+){3,}\S|[^\n]*-\d)", re.MULTILINE)
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


def _materials(text: str, path: Path, files: MeshResolver) -> tuple[dict[str, MeshMaterial], list[str]]:
    """The materials of all libraries that the file names, and what was not read of them or is in none of them."""
    materials, lines, missing = dict[str, MeshMaterial](), list[str](), False
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
    corners = np.array([line.split()[:3] for line in CORNERS.findall(text)], dtype=float).reshape(-1, 3)
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


def _absolute(word: str, counts: dict[str, int]) -> str:
    """A corner of a face, as 3/7/2, with what counts backwards from here counted from the beginning."""
    parts = word.split("/")
    for number, (part, count) in enumerate(zip(parts, counts.values(), strict=False)):
        if part.startswith("-"):
            parts[number] = str(count + 1 + int(part))
    return "/".join(parts)


def _move_picture(mesh: Any, materials: dict[str, MeshMaterial]) -> None:
    """Put the mesh's picture where its material moves it."""
    material = materials.get(getattr(getattr(mesh.visual, "material", None), "name", None) or "")
    uv: NDArray[np.float64] | None = getattr(mesh.visual, "uv", None)
    if material is not None and uv is not None and (material.scale, material.offset) != ((1.0, 1.0), (0.0, 0.0)):
        mesh.visual.uv = np.asarray(uv) * material.scale + material.offset


READER = MeshReader(read_obj)
