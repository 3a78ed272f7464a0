"""Meshes out of a .blend file of Blender 2.5 or 2.6, without Blender: blocks of structs that the file describes."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

CORNERS = np.array([(0, 1, 2), (0, 2, 3)])  # of the triangles of a face


@dataclass(frozen=True)
class Block:
    """`count` structs of one type, one after the other."""

    file: "Blend"
    kind: str
    data: bytes
    count: int

    def read_field(self, name: str, kind: str, width: int = 1) -> NDArray[np.generic]:
        """`width` numbers of a numpy `kind` from the start of a field, of all structs: (count, width)."""
        size, fields = self.file.structs[self.kind]
        start, item = fields[name], np.dtype(kind).itemsize
        rows = np.frombuffer(self.data, np.uint8)[: self.count * size].reshape(self.count, size)
        return np.ascontiguousarray(rows[:, start : start + width * item]).view(kind)

    def follow(self, name: str, index: int = 0) -> "Block | None":
        """What the `index`-th pointer from a field on points to."""
        return self.file.blocks.get(int(self.read_field(name, self.file.pointer, index + 1)[0, index]))

    @property
    def name(self) -> str:
        """As Blender shows it."""
        return self.data[self.file.structs["ID"][1]["name"] :].split(b"\0")[0][2:].decode()


class Blend:
    """A file: `blocks` by address, `objects` among them, `structs` by type: size in bytes, where each field starts."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        wide = data[7:8] == b"-"
        self.pointer = "<u8" if wide else "<u4"
        head = struct.Struct("<4sI" + ("Q" if wide else "I") + "II")
        found, at = [], 12
        while at < len(data):
            code, size, address, kind, count = head.unpack_from(data, at)
            at += head.size
            found.append((code.rstrip(b"\0"), address, kind, count, data[at : at + size]))
            at += size
        names, self.structs = _read_structs(next(body for code, *_, body in found if code == b"DNA1"), 8 if wide else 4)
        self.blocks = {where: Block(self, names[kind], body, count) for _, where, kind, count, body in found if where}
        self.objects = [block for block in self.blocks.values() if block.kind == "Object"]


def _read_structs(data: bytes, pointer: int) -> tuple[list[str], dict[str, tuple[int, dict[str, int]]]]:
    """The block DNA1: types by the index of their struct, and sizes and fields of all structs."""
    at = 8

    def read_words() -> list[str]:
        nonlocal at
        count = struct.unpack_from("<I", data, at)[0]
        pieces = data[at + 4 :].split(b"\0", count)[:count]
        at += 4 + sum(len(piece) + 1 for piece in pieces)
        at += -at % 4 + 4
        return [piece.decode() for piece in pieces]

    names, types = read_words(), read_words()
    sizes = struct.unpack_from(f"<{len(types)}H", data, at)
    at += 2 * len(types)
    at += -at % 4 + 4
    count = struct.unpack_from("<I", data, at)[0]
    at += 4
    order, structs = [], {}
    for _ in range(count):
        kind, fields = struct.unpack_from("<HH", data, at)
        starts, start = {}, 0
        for field in range(fields):
            type_, name = struct.unpack_from("<HH", data, at + 4 + 4 * field)
            bare, *lengths = names[name].replace("]", "").split("[")
            starts[bare.lstrip("*(").split(")")[0]] = start
            each = pointer if bare[0] in "*(" else sizes[type_]
            start += each * int(np.prod([int(length) for length in lengths]))
        at += 4 + 4 * fields
        order.append(types[kind])
        structs[types[kind]] = (sizes[kind], starts)
    return order, structs


@dataclass(frozen=True)
class Piece:
    """Faces of one material: corners (F, 3, 3) in the world, uv (F, 3, 2) or None, color (3,), picture or None."""

    corners: NDArray[np.float64]
    uv: NDArray[np.float64] | None
    color: tuple[float, float, float]
    picture: NDArray[np.uint8] | None


def read_pieces(path: Path, name: str) -> Iterator[Piece]:
    """The mesh of an object and of what hangs on it."""
    file = _open_blend(path)
    for thing in file.objects:
        above: Block | None = thing
        while above is not None and above.name != name:
            above = above.follow("parent")
        mesh = thing.follow("data")
        if above is not None and mesh is not None and mesh.kind == "Mesh":
            yield from _split_mesh(thing, mesh)


@lru_cache(maxsize=4)
def _open_blend(path: Path) -> Blend:
    return Blend(path)


def _split_mesh(thing: Block, mesh: Block) -> Iterator[Piece]:
    points, faces = mesh.follow("mvert"), mesh.follow("mface")
    if points is None or faces is None:
        return
    world = thing.read_field("obmat", "<f4", 16).reshape(4, 4).astype(float)  # rows are axes
    vertices = points.read_field("co", "<f4", 3).astype(float) @ world[:3, :3] + world[3, :3]
    quads = faces.read_field("v1", "<u4", 4).astype(np.int64)
    mapped = mesh.follow("mtface")
    uv = None if mapped is None else mapped.read_field("uv", "<f4", 8).reshape(-1, 4, 2).astype(float)
    numbers = faces.read_field("mat_nr", "<i2")[:, 0]
    for number in np.unique(numbers):
        of = np.flatnonzero(numbers == number)
        index = np.repeat(of, 2)
        corner = np.tile(CORNERS, (len(of), 1))
        keep = ~((corner[:, 2] == 3) & (quads[index, 3] == 0))
        index, corner = index[keep], corner[keep]
        color, picture = _read_surface(_find_material(thing, mesh, int(number)))
        corners = vertices[quads[index[:, None], corner]]
        yield Piece(corners, None if uv is None else uv[index[:, None], corner], color, picture)


def _find_material(thing: Block, mesh: Block, number: int) -> Block | None:
    for owner in (mesh, thing):
        table = owner.follow("mat")
        addresses = np.frombuffer(b"" if table is None else table.data, thing.file.pointer)
        if number < len(addresses) and (found := thing.file.blocks.get(int(addresses[number]))):
            return found
    return None


def _read_surface(material: Block | None) -> tuple[tuple[float, float, float], NDArray[np.uint8] | None]:
    if material is None:
        return (0.7, 0.7, 0.7), None
    red, green, blue = (float(material.read_field(channel, "<f4")[0, 0]) for channel in "rgb")
    for slot in range(18):
        layer = material.follow("mtex", slot)
        texture = layer and layer.follow("tex")
        image = texture and texture.follow("ima")
        packed = image and image.follow("packedfile")
        body = packed and packed.follow("data")
        if body:
            return (red, green, blue), np.array(Image.open(BytesIO(body.data)).convert("RGB"))
    return (red, green, blue), None
