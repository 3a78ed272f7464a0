"""Write meshes: OBJ of one color, GLB with its own looks, and what is seen of a link for other tools' formats."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from trimesh import Trimesh

from roomkin.stages.articulated.mesh_reader import TEXTURES, has_texture
from roomkin.stages.articulated.model import RGBA, Link, Texture, Visual
from roomkin.stages.contracts.generated import GAMMA

SHARP = np.radians(35)  # edges sharper than this stay sharp
MOST_TEXELS = 1024  # along a side of a picture: renderers hold all of them in memory, per part


def is_box(mesh: Trimesh) -> bool:
    """Whether the mesh, convex, fills its axis-aligned bounds: its vertices are their eight corners."""
    vertices = np.asarray(mesh.vertices)
    if len(vertices) != 8:
        return False
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    upper = vertices - low > (high - low) / 2
    at_corners = np.abs(vertices - np.where(upper, high, low)).max() < 1e-6 * (high - low).max()
    return bool(at_corners) and len(np.unique(upper @ (1, 2, 4))) == 8


class TriangleSurface(NamedTuple):
    """Triangles: vertices (V, 3), faces (F, 3) that index them, and where they are to be seen normals (V, 3), where
    they carry a texture its coordinates at the corners of every face (3 F, 2)."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None


def split_sharp_edges(visual: Visual) -> TriangleSurface:
    """The mesh with vertices split where edges are to look sharp."""
    vertices, triangles = np.asarray(visual.mesh.vertices), np.asarray(visual.mesh.faces)
    corners = vertices[triangles]
    if not visual.flat:
        return _smooth(vertices, triangles)._replace(uv=_uv(visual, corners))
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return TriangleSurface(corners.reshape(-1, 3), faces, np.repeat(across, 3, axis=0), _uv(visual, corners))


def _smooth(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> TriangleSurface:
    """Faces that meet at no sharp edge share their vertices and their normals there, the mean by area."""
    areas = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 1]])
    normals = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), 1e-30)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1) @ (len(vertices), 1)
    order = np.argsort(edges, kind="stable")
    twins = np.flatnonzero(np.diff(edges[order]) == 0)
    one, other = order[twins] // 3, order[twins + 1] // 3
    soft = (normals[one] * normals[other]).sum(axis=1) > np.cos(SHARP)
    links = coo_array((np.ones(soft.sum()), (one[soft], other[soft])), shape=(len(faces), len(faces)))
    patch = connected_components(links, directed=False)[1]
    at, first, corner = np.unique(
        faces.ravel() * np.int64(len(faces)) + patch.repeat(3), return_index=True, return_inverse=True
    )
    total = np.stack([np.bincount(corner, areas[:, axis].repeat(3), len(at)) for axis in range(3)], axis=1)
    unit = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
    return TriangleSurface(vertices[faces.ravel()[first]], corner.reshape(-1, 3).astype(np.int64), unit)


def _uv(visual: Visual, corners: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Where the texture's picture lies on faces with these corners (F, 3, 3): seen along the axis that a face looks
    along most, the picture's grain along the longest extent of the mesh that is seen."""
    if visual.texture is None:
        return None
    across = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]))
    by_extent = np.argsort(-np.ptp(corners.reshape(-1, 3), axis=0).round(6), kind="stable")
    plane = np.array([[axis for axis in by_extent if axis != facing] for facing in range(3)])
    uv = np.take_along_axis(corners, plane[across.argmax(axis=1)][:, None, :], axis=2)
    return np.asarray((uv / visual.texture.repeat + visual.start).reshape(-1, 2))


def write_obj(path: Path, surfaces: list[TriangleSurface], texture: Texture | None = None) -> None:
    """Several surfaces as one OBJ, with a texture that lies beside it (`write_texture`)."""
    starts = np.cumsum([1, *(len(surface.vertices) for surface in surfaces)])
    faces = np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=False)])
    text = _lines("v %g %g %g\n", np.concatenate([surface.vertices for surface in surfaces]).round(5) + 0.0)
    if texture is not None:
        text = f"mtllib {texture.name}.mtl\nusemtl {texture.name}\n{text}"
        text += _lines("vt %g %g\n", np.concatenate([each.uv for each in surfaces if each.uv is not None]).round(4))
    normals = [surface.normals for surface in surfaces if surface.normals is not None]
    if normals:
        text += _lines("vn %g %g %g\n", np.concatenate(normals).round(4) + 0.0)
    if texture is not None:
        corners = np.arange(1, 3 * len(faces) + 1).reshape(-1, 3)
        text += _lines("f %d/%d/%d %d/%d/%d %d/%d/%d\n", np.stack([faces, corners, faces], axis=2))
    elif normals:
        text += _lines("f %d//%d %d//%d %d//%d\n", faces.repeat(2, axis=1))
    else:
        text += _lines("f %d %d %d\n", faces)
    path.write_text(text, encoding="ascii")


def write_texture(folder: Path, texture: Texture) -> None:
    """The picture and the material that OBJs beside it name."""
    (folder / f"{texture.name}.jpg").write_bytes(texture.image)
    material = f"newmtl {texture.name}\nKd 1 1 1\nKs 0 0 0\nmap_Kd {texture.name}.jpg\n"
    (folder / f"{texture.name}.mtl").write_text(material, encoding="ascii")


def _lines(line: str, rows: NDArray[Any]) -> str:
    """The rows, each in the format of a line."""
    return (line * len(rows)) % tuple(rows.ravel().tolist())


def write_glb(path: Path, meshes: list[Trimesh]) -> None:
    """Several meshes with their looks as one GLB."""
    scene = trimesh.Scene([_solid_looking(mesh) for mesh in meshes])
    path.write_bytes(trimesh.exchange.gltf.export_glb(scene, include_normals=True))


def _solid_looking(mesh: Trimesh) -> Trimesh:
    """The mesh with a material that is not metal unless it says so (glTF's default is metal), and, where it carries
    no texture, with its sharp edges sharp."""
    if not isinstance(mesh.visual, trimesh.visual.TextureVisuals):
        plain = mesh.visual is None or not mesh.visual.defined
        return trimesh.graph.smooth_shade(mesh, angle=SHARP) if plain else _painted_by_picture(mesh)
    material = mesh.visual.material
    material = material.to_pbr() if hasattr(material, "to_pbr") else material.copy()
    if material.metallicFactor is None:
        material.metallicFactor = 0.0
    for kind in TEXTURES:
        picture = getattr(material, kind, None)
        if picture is not None and max(picture.size) > MOST_TEXELS:
            smaller = picture.copy()
            smaller.thumbnail((MOST_TEXELS, MOST_TEXELS))
            setattr(material, kind, smaller)
    if has_texture(mesh):
        shaded_mesh, uv = mesh.copy(), mesh.visual.uv
    else:
        shaded_mesh, uv = trimesh.graph.smooth_shade(mesh, angle=SHARP), None
    shaded_mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return shaded_mesh


def _painted_by_picture(mesh: Trimesh) -> Trimesh:
    """The mesh with the colors of its corners or faces in a picture, one texel each: renderers show no others. A face
    whose corners differ has their mean."""
    visual: Any = mesh.visual
    colors = visual.face_colors if visual.kind == "face" else visual.vertex_colors[mesh.faces].mean(axis=1).round()
    colors = np.asarray(colors, dtype=np.uint8)
    if len(np.unique(colors, axis=0)) > MOST_TEXELS**2:
        colors = colors // 8 * 8 + 4
    shades, texel = np.unique(colors, axis=0, return_inverse=True)
    side = int(np.ceil(np.sqrt(len(shades))))
    texels = np.resize(shades, (side * side, 4)).reshape(side, side, 4)
    welded = Trimesh(mesh.vertices, mesh.faces, process=False)
    welded.merge_vertices()
    shape = _smooth(np.asarray(welded.vertices), np.asarray(welded.faces))
    row, column = np.divmod(texel.ravel().repeat(3), side)
    uv = np.stack([(column + 0.5) / side, 1 - (row + 0.5) / side], axis=1)
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(texels), metallicFactor=0.0, roughnessFactor=0.8
    )
    return Trimesh(
        shape.vertices[shape.faces.ravel()],
        np.arange(3 * len(shape.faces)).reshape(-1, 3),
        vertex_normals=None if shape.normals is None else shape.normals[shape.faces.ravel()],
        visual=trimesh.visual.TextureVisuals(uv=uv, material=material),
        process=False,
    )


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


def write_colored_obj(surface: ColoredMesh, path: Path) -> None:
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
