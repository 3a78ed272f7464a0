"""What is seen of a link, as other tools' formats want it: triangles with normals, one color, perhaps a texture."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.articulated.mesh_reader import has_texture
from roomkin.stages.articulated.mesh_writer import split_sharp_edges
from roomkin.stages.articulated.model import RGBA, Link, Visual
from roomkin.stages.contracts.generated import GAMMA

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ColoredMesh:
    """vertices and normals (V, 3), faces (F, 3); color linear; uv (V, 2) where there is an image."""

    vertices: Array
    faces: NDArray[np.int64]
    normals: Array
    color: RGBA
    uv: Array | None = None
    image: Image.Image | None = None

    @property
    def shown_color(self) -> RGBA:
        """The color as a screen shows it (sRGB, nearly)."""
        r, g, b = (round(value ** (1 / GAMMA), 4) for value in self.color[:3])
        return r, g, b, self.color[3]


def surfaces(link: Link) -> list[ColoredMesh]:
    """What is seen of a link, in its frame; everything of one color is one surface."""
    plain: dict[RGBA, list[ColoredMesh]] = {}
    textured = []
    for visual in link.visuals:
        if visual.color is None and has_texture(visual.mesh):
            textured.append(_textured(visual))
            continue
        color = visual.color or _color(visual.mesh.visual)
        pieces = split_sharp_edges(visual)
        normals = pieces.normals if pieces.normals is not None else np.zeros_like(pieces.vertices)
        plain.setdefault(color, []).append(ColoredMesh(pieces.vertices, pieces.faces, normals, color))
    return [_merge_parts(parts) for parts in plain.values()] + textured


def write_obj(surface: ColoredMesh, path: Path) -> None:
    """An OBJ with normals and, where there are any, texture coordinates."""
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in surface.vertices + 0.0]
    lines += [f"vn {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in surface.normals + 0.0]
    if surface.uv is not None:
        lines += [f"vt {u:.5f} {v:.5f}\n" for u, v in surface.uv]
    corner = "{0}/{0}/{0}" if surface.uv is not None else "{0}//{0}"
    lines += ["f " + " ".join(corner.format(index) for index in face) + "\n" for face in (surface.faces + 1).tolist()]
    path.write_text("".join(lines), encoding="ascii")


def _merge_parts(parts: list[ColoredMesh]) -> ColoredMesh:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return ColoredMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]),
        np.concatenate([part.normals for part in parts]),
        parts[0].color,
    )


def _textured(visual: Visual) -> ColoredMesh:
    mesh = visual.mesh
    shown: Any = mesh.visual
    material = shown.material
    material = material.to_pbr() if hasattr(material, "to_pbr") else material
    color = (1.0, 1.0, 1.0, 1.0) if material.baseColorFactor is None else _rgba(material.baseColorFactor)
    uv = np.asarray(shown.uv, dtype=np.float64)
    vertices, normals = np.asarray(mesh.vertices), np.asarray(mesh.vertex_normals)
    return ColoredMesh(vertices, np.asarray(mesh.faces), normals, color, uv, material.baseColorTexture)


def _color(visual: Any) -> RGBA:
    """The one color of a mesh that carries its own material."""
    material = getattr(visual, "material", visual)
    given = getattr(material, "baseColorFactor", None)
    return _rgba(getattr(material, "main_color", (160, 160, 160, 255)) if given is None else given)


def _rgba(values: Any) -> RGBA:
    """From 0 to 255 each."""
    r, g, b, a = (round(float(value) / 255, 4) for value in values)
    return r, g, b, a
