"""A glTF file's header and numbers: its accessors as arrays of real numbers, and new ones in their place."""

import json
import struct
from base64 import b64decode
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.articulated.mesh_resolver import MeshResolver

Header = dict[str, Any]
Numbers = NDArray[np.float64]
MAGIC = b"glTF"
TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
LARGEST = {"i1": 127, "u1": 255, "i2": 32767, "u2": 65535}  # what is 1 in a normalized accessor


def header_of(data: bytes) -> tuple[Header, bytes]:
    """The header of a .glb or .gltf file and its binary chunk.

    Raises:
        ValueError: it is no glTF.
    """
    try:
        if data[:4] != MAGIC:
            header, binary = json.loads(data), b""
        else:
            end = 20 + struct.unpack("<I", data[12:16])[0]
            header, binary = json.loads(data[20:end]), data[end + 8 :]
    except (ValueError, struct.error) as error:
        raise ValueError(f"its header is broken ({error})") from None
    if not isinstance(header, dict):
        raise ValueError("its header is no object")
    if not str(version := header.get("asset", {}).get("version", "2")).startswith("2"):
        raise ValueError(f"it is glTF {version}, and 2.0 is read")
    return header, binary


class Accessors:
    """The numbers of a file with one binary chunk, into which all its buffers have been put.

    Args:
        header: of the file; its buffers, their views and accessors are changed.
    """

    def __init__(self, header: Header, binary: bytes, files: MeshResolver) -> None:
        self.header = header
        self._chunk, starts = bytearray(), list[int]()
        for buffer in header.get("buffers", []):
            starts.append(len(self._chunk))
            self._chunk += _buffer(buffer, binary, files)
            self._pad()
        for view in header.get("bufferViews", []):
            if not 0 <= view["buffer"] < len(starts):
                raise ValueError(f"it has no buffer {view['buffer']}")
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
            view["buffer"] = 0
        header.setdefault("bufferViews", [])
        header.setdefault("accessors", [])

    def read(self, number: int) -> Numbers:
        """(count, columns) of an accessor: sparse values put in, integers that stand for shares divided."""
        accessor = self.header["accessors"][number]
        kind, columns, count = np.dtype(TYPES[accessor["componentType"]]), COLUMNS[accessor["type"]], accessor["count"]
        values = np.zeros((count, columns), dtype=kind)
        if "bufferView" in accessor:
            values = self._rows(accessor["bufferView"], accessor.get("byteOffset", 0), count, columns, kind).copy()
        if sparse := accessor.get("sparse"):
            at, new = sparse["indices"], sparse["values"]
            where = self._rows(
                at["bufferView"], at.get("byteOffset", 0), sparse["count"], 1, np.dtype(TYPES[at["componentType"]])
            )
            values[where[:, 0]] = self._rows(
                new["bufferView"], new.get("byteOffset", 0), sparse["count"], columns, kind
            )
        if accessor.get("normalized") and kind.kind in "iu":
            return np.maximum(values / LARGEST[f"{kind.kind}{kind.itemsize}"], -1.0)
        return values.astype(np.float64)

    def bytes_of(self, view: int) -> bytes:
        """The bytes of a buffer's view."""
        found = self.header["bufferViews"][view]
        data = bytes(self._chunk[found["byteOffset"] : found["byteOffset"] + found["byteLength"]])
        if len(data) < found["byteLength"]:
            raise ValueError("a view reads beyond its buffer")
        return data

    def add(self, values: NDArray[Any], kind: str, normalized: bool = False) -> int:
        """Number of a new accessor of that type, e.g. VEC3, which holds the values: of 4 bytes real, or as they are."""
        values = np.ascontiguousarray(
            values, dtype="<f4" if values.dtype.kind == "f" else values.dtype.newbyteorder("<")
        )
        code = next(code for code, name in TYPES.items() if np.dtype(name) == values.dtype)
        view = {"buffer": 0, "byteOffset": len(self._chunk), "byteLength": values.nbytes}
        self._chunk += values.tobytes()
        self._pad()
        self.header["bufferViews"].append(view)
        accessor = {"bufferView": len(self.header["bufferViews"]) - 1, "componentType": code, "type": kind}
        self.header["accessors"].append(accessor | {"count": len(values), "normalized": normalized})
        return len(self.header["accessors"]) - 1

    def pack_glb(self) -> bytes:
        """The whole as a .glb file."""
        self.header["buffers"] = [{"byteLength": len(self._chunk)}]
        text = json.dumps(self.header).encode()
        text += b" " * (-len(text) % 4)
        chunks = (struct.pack("<I4s", len(text), b"JSON"), text, struct.pack("<I4s", len(self._chunk), b"BIN"))
        body = b"".join([*chunks, bytes(self._chunk)])
        return MAGIC + struct.pack("<II", 2, 12 + len(body)) + body

    def _rows(self, view: int, offset: int, count: int, columns: int, kind: np.dtype[Any]) -> NDArray[Any]:
        found = self.header["bufferViews"][view]
        start, width = found["byteOffset"] + offset, columns * kind.itemsize
        stride = found.get("byteStride") or width
        if min(start, offset, count - 1) < 0 or offset + (count - 1) * stride + width > found["byteLength"]:
            raise ValueError("an accessor reads beyond its buffer")
        data = np.frombuffer(self._chunk, np.uint8, (count - 1) * stride + width, start)
        rows = np.lib.stride_tricks.as_strided(data, (count, width), (stride, 1))
        return np.ascontiguousarray(rows).view(kind).reshape(count, columns)

    def _pad(self) -> None:
        self._chunk += bytes(-len(self._chunk) % 8)


def _buffer(buffer: Header, binary: bytes, files: MeshResolver) -> bytes:
    """The bytes of a buffer, as many as it says."""
    name, length = buffer.get("uri"), buffer["byteLength"]
    if name is None:
        data = binary
    elif name.startswith("data:"):
        data = b64decode(name.partition(",")[2])
    elif (file := files.find(name)) is None:
        raise ValueError(f"its buffer '{name[:200]}' is not in {files.folder.name}/")
    else:
        data = file.read_bytes()
    if len(data) < length:
        raise ValueError(f"a buffer holds {len(data)} bytes of {length}")
    return data[:length]
