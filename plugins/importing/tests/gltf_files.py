"""Small glTF files made by hand, to say in them whatever the format can say."""

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

CODES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
BOX = trimesh.creation.box((0.2, 0.4, 0.6))


class Gltf:
    """A file in the making: `add` numbers, set parts of the header, `write` it."""

    def __init__(self, **header: Any) -> None:
        self.header: dict[str, Any] = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], **header}
        self.data = b""

    def add(self, values: Any, kind: str = "float32", **more: Any) -> int:
        """Number of an accessor of these values, rows of 1 to 4."""
        rows = np.asarray(values, dtype=kind).reshape(len(values), -1)
        accessor = {"bufferView": self.view(rows.tobytes()), "componentType": CODES[kind], "count": len(rows)}
        self.header["accessors"].append(accessor | {"type": KINDS[rows.shape[1]]} | more)
        return len(self.header["accessors"]) - 1

    def view(self, data: bytes) -> int:
        """Number of a view of these bytes."""
        self.data += bytes(-len(self.data) % 8)
        self.header["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(self.header["bufferViews"]) - 1

    def box(self, **more: Any) -> dict[str, Any]:
        """A primitive: a box of 0.2 x 0.4 x 0.6 m around the origin; more attributes."""
        attributes = {"POSITION": self.add(BOX.vertices), **more}
        return {"attributes": attributes, "indices": self.add(BOX.faces.ravel(), "uint16")}

    def show(self, *primitives: dict[str, Any], **node: Any) -> "Gltf":
        """One mesh of these primitives on one node of the one scene."""
        self.header |= {"meshes": [{"primitives": list(primitives)}], "nodes": [{"mesh": 0, **node}]}
        self.header |= {"scenes": [{"nodes": [0]}], "scene": 0}
        return self

    def write(self, path: Path) -> Path:
        """The file, .gltf with its buffer inside."""
        text = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.header["buffers"] = [{"byteLength": len(self.data), "uri": text}]
        path.write_text(json.dumps(self.header))
        return path
