"""glTF 2.0, read by trimesh. Worked out here: where pictures lie, colors of corners.

What a shape needs and trimesh does not read is refused by name; what only looks need is named.
"""

import io
import json
import struct
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh import Scene
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import PBRMaterial

from roomkin.stages.articulated.mesh_resolver import MeshResolver
from roomkin.stages.articulated.urdf_tree import MOST_SHAPES
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.generated import GAMMA

Header = dict[str, Any]
Numbers = NDArray[np.float64]
MAGIC = b"glTF"
INSTANCES, MOVED = "EXT_mesh_gpu_instancing", "KHR_texture_transform"
GLOSSY, WEBP = "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp"  # which trimesh reads
READ = {MOVED, GLOSSY, WEBP}
LOOKS = ("KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_xmp")  # not its shape
INTEGERS = (5120, 5121, 5122, 5123)  # of up to two bytes, which shares of positions and normals are kept in
TRIANGLES, STRIP, FAN = 4, 5, 6
# Keys of numbers that are none below 0, where Python would count from the end: of parts of the file, counts, places.
NATURAL = {"scene", "nodes", "children", "mesh", "material", "indices", "bufferView", "buffer", "source", "index",
           "POSITION", "NORMAL", "count", "byteOffset", "byteLength", "byteStride"}  # fmt: skip
LARGEST = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}  # what is 1 in a normalized accessor, by component type
TEXTURES = ("baseColorTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture", "emissiveTexture")
METAL = "pbrMetallicRoughness"
SAME = 1.5 / 255  # by which colors differ that are one


def read_gltf(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of the file's scene, and what of it is not read, a line each.

    trimesh hands on attributes that begin with _ as they are in the file: what it would take otherwise is called so.

    Raises:
        InputError: it has what is not read and changes its shape.
        ValueError: it is broken.
    """
    data = path.read_bytes()
    end = 20 + int.from_bytes(data[12:16], "little") if data[:4] == MAGIC else 0  # of the header of a .glb
    header, binary = json.loads(data[20:end] if end else data), data[end:] if end else b""
    refuse_unread(path, header)
    check_numbers(header)
    lines = list_left_out(header)
    said = _place_pictures(header.get("materials", []))
    primitives = _rename_attributes(header)
    data = _join_file(header, binary) if binary else json.dumps(header).encode()
    with warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)  # of a picture that is too large
        try:
            scene = trimesh.load_scene(io.BytesIO(data), file_type="glb" if binary else "gltf", resolver=files)
        except FileNotFoundError as error:
            raise ValueError(f"its file {error}") from None
    if len(scene.graph.nodes_geometry) > MOST_SHAPES:
        raise ValueError(f"it shows more than {MOST_SHAPES} meshes")
    for mesh, primitive in zip(scene.geometry.values(), primitives, strict=True):
        said += _work_out(mesh, primitive, header, files)
    return scene, [f"{path.name} {line}" for line in dict.fromkeys([*said, *lines])]


def check_numbers(header: Header) -> None:
    """Refuse numbers below 0, and nodes below two others or twice in a scene, of which trimesh would show one.

    Raises:
        ValueError: names the first.
    """
    for key, value in _list_numbers(header):
        if value < 0:
            raise ValueError(f"its {key} is {value!r}")
    places = [child for node in header.get("nodes", []) for child in node.get("children", [])]
    for scene in header.get("scenes", []):
        named = Counter([*places, *scene.get("nodes", [])])
        if twice := [node for node, count in named.items() if count > 1]:
            raise ValueError(f"its node {twice[0]} has two parents, or is twice in a scene")


def _list_numbers(part: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """The numbers of a part of the header that stand under keys of `NATURAL`, each with its key."""
    for name, inner in part.items() if isinstance(part, dict) else ((key, one) for one in part):
        if isinstance(inner, dict | list) and name != "extras":
            yield from _list_numbers(inner, name)
        elif name in NATURAL and isinstance(inner, int | float):
            yield name, inner


def _join_file(header: Header, binary: bytes) -> bytes:
    """A .glb of a header and what follows it."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIII4s", MAGIC, 2, 20 + len(text) + len(binary), len(text), b"JSON") + text + binary


def refuse_unread(path: Path, header: Header) -> None:
    """Refuse a file with what changes its shape and is not read here.

    Raises:
        InputError: names it.
    """
    nodes, parts = header.get("nodes", []), [part for mesh in header.get("meshes", []) for part in mesh["primitives"]]
    if len(nodes) > MOST_SHAPES:
        raise InputError(path, f"has {len(nodes)} nodes.", f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")
    named = [part["attributes"].get(key) for part in parts for key in ("POSITION", "NORMAL")]
    shaped = [one for number, one in enumerate(header.get("accessors", [])) if number in named]
    found = {
        "a version after 2.0": float(header.get("asset", {}).get("minVersion", 2)) > 2,
        "quantised numbers": any(one.get("componentType") in INTEGERS for one in shaped),
        "instances": any(INSTANCES in node.get("extensions", {}) for node in nodes),
        "skins": any("skin" in node for node in nodes),
        "morph targets": any("targets" in part for part in parts),
        "triangle fans": any(part.get("mode") == FAN for part in parts),
        "sparse accessors": any("sparse" in one for one in header.get("accessors", [])),
        "hidden nodes": any("KHR_node_visibility" in node.get("extensions", {}) for node in nodes),
        "compressed numbers": any("bufferView" not in one for one in header.get("accessors", [])),
    }
    names = [name for name, is_there in found.items() if is_there]
    names += sorted(one for one in set(header.get("extensionsRequired", [])) - READ if not one.startswith(LOOKS))
    if names:
        mend = "re-export it with modifiers applied, as plain triangles, uncompressed"
        raise InputError(path, f"has {', '.join(names)[:200]}, not read here.", mend, code="E-MESH-EXTENSION")


def list_left_out(header: Header) -> list[str]:
    """The parts of the file that are not read, in a line."""
    scenes = len(header.get("scenes", []))
    modes = [part.get("mode", TRIANGLES) for mesh in header.get("meshes", []) for part in mesh["primitives"]]
    present = {
        f"{scenes - 1} of its {scenes} scenes": scenes > 1,
        "animations": bool(header.get("animations")),
        "cameras": bool(header.get("cameras")),
        "points or lines": any(mode not in (TRIANGLES, STRIP) for mode in modes),
    }
    names = [name for name, is_there in present.items() if is_there]
    names += sorted(set(header.get("extensionsUsed", [])) - READ)
    return [f"has what is not read: {', '.join(names)[:300]}"] if names else []


def _pictures(material: Header) -> list[tuple[Header, str]]:
    """Where a material names pictures, as an object and its key: the one that is seen most first."""
    glossy = material.get("extensions", {}).get(GLOSSY, {})
    return [
        (holder, key)
        for holder in (glossy, material.get(METAL, {}), material)
        for key in ("diffuseTexture", "specularGlossinessTexture", *TEXTURES)
        if isinstance(holder.get(key), dict)
    ]


def _placement(holder: Header, key: str) -> tuple[str, Header]:
    """The coordinates that a picture lies by, and how they are moved."""
    picture = holder[key]
    moves = picture.get("extensions", {}).get(MOVED, {})
    return f"TEXCOORD_{moves.get('texCoord', picture.get('texCoord', 0))}", moves


def _place_pictures(materials: list[Header]) -> list[str]:
    """Take out the pictures of materials that lie otherwise than their first: renderers know one way; a line each."""
    lost = []
    for material in materials:
        if material.get("alphaMode", "OPAQUE") == "OPAQUE" and "baseColorFactor" in material.get(METAL, {}):
            material[METAL]["baseColorFactor"][3:] = [1.0]
        pictures = _pictures(material)
        for holder, key in pictures[1:]:
            if _placement(holder, key) != _placement(*pictures[0]):
                lost.append(f"is shown without its {key}, which lies otherwise than its first picture")
                del holder[key]
    return lost


def _rename_attributes(header: Header) -> list[Header]:
    """Make the header one that trimesh reads whole; the primitives in the order of its meshes."""
    nodes, meshes = header.get("nodes", []), header.get("meshes", [])
    if not header.get("scenes"):
        below = {child for node in nodes for child in node.get("children", [])}
        header |= {"scenes": [{"nodes": sorted(set(range(len(nodes))) - below)}], "scene": 0}
    for mesh in meshes:
        mesh["primitives"] = [part for part in mesh["primitives"] if part.get("mode", TRIANGLES) in (TRIANGLES, STRIP)]
    for node in nodes:
        node.pop("camera", None)  # trimesh leaves out what such a node holds
        if "mesh" in node and not meshes[node["mesh"]]["primitives"]:
            del node["mesh"]
    primitives = [part for mesh in meshes for part in mesh["primitives"]]
    for part in primitives:
        attributes = part["attributes"]
        pictures = _pictures(header["materials"][part["material"]]) if "material" in part else []
        for name in [name for name in attributes if name.startswith(("TEXCOORD_", "COLOR_"))]:
            number = attributes.pop(name)
            if name == "COLOR_0":
                attributes["_COLOR"] = number
            elif pictures and name == _placement(*pictures[0])[0]:
                attributes["_UV"] = number
    return primitives


def _shares(values: Any, name: str, primitive: Header, header: Header) -> Numbers:
    """Numbers of a primitive's attribute; integers that stand for shares divided."""
    accessor = header["accessors"][primitive["attributes"][name]]
    values = np.asarray(values, dtype=float).reshape(len(values), -1)
    if not accessor.get("normalized") or accessor["componentType"] not in LARGEST:
        return values
    return np.maximum(values / LARGEST[accessor["componentType"]], -1.0)


def _work_out(mesh: Any, primitive: Header, header: Header, files: MeshResolver) -> list[str]:
    """Give a mesh the coordinates, normals and looks that its primitive says; what of its looks is lost, a line each.

    Raises:
        ValueError: it names corners that it does not have.
    """
    if len(mesh.faces) and mesh.faces.max() >= len(mesh.vertices):
        raise ValueError(f"a face names corner {mesh.faces.max()} of {len(mesh.vertices)}")
    normals = np.array(mesh.vertex_normals, dtype=float) if "NORMAL" in primitive["attributes"] else None
    if normals is not None:
        mesh.vertex_normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    material = header["materials"][primitive["material"]] if "material" in primitive else {}
    lost, pictures = list[str](), _pictures(material)
    if "_UV" in primitive["attributes"]:
        uv = _shares(mesh.vertex_attributes.pop("_UV"), "_UV", primitive, header)[:, :2]
        mesh.visual.uv = _transform_uv(uv, _placement(*pictures[0])[1]) * [1, -1] + [0, 1]  # v upwards
    for holder, key in pictures:
        if why := _drop_if_broken(mesh.visual.material, "baseColorTexture" if key == "diffuseTexture" else key):
            source = header["textures"][holder[key]["index"]].get("source")
            named = "" if source is None else header["images"][source].get("uri", "")
            if not (named and any(named in line for line in files.lost)):
                lost.append(f"is shown without its {key}, which {why}")
    if "_COLOR" in primitive["attributes"]:
        colors = _shares(mesh.vertex_attributes.pop("_COLOR"), "_COLOR", primitive, header)
        lost += _paint(mesh, colors, material)
    return lost


def _transform_uv(uv: Numbers, moves: Header) -> Numbers:
    """Texture coordinates (N, 2), v downwards, that are scaled, turned and shifted, in this order."""
    sine, cosine = np.sin(moves.get("rotation", 0)), np.cos(moves.get("rotation", 0))
    turn = np.array([[cosine, -sine], [sine, cosine]])
    return np.asarray((uv * moves.get("scale", [1, 1])) @ turn + moves.get("offset", [0, 0]))


def _drop_if_broken(material: PBRMaterial, key: str) -> str | None:
    """Take a picture that cannot be read out of a material, and why; None: it can, or trimesh works it into others."""
    if key not in TEXTURES:
        return None
    if (picture := getattr(material, key)) is None:
        return "is no picture that is read here (export it as PNG or JPEG)"
    try:
        picture.load()
    except (OSError, ValueError, SyntaxError) as error:
        setattr(material, key, None)
        return f"is no whole picture ({explain(error)})"
    return None


def _paint(mesh: Any, colors: Numbers, material: Header) -> list[str]:
    """Give a mesh the colors (N, 3 or 4), linear, of its corners: one of all as its material; a line if they are
    lost."""
    rgba = np.ones((len(colors), 4))
    rgba[:, : colors.shape[1]] = colors.clip(0, 1)
    if material.get("alphaMode", "OPAQUE") == "OPAQUE":
        rgba[:, 3] = 1.0
    factor = material.get(METAL, {}).get("baseColorFactor", [1.0] * 4)
    glossy = GLOSSY in material.get("extensions", {})
    if np.ptp(rgba, axis=0).max() <= SAME and not glossy:
        painted = mesh.visual.material.copy() if material else PBRMaterial(metallicFactor=0.0, roughnessFactor=0.8)
        painted.baseColorFactor = rgba.mean(axis=0) * factor
        mesh.visual = TextureVisuals(uv=getattr(mesh.visual, "uv", None), material=painted)
    elif glossy or _pictures(material):
        return ["is shown without the colors of its corners, which would tint its picture"]
    else:
        rgba *= factor
        rgba[:, :3] **= 1 / GAMMA
        mesh.visual = ColorVisuals(mesh, vertex_colors=(255 * rgba).round().astype(np.uint8))
    return []
