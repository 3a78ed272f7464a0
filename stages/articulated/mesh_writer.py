"""Write meshes: OBJ for what has one colour, GLB for what carries its own looks, with sharp edges where they are."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import trimesh
from trimesh import Trimesh

from stages.articulated.mesh_reader import has_texture
from stages.articulated.model import Visual

SHARP = np.radians(35)  # edges sharper than this stay sharp


def numbers(values: Iterable[float]) -> str:
    """Numbers as URDF wants them: to a hundredth of a millimetre, without -0."""
    return " ".join(f"{round(float(value), 5) + 0.0:g}" for value in values)


def is_box(mesh: Trimesh) -> bool:
    """Whether the mesh fills its axis-aligned bounds."""
    return len(mesh.vertices) == 8 and bool(np.isclose(mesh.volume, np.prod(mesh.extents), rtol=1e-6))


def shaded(visual: Visual) -> Trimesh:
    """The mesh with vertices split where edges are to look sharp."""
    if not visual.flat:
        return trimesh.graph.smooth_shade(visual.mesh, angle=SHARP)
    mesh = visual.mesh
    corners = np.arange(3 * len(mesh.faces)).reshape(-1, 3)
    normals = np.repeat(mesh.face_normals, 3, axis=0)
    return Trimesh(mesh.triangles.reshape(-1, 3), corners, vertex_normals=normals, process=False)


def write_obj(path: Path, meshes: list[Trimesh], normals: bool = True) -> None:
    """Several meshes as one OBJ."""
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    starts = np.cumsum([1, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
    lines = [f"v {numbers(vertex)}" for vertex in vertices]
    if normals:
        vertex_normals = np.concatenate([mesh.vertex_normals for mesh in meshes])
        lines += [f"vn {numbers(np.round(normal, 4))}" for normal in vertex_normals]
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in faces]
    else:
        lines += [f"f {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def write_glb(path: Path, meshes: list[Trimesh]) -> None:
    """Several meshes with their looks as one GLB."""
    scene = trimesh.Scene([_solid_looking(mesh) for mesh in meshes])
    path.write_bytes(trimesh.exchange.gltf.export_glb(scene, include_normals=True))


def _solid_looking(mesh: Trimesh) -> Trimesh:
    """The mesh with a material that is not metal unless it says so (glTF's default is metal), and, where it carries
    neither texture nor colours of vertices, with its sharp edges sharp."""
    if not isinstance(mesh.visual, trimesh.visual.TextureVisuals):
        plain = mesh.visual is None or not mesh.visual.defined
        return trimesh.graph.smooth_shade(mesh, angle=SHARP) if plain else mesh
    material = mesh.visual.material
    material = material.to_pbr() if hasattr(material, "to_pbr") else material.copy()
    if material.metallicFactor is None:
        material.metallicFactor = 0.0
    if has_texture(mesh):
        shaded_mesh, uv = mesh.copy(), mesh.visual.uv
    else:
        shaded_mesh, uv = trimesh.graph.smooth_shade(mesh, angle=SHARP), None
    shaded_mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return shaded_mesh
