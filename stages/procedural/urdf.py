"""Write a model as URDF: one OBJ per link and colour, primitives or convex OBJs to collide, inertia from the solids."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Trimesh

from stages.procedural.model import Model, Part
from stages.procedural.shapes import is_box

Vector = tuple[float, float, float]

DOOR_DAMPING, DRAWER_DAMPING, FRICTION = 2.0, 2.0, 0.1  # N m s, N s / m, and SAPIEN's friction coefficient
SHARP = np.radians(35)  # edges sharper than this stay sharp in smooth parts
MINIMUM_INERTIA = 1e-7


def numbers(values: Iterable[float]) -> str:
    """Numbers as URDF wants them: to a hundredth of a millimetre, without -0."""
    return " ".join(f"{round(float(value), 5) + 0.0:g}" for value in values)


def write_urdf(model: Model, folder: Path, name: str) -> float:
    """Write `model.urdf` and `meshes/`; returns the mass in kg."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    robot = ET.Element("robot", name=name)
    mass = _add_link(robot, folder, "base", model.base, np.zeros(3))
    for moving in model.moving:
        mass += _add_link(robot, folder, moving.name, moving.parts, np.array(moving.origin))
        joint = ET.SubElement(
            robot, "joint", name=f"{moving.name}_joint", type="revolute" if moving.role == "door" else "prismatic"
        )
        ET.SubElement(joint, "parent", link="base")
        ET.SubElement(joint, "child", link=moving.name)
        ET.SubElement(joint, "origin", xyz=numbers(moving.origin), rpy="0 0 0")
        ET.SubElement(joint, "axis", xyz=numbers(moving.axis))
        ET.SubElement(joint, "limit", lower="0", upper=numbers([moving.upper]), effort="100", velocity="10")
        damping = DOOR_DAMPING if moving.role == "door" else DRAWER_DAMPING
        ET.SubElement(joint, "dynamics", damping=numbers([damping]), friction=numbers([FRICTION]))
    ET.indent(robot)
    (folder / "model.urdf").write_text(ET.tostring(robot, encoding="unicode") + "\n", encoding="utf-8")
    return mass


def _add_link(robot: ET.Element, folder: Path, name: str, parts: list[Part], origin: NDArray[np.float64]) -> float:
    link = ET.SubElement(robot, "link", name=name)
    mass, center, inertia = mass_properties(parts)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(center - origin), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{mass:.6g}")
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ET.SubElement(inertial, "inertia", {key: f"{inertia[index]:.6g}" for key, index in keys.items()})

    colours = list(dict.fromkeys(part.colour for part in parts))
    for index, colour in enumerate(colours):
        file = f"meshes/{name}_{index}.obj"
        write_obj(folder / file, [shaded(part) for part in parts if part.colour == colour], origin)
        visual = ET.SubElement(link, "visual", name=f"{name}_{index}")
        ET.SubElement(visual, "origin", xyz="0 0 0", rpy="0 0 0")
        ET.SubElement(ET.SubElement(visual, "geometry"), "mesh", filename=file)
        material = ET.SubElement(visual, "material", name=f"{name}_{index}")
        ET.SubElement(material, "color", rgba=numbers([*colour, 1.0]))

    for index, piece in enumerate(piece for part in parts for piece in part.pieces):
        collision = ET.SubElement(link, "collision")
        if is_box(piece):
            ET.SubElement(collision, "origin", xyz=numbers(piece.bounds.mean(axis=0) - origin), rpy="0 0 0")
            ET.SubElement(ET.SubElement(collision, "geometry"), "box", size=numbers(piece.extents))
        else:
            file = f"meshes/{name}_hull_{index}.obj"
            write_obj(folder / file, [piece], origin, normals=False)
            ET.SubElement(collision, "origin", xyz="0 0 0", rpy="0 0 0")
            ET.SubElement(ET.SubElement(collision, "geometry"), "mesh", filename=file)
    return mass


def shaded(part: Part) -> Trimesh:
    """The part's mesh with vertices split where edges are to look sharp."""
    if part.smooth:
        return trimesh.graph.smooth_shade(part.mesh, angle=SHARP)
    mesh = part.mesh.copy()
    mesh.unmerge_vertices()
    return mesh


def write_obj(path: Path, meshes: list[Trimesh], origin: NDArray[np.float64], normals: bool = True) -> None:
    """Several meshes as one OBJ, with `origin` taken off."""
    vertices = np.concatenate([mesh.vertices for mesh in meshes]) - origin
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


def mass_properties(parts: list[Part]) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Mass (kg), centre of mass (asset frame) and inertia about it, (3, 3), of solids of uniform density."""
    masses = np.array([abs(part.mesh.volume) * part.density for part in parts])
    centers = np.array([part.mesh.center_mass for part in parts])
    mass = float(masses.sum())
    center = masses @ centers / mass
    inertia = np.zeros((3, 3))
    for part, m, own in zip(parts, masses, centers, strict=True):
        offset = own - center
        inertia += part.mesh.moment_inertia * part.density
        inertia += m * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, center, inertia + MINIMUM_INERTIA * np.eye(3)
