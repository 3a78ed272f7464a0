"""glTF: what moves, repeats or packs a mesh is worked out on reading; what cannot be is refused or named."""

import importlib.util
import io
from base64 import b64decode
from pathlib import Path

import trimesh
from PIL import features
from trimesh import Scene

from plugins.importing.mesh_files.accessors import Accessors, Header, header_of
from plugins.importing.mesh_files.gltf_nodes import INSTANCES, VISIBILITY, place_meshes
from plugins.importing.mesh_files.gltf_parts import DRACO, GLOSSY, MOVED, Parts
from stages.articulated.mesh_resolver import PICTURES, MeshResolver, fault_of
from stages.articulated.urdf_tree import MOST_SHAPES
from stages.contracts.errors import InputError

PACKED = ("EXT_meshopt_compression", "KHR_meshopt_compression")
QUANTIZED, WEBP, AVIF = "KHR_mesh_quantization", "EXT_texture_webp", "EXT_texture_avif"
READ = {DRACO, GLOSSY, MOVED, INSTANCES, VISIBILITY, QUANTIZED, WEBP}
LOOKS = ("KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_xmp")  # not its shape
KTX2 = b"\xabKTX 20\xbb"
UNUSED = ("skins", "animations", "cameras", "extensions", "extensionsUsed", "extensionsRequired")


def read_gltf(path: Path, files: MeshResolver) -> tuple[Scene, list[str]]:
    """The meshes of the file's scene, as it stands, and what of it is not read, a line each.

    Raises:
        InputError: it needs an extension without which its shape would be wrong.
        ValueError: it is broken.
    """
    header, binary = header_of(path.read_bytes())
    _check_extensions(path, header)
    if isinstance(nodes := header.get("nodes"), list) and len(nodes) > MOST_SHAPES:
        raise InputError(path, f"has {len(nodes)} nodes.", f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")
    accessors = Accessors(header, binary, files)
    lost = [f"is shown {line}" for line in _drop_lost_pictures(header, accessors, files)]
    parts, placings, meshes = Parts(header, accessors), list[Header](), list[Header]()
    placed_meshes = dict[tuple[int, tuple[float, ...]], int]()
    for one in place_meshes(header, accessors):
        key = (one.mesh, one.weights)
        if one.joints is not None or key not in placed_meshes:
            placed_meshes[key] = len(meshes)
            meshes.append({"primitives": parts.read_triangles(one)})
        placings.append({"mesh": placed_meshes[key], "matrix": one.transform.T.ravel().tolist()})
    left_out = _list_left_out(header, parts)
    header.update(meshes=meshes, nodes=placings, materials=parts.materials, scene=0)
    header["scenes"] = [{"nodes": list(range(len(placings)))}]
    plain = {key: value for key, value in header.items() if key not in UNUSED}
    accessors.header = plain
    scene = trimesh.load_scene(io.BytesIO(accessors.pack_glb()), file_type="glb", resolver=files)
    lost += [f"is shown {line}" for line in dict.fromkeys(parts.lost)]
    return scene, [f"{path.name} {line}" for line in [*lost, *left_out]]


def _check_extensions(path: Path, header: Header) -> None:
    """Refuse a file that cannot be understood without an extension that is not read here.

    Raises:
        InputError: names them.
    """
    needed = set(header.get("extensionsRequired", []))
    if DRACO in needed and importlib.util.find_spec("DracoPy") is None:
        raise InputError(
            path,
            f"is compressed ({DRACO}).",
            "pip install DracoPy, or export it uncompressed",
            code="E-MESH-COMPRESSED",
        )
    if packed := sorted(needed.intersection(PACKED)):
        raise InputError(path, f"is compressed ({packed[0]}).", "export it uncompressed", code="E-MESH-COMPRESSED")
    if unknown := sorted(name for name in needed - READ if not name.startswith(LOOKS)):
        raise InputError(
            path, f"needs {', '.join(unknown)[:200]}, not read here.", "export it without", code="E-MESH-EXTENSION"
        )


def _list_left_out(header: Header, parts: Parts) -> list[str]:
    """What of the file is not read, in a line."""
    scenes = len(header.get("scenes", []))
    present = {
        f"{scenes - 1} of its {scenes} scenes": scenes > 1,
        "animations": bool(header.get("animations")),
        "cameras": bool(header.get("cameras")),
        "points or lines": parts.others > 0,
    }
    names = [what for what, is_there in present.items() if is_there]
    names += sorted(set(header.get("extensionsUsed", [])) - READ)
    return [f"has what is not read: {', '.join(names)[:300]}"] if names else []


def _drop_lost_pictures(header: Header, accessors: Accessors, files: MeshResolver) -> list[str]:
    """A line for every picture that cannot be shown; textures are left with the one picture that can."""
    lost, images, used = list[str](), header.get("images", []), list[int]()
    for texture in header.get("textures", []):
        extensions = texture.pop("extensions", {})
        usable = [name for name in (AVIF, WEBP) if name in extensions and features.check(name.rpartition("_")[2])]
        if usable:
            texture["source"] = extensions[usable[0]]["source"]
        if "source" in texture:
            used.append(texture["source"])
        elif extensions:
            used += [one["source"] for one in extensions.values() if "source" in one]
    for number in sorted(set(used)):
        if why := _fault(images[number], accessors, files):
            lost.append(f"without its picture {number}, which {why}")
    return lost


def _fault(image: Header, accessors: Accessors, files: MeshResolver) -> str | None:
    """The reason why a picture cannot be read; None: it can, or is a file that whoever reads it complains of."""
    name = image.get("uri", "")
    try:
        if "bufferView" in image:
            data = accessors.bytes_of(image["bufferView"])
        elif name.startswith("data:"):
            data = b64decode(name.partition(",")[2])
        elif Path(name).suffix.lower() in PICTURES:
            return None
        else:
            data = files.get(name)
    except FileNotFoundError:
        return None
    except (ValueError, TypeError, KeyError, IndexError, AttributeError):
        return "is not in the file"
    if data.startswith(KTX2):
        return "is KTX2, not read here (export it as PNG or JPEG)"
    return fault_of(data)
