"""The primitives of a glTF file as plain triangles: morphed, held by their skins, with one set of texture coordinates
and colours that every renderer shows."""

import json
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plugins.importing.mesh_files.accessors import Accessors, Header, Numbers
from plugins.importing.mesh_files.gltf_nodes import Placed
from stages.contracts.look import GAMMA

DRACO, MOVED, GLOSSY = "KHR_draco_mesh_compression", "KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness"
TRIANGLES, STRIP, FAN = 4, 5, 6
TEXTURES = ("baseColorTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture", "emissiveTexture")
METAL = "pbrMetallicRoughness"
REPEAT, OUTSIDE_PICTURE = 10497, 0.02  # glTF's usual way of going on beyond a picture's edge; how far is no slip
SAME = 1.5 / 255  # by which colours differ that are one


class Parts:
    """Makes the primitives of a file plain.

    Attributes:
        materials: of the plain primitives, in the place of the file's.
        lost: what of their looks is lost, a line each.
        others: how many primitives are points or lines.
    """

    def __init__(self, header: Header, accessors: Accessors) -> None:
        self.header, self.accessors = header, accessors
        self.lost, self.others, self.materials = list[str](), 0, list[Header]()
        self._made = dict[str, int]()

    def read_triangles(self, placed: Placed) -> list[Header]:
        """The triangles of a mesh that is shown; what they index is in the file."""
        return [
            part
            for primitive in self.header["meshes"][placed.mesh]["primitives"]
            if (part := self._read_primitive(primitive, placed)) is not None
        ]

    def _read_primitive(self, primitive: Header, placed: Placed) -> Header | None:
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN):
            self.others += 1
            return None
        if DRACO in primitive.get("extensions", {}):
            if placed.joints is not None or primitive.get("targets"):
                raise ValueError(f"it is moved by a skin or targets, and compressed ({DRACO}): export it uncompressed")
            if "material" not in primitive:
                return primitive
            return {**primitive, "material": self._number(self.header["materials"][primitive["material"]])}
        attributes, read = primitive["attributes"], self.accessors.read
        points = read(attributes["POSITION"])
        faces = self._faces(primitive, mode, len(points))
        normals = read(attributes["NORMAL"]) if "NORMAL" in attributes else None
        for target, weight in zip(primitive.get("targets", []), placed.weights, strict=False):
            points = points + weight * read(target["POSITION"]) if "POSITION" in target else points
            if normals is not None and "NORMAL" in target:
                normals = normals + weight * read(target["NORMAL"])
        if placed.joints is not None and "JOINTS_0" in attributes:
            held = self._skin_transforms(attributes, placed.joints)
            points = np.einsum("nij,nj->ni", held[:, :3, :3], points) + held[:, :3, 3]
            normals = None if normals is None else np.einsum("nij,nj->ni", held[:, :3, :3], normals)
        kept = {"POSITION": self.accessors.add(points, "VEC3")}
        if normals is not None:
            unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
            kept["NORMAL"] = self.accessors.add(unit, "VEC3")
        plain = {"attributes": kept, "indices": self.accessors.add(faces.astype(np.uint32).reshape(-1, 1), "SCALAR")}
        return plain | self._read_material(primitive, kept)

    def _faces(self, primitive: Header, mode: int, count: int) -> NDArray[np.int64]:
        """Triangles (F, 3) that index the primitive's corners."""
        order = np.arange(count)
        if "indices" in primitive:
            order = self.accessors.read(primitive["indices"])[:, 0].astype(np.int64)
        if len(order) and order.max() >= count:
            raise ValueError(f"a face names corner {order.max()} of {count}")
        if mode == TRIANGLES:
            return order[: len(order) // 3 * 3].reshape(-1, 3)
        steps = np.arange(max(len(order) - 2, 0))
        odd = steps % 2 if mode == STRIP else 0
        first = steps if mode == STRIP else 0 * steps
        return order[np.stack([first, steps + 1 + odd, steps + 2 - odd], axis=1)]

    def _skin_transforms(self, attributes: Header, joints: Numbers) -> Numbers:
        """(N, 4, 4) by which the skin's joints carry each corner."""
        held, total = np.zeros((1, 4, 4)), np.zeros(1)
        number = 0
        while f"JOINTS_{number}" in attributes:
            which = self.accessors.read(attributes[f"JOINTS_{number}"]).astype(np.int64)
            share = self.accessors.read(attributes[f"WEIGHTS_{number}"])
            held = held + np.einsum("nk,nkij->nij", share, joints[which])
            total = total + share.sum(axis=1)
            number += 1
        return np.asarray(held / np.where(total > 0, total, 1.0)[:, None, None])

    def _read_material(self, primitive: Header, kept: Header) -> Header:
        """The material of a primitive; its coordinates and colours are put among those that are kept."""
        attributes = primitive["attributes"]
        material = deepcopy(self.header["materials"][primitive["material"]]) if "material" in primitive else None
        if material is not None:
            if material.get("alphaMode", "OPAQUE") == "OPAQUE" and "baseColorFactor" in material.get(METAL, {}):
                material[METAL]["baseColorFactor"][3:] = [1.0]
            self._place_pictures(material, attributes, kept)
        if "COLOR_0" in attributes:
            material = self._colour_material(material, self.accessors.read(attributes["COLOR_0"]), kept)
        return {} if material is None else {"material": self._number(material)}

    def _place_pictures(self, material: Header, attributes: Header, kept: Header) -> None:
        """Put the coordinates of the material's first picture among what is kept; others must lie as that does."""
        pictures = _pictures(material)
        if not pictures:
            return
        name, moves = _read_placement(pictures[0][0][pictures[0][1]])
        for holder, key in pictures:
            if _read_placement(holder[key]) != (name, moves):
                self.lost.append(f"without its {key}, which lies otherwise than its first picture")
                del holder[key]
            elif name not in attributes:
                self.lost.append(f"without its {key}: it has no {name}")
                del holder[key]
            else:
                holder[key] = {"index": holder[key]["index"]}
        if name not in attributes:
            return
        uv = _transform_uv(self.accessors.read(attributes[name])[:, :2], moves)
        kept["TEXCOORD_0"] = self.accessors.add(uv, "VEC2")
        texture = self.header["textures"][pictures[0][0][pictures[0][1]]["index"]]
        sampler = self.header["samplers"][texture["sampler"]] if "sampler" in texture else {}
        beyond = [min(uv[:, axis].min(), 1 - uv[:, axis].max()) < -OUTSIDE_PICTURE for axis in (0, 1)]
        if any(
            out and sampler.get(wrap, REPEAT) != REPEAT for out, wrap in zip(beyond, ("wrapS", "wrapT"), strict=True)
        ):
            self.lost.append("with its picture repeated, which its file mirrors or does not repeat")

    def _colour_material(self, material: Header | None, colours: Numbers, kept: Header) -> Header | None:
        """The material with the one colour (linear) that all corners have; or None, and their colours are kept."""
        factors = (material or {}).get(METAL, {})
        rgba = np.ones((len(colours), 4))
        rgba[:, : colours.shape[1]] = colours.clip(0, 1)
        if (material or {}).get("alphaMode", "OPAQUE") == "OPAQUE":
            rgba[:, 3] = 1.0
        glossy = (material or {}).get("extensions", {}).get(GLOSSY)
        if len(rgba) and np.ptp(rgba, axis=0).max() <= SAME and glossy is None:
            painted = rgba.mean(axis=0) * factors.get("baseColorFactor", [1.0] * 4)
            metal = {"metallicFactor": 0.0, "roughnessFactor": 0.8} if material is None else factors
            return {**(material or {}), METAL: {**metal, "baseColorFactor": painted.round(6).tolist()}}
        if material is not None and (glossy is not None or _pictures(material)):
            self.lost.append("without the colours of its corners, which would tint its picture")
            return material
        rgba *= factors.get("baseColorFactor", [1.0] * 4)
        rgba[:, :3] **= 1 / GAMMA
        kept["COLOR_0"] = self.accessors.add((255 * rgba).round().astype(np.uint8), "VEC4", normalized=True)
        return None

    def _number(self, material: Header) -> int:
        """The material's place in the file, where it is put once."""
        key = json.dumps(material, sort_keys=True)
        if key not in self._made:
            self._made[key] = len(self.materials)
            self.materials.append(material)
        return self._made[key]


def _pictures(material: Header) -> list[tuple[Header, str]]:
    """Where a material names pictures, as an object and its key: the one that is seen most first."""
    glossy = material.get("extensions", {}).get(GLOSSY, {})
    return [
        (holder, key)
        for holder in (glossy, material.get(METAL, {}), material)
        for key in ("diffuseTexture", "specularGlossinessTexture", *TEXTURES)
        if isinstance(holder.get(key), dict)
    ]


def _read_placement(picture: Header) -> tuple[str, Any]:
    """The coordinates that a picture lies by, and how they are moved."""
    moves = picture.get("extensions", {}).get(MOVED, {})
    transform = (moves.get("offset", [0, 0]), moves.get("rotation", 0), moves.get("scale", [1, 1]))
    return f"TEXCOORD_{moves.get('texCoord', picture.get('texCoord', 0))}", transform


def _transform_uv(uv: Numbers, moves: Any) -> Numbers:
    """Texture coordinates (N, 2) that are scaled, turned and shifted, in this order."""
    offset, turn, scale = moves
    sine, cosine = np.sin(turn), np.cos(turn)
    return np.asarray((uv * scale) @ np.array([[cosine, -sine], [sine, cosine]]) + offset)
