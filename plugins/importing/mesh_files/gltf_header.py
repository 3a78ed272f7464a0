"""A glTF file's header: found in the file, refused by name where it says what is not read, and put back."""

import json
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from roomkin.stages.articulated.urdf_tree import MOST_SHAPES
from roomkin.stages.contracts.errors import InputError

Header = dict[str, Any]
MAGIC = b"glTF"
INSTANCES, MOVED = "EXT_mesh_gpu_instancing", "KHR_texture_transform"
GLOSSY, WEBP = "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp"  # which trimesh reads
READ = {MOVED, GLOSSY, WEBP}
LOOKS = ("KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_xmp")  # not its shape
# Keys that name other parts by their numbers, and what those are.
NAMED = {
    **{"scene": "scenes", "nodes": "nodes", "children": "nodes", "mesh": "meshes", "camera": "cameras"},
    **{"skin": "skins", "material": "materials", "indices": "accessors", "bufferView": "bufferViews"},
    **{"buffer": "buffers", "source": "images", "sampler": "samplers"},
}
LOOKS_ALONE = {"textures", "images", "samplers", "cameras"}  # of which too few are no reason to lose a shape
# Bytes of a number in an accessor, and how many numbers are one of it.
COMPONENTS = {"5120": 1, "5121": 1, "5122": 2, "5123": 2, "5125": 4, "5126": 4}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
INTEGERS = (5120, 5121, 5122, 5123)  # of up to two bytes, which shares of positions and normals are kept in
NEWEST = 2.0  # version that is read
TRIANGLES, STRIP, FAN = 4, 5, 6


def split_file(data: bytes) -> tuple[Header, bytes]:
    """The header of a file, and what follows it in a .glb.

    Raises:
        ValueError: it is no glTF 2.
    """
    try:
        end = 20 + struct.unpack("<I", data[12:16])[0] if data[:4] == MAGIC else 0
        header, binary = json.loads(data[20:end] if end else data), data[end:] if end else b""
    except (ValueError, struct.error) as error:
        raise ValueError(f"its header is broken ({error})") from None
    if not isinstance(header, dict):
        raise ValueError("its header is no object")
    if not str(version := header.get("asset", {}).get("version", "2")).startswith("2"):
        raise ValueError(f"it is glTF {version}, and 2.0 is read")
    if float(header.get("asset", {}).get("minVersion", 2)) > NEWEST:
        raise ValueError(f"it needs glTF {header['asset']['minVersion']}, and 2.0 is read")
    return header, binary


def check_indices(header: Header) -> None:
    """Refuse numbers that name no part of the file; below 0 Python would count from the end.

    Raises:
        ValueError: names the first.
    """
    for key, value, kind in _list_indices({name: part for name, part in header.items() if name != "animations"}):
        count = len(header.get(kind, []))
        if type(value) is not int or value < 0 or (value >= count and kind not in LOOKS_ALONE):
            raise ValueError(f"its {key} is {value!r}, and it has {count} {kind}")


def _list_indices(part: Any) -> Iterator[tuple[str, Any, str]]:
    """Keys of a part of the header that name another by its number, the number, and what it is a number of."""
    for key, value in part.items() if isinstance(part, dict) else ():
        if key in ("extras", "animations"):
            continue
        kind = NAMED.get(key)
        if kind and not isinstance(value, dict):
            values = value if isinstance(value, list) else [value]
            yield from ((key, one, kind) for one in values if not isinstance(one, dict))
        if key == "attributes" and isinstance(value, dict):
            yield from ((name, one, "accessors") for name, one in value.items())
        if key.endswith("Texture") and isinstance(value, dict):
            yield key, value.get("index"), "textures"
        for inner in value if isinstance(value, list) else [value]:
            yield from _list_indices(inner)


def check_counts(header: Header) -> None:
    """Refuse accessors that are more than their part of a buffer holds, and parts that are more than the buffer.

    Raises:
        ValueError: names the first.
    """
    for number, view in enumerate(header.get("bufferViews", [])):
        end, whole = view.get("byteOffset", 0) + view["byteLength"], header["buffers"][view["buffer"]]["byteLength"]
        if end > whole:
            raise ValueError(f"its bufferView {number} ends at {end}, and its buffer has {whole} bytes")
    for number, one in enumerate(header.get("accessors", [])):
        size = COMPONENTS.get(str(one.get("componentType")), 0) * NUMBERS.get(str(one.get("type")), 0)
        count, start, view = one.get("count"), one.get("byteOffset", 0), header["bufferViews"][one["bufferView"]]
        if not size or type(count) is not int or count < 0 or start < 0:
            raise ValueError(f"its accessor {number} does not say what it holds, where, or how many")
        if count and start + (count - 1) * max(size, view.get("byteStride", 0)) + size > view["byteLength"]:
            raise ValueError(f"its accessor {number} counts {count}, and its part has {view['byteLength']} bytes")


def check_tree(header: Header) -> None:
    """Refuse nodes below two others, or twice in a scene.

    Raises:
        ValueError: names the first.
    """
    places = [child for node in header.get("nodes", []) for child in node.get("children", [])]
    for scene in header.get("scenes", []):
        named = Counter([*places, *scene.get("nodes", [])])
        if twice := [node for node, count in named.items() if count > 1]:
            raise ValueError(f"its node {twice[0]} has two parents, or is twice in a scene")


def join_file(header: Header, binary: bytes) -> bytes:
    """A .glb of a header and what follows it."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    start = struct.pack("<4sIII4s", MAGIC, 2, 20 + len(text) + len(binary), len(text), b"JSON")
    return start + text + binary


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
