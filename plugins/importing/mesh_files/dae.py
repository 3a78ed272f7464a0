"""COLLADA: in metres; polygons of any shape. `up_of`: what a file says is up."""

import io
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from trimesh import Scene

from roomkin.stages.articulated.mesh_files import MeshReader
from roomkin.stages.articulated.mesh_files.obj import Corners, Triangles, split
from roomkin.stages.articulated.mesh_resolver import MeshResolver
from roomkin.stages.articulated.urdf_tree import MAX_NUMBER
from roomkin.stages.contracts.errors import InputError

SPACE = "http://www.collada.org/2005/11/COLLADASchema"
UNREAD = {
    "animation": "animations",
    "ph": "holes in polygons",
    "lines": "lines",
    "linestrips": "lines",
}  # by their tags


def read_dae(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of a file, and what of it is not read, a line each.

    Raises:
        InputError: it has skins or morph targets.
        ValueError: it is broken.
    """
    root = _parse_file(path)
    named = {f"#{element.get('id')}": element for element in root.iter() if "id" in element.attrib}
    found = {element.tag for element in root.iter()}
    if "instance_visual_scene" not in found:
        raise ValueError("it shows no scene")
    if "instance_controller" in found:
        mend = "re-export it with modifiers applied"
        raise InputError(path, "has skins or morph targets, not read here.", mend, code="E-MESH-EXTENSION")
    lines = sorted({name for tag, name in UNREAD.items() if tag in found})
    lines = [f"{path.name} has what is not read: {', '.join(lines)}"] if lines else []
    for parent in list(root.iter()):
        for number, child in enumerate(parent):
            if child.tag in ("polylist", "polygons"):
                parent[number] = child = _triangles(child, named)
            if child.find("input[@semantic='COLOR']") is not None and "texture" not in found:
                child.attrib.pop("material", None)  # else the one color of its material is shown
    root.set("xmlns", SPACE)
    scene = trimesh.load_scene(io.BytesIO(ET.tostring(root)), file_type="dae", resolver=files)
    if (metres := _unit(root)) != 1.0:
        scene.apply_scale(metres)
    return scene, lines


def up_of(path: Path) -> str:
    """The direction up that a file says: X_UP, Y_UP or Z_UP; empty: it says none, or is broken."""
    try:
        return (_parse_file(path).findtext("asset/up_axis") or "").strip()
    except (OSError, ValueError):
        return ""


def _parse_file(path: Path) -> ET.Element:
    """The root of a file, with names without their space.

    Raises:
        ValueError: it is no XML, or declares a DOCTYPE, which may hold more than the file.
    """
    data = path.read_bytes()
    if b"<!DOCTYPE" in data.replace(b"\0", b""):  # UTF-16, too
        raise ValueError("it declares a DOCTYPE, which COLLADA does not need")
    try:
        root = ET.fromstring(data)
    except ET.ParseError as error:
        raise ValueError(f"it is no XML ({error})") from None
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root


def _unit(root: ET.Element) -> float:
    """Metres per unit of the file."""
    unit = root.find("asset/unit")
    metres = float("1" if unit is None else unit.get("meter", "1").replace(",", "."))
    if not 0 < metres < MAX_NUMBER:
        raise ValueError(f"its unit is {metres:g} metres")
    return metres


def _triangles(polygons: ET.Element, named: dict[str, ET.Element]) -> ET.Element:
    """A list of polygons as triangles with the same inputs."""
    inputs = polygons.findall("input")
    width = 1 + max(int(one.get("offset", "0")) for one in inputs)
    vertex = next(one for one in inputs if one.get("semantic") == "VERTEX")
    parts = [_integers(text) for text in polygons.findall("p") + polygons.findall("ph/p")]
    rows = np.concatenate([np.zeros((0, width), dtype=np.int64), *(part.reshape(-1, width) for part in parts)])
    counts = [len(part) // width for part in parts]
    if polygons.tag == "polylist":
        counts = _integers(polygons.find("vcount")).tolist()
    ends = np.cumsum(counts, dtype=np.int64)
    if len(ends) and ends[-1] > len(rows):
        raise ValueError(f"a polylist counts {ends[-1]} corners and has {len(rows)}")
    order = np.arange(len(rows))
    corners = _positions(vertex, named)[rows[:, int(vertex.get("offset", "0"))]]
    faces, _ = split(corners, [order[end - count : end] for count, end in zip(counts, ends, strict=True)])
    triangles = ET.Element("triangles", {**polygons.attrib, "count": str(len(faces))})
    triangles.extend(inputs)
    ET.SubElement(triangles, "p").text = " ".join(map(str, rows[faces.ravel()].ravel().tolist()))
    return triangles


def _positions(vertex: ET.Element, named: dict[str, ET.Element]) -> Corners:
    """(V, 3) of the corners that an input names."""
    position = named[vertex.get("source", "")].find("input[@semantic='POSITION']")
    source = named["" if position is None else position.get("source", "")]
    accessor, numbers = source.find("technique_common/accessor"), source.find("float_array")
    values = np.array((numbers.text or "").split() if numbers is not None else [], dtype=float)
    stride = 3 if accessor is None else int(accessor.get("stride", "3"))
    values = values[0 if accessor is None else int(accessor.get("offset", "0")) :]
    return values[: len(values) // stride * stride].reshape(-1, stride)[:, :3]


def _integers(element: ET.Element | None) -> Triangles:
    return np.array((element.text or "").split() if element is not None else [], dtype=np.int64)


READER = MeshReader(read_dae, up_of)
