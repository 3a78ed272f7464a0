"""Write a `RobotModel` as model.urdf and meshes/, with model.srdf where links touch when closed.

What has one color or texture becomes one OBJ per link and color, what carries its own looks one GLB per link; boxes
and convex OBJs collide.
"""

import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation
from trimesh import Trimesh

from roomkin.stages.articulated import mesh_writer
from roomkin.stages.articulated.model import JointModel, Link, Matrix, RobotModel
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.geometry.frames import ROUNDING, make_transform

DAMPING, FRICTION = 2.0, 0.1  # N m s or N s / m, and SAPIEN's friction coefficient
SURFACE_FRICTION = 0.6  # coefficient of what collides, which URDF cannot say
PLAIN_NAME = re.compile(r"(?!link_)(?!.*hull)[a-z][a-z0-9_]{0,40}")


def write_urdf(robot: RobotModel, folder: Path) -> Path:
    """Write the URDF and its meshes into a folder, which is made."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    root = ET.Element("robot", name=robot.name)
    joint_of = {joint.child: joint for joint in robot.joints}
    moving = {joint.name for joint in robot.joints if joint.type != "fixed"}
    for stem, link in zip(_file_stems(list(robot.links)), robot.links.values(), strict=True):
        _add_link(root, folder, link, stem)
        if link.name in joint_of:
            _add_joint(root, joint_of[link.name], moving)
    _write_xml(root, folder / "model.urdf")
    if robot.touching:  # by which SAPIEN lets links that touch when closed pass through each other
        root = ET.Element("robot", name=robot.name)
        for one, other in robot.touching:
            ET.SubElement(root, "disable_collisions", link1=one, link2=other, reason="Default")
        _write_xml(root, folder / "model.srdf")
    return folder


def _write_xml(root: ET.Element, path: Path) -> None:
    ET.indent(root)
    path.write_text(ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")


def as_written(robot: RobotModel) -> RobotModel:
    """The model with what collides, and the origins of its joints, to the digits that its files have."""
    rounded = {name: list(map(_round_piece, link.collisions)) for name, link in robot.links.items()}
    links = {name: replace(link, collisions=rounded[name]) for name, link in robot.links.items()}
    frames = [make_transform(joint.origin[:3, :3], joint.origin[:3, 3].round(5)) for joint in robot.joints]
    joints = [replace(joint, origin=frame) for joint, frame in zip(robot.joints, frames, strict=True)]
    return replace(robot, links=links, joints=joints)


def _round_piece(piece: Trimesh) -> Trimesh:
    if not mesh_writer.is_box(piece):
        return Trimesh(piece.vertices.round(5), piece.faces, process=False)
    box = trimesh.creation.box(np.maximum(piece.extents, 1e-5).round(5))
    return box.apply_translation(piece.bounds.mean(axis=0).round(5))


def _file_stems(links: list[str]) -> list[str]:
    """Mesh files are called after their links where the names of all links make good file names, else numbered."""
    if all(PLAIN_NAME.fullmatch(name) for name in links):
        return links
    return [f"link_{number}" for number in range(len(links))]


def _add_link(root: ET.Element, folder: Path, link: Link, stem: str) -> None:
    element = ET.SubElement(root, "link", name=link.name)
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(link.center), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{link.mass:.6g}")
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    inertia = np.where(abs(link.inertia) < ROUNDING * np.trace(link.inertia), 0.0, link.inertia)
    ET.SubElement(inertial, "inertia", {key: f"{inertia[index]:.6g}" for key, index in keys.items()})
    _add_visuals(element, folder, link, stem)
    for number, piece in enumerate(link.collisions):
        collision = ET.SubElement(element, "collision")
        if mesh_writer.is_box(piece):
            ET.SubElement(collision, "origin", xyz=numbers(piece.bounds.mean(axis=0)), rpy="0 0 0")
            ET.SubElement(ET.SubElement(collision, "geometry"), "box", size=numbers(np.maximum(piece.extents, 1e-5)))
        else:
            file = f"meshes/{stem}_hull_{number}.obj"
            mesh_writer.write_obj(folder / file, [mesh_writer.TriangleSurface(piece.vertices, piece.faces)])
            _add_mesh(collision, file)


def _add_visuals(element: ET.Element, folder: Path, link: Link, stem: str) -> None:
    finishes = dict.fromkeys((visual.color, visual.texture) for visual in link.visuals if visual.color is not None)
    for number, (color, texture) in enumerate(finishes):
        name = f"{stem}_{number}"
        shown = ET.SubElement(element, "visual", name=name)
        _add_mesh(shown, f"meshes/{name}.obj")
        alike = [visual for visual in link.visuals if (visual.color, visual.texture) == (color, texture)]
        mesh_writer.write_obj(folder / f"meshes/{name}.obj", list(map(mesh_writer.split_sharp_edges, alike)), texture)
        if texture is None:
            ET.SubElement(ET.SubElement(shown, "material", name=name), "color", rgba=numbers(color or ()))
        else:
            mesh_writer.write_texture(folder / "meshes", texture)
    own: list[Trimesh] = [visual.mesh for visual in link.visuals if visual.color is None]
    if own:
        mesh_writer.write_glb(folder / f"meshes/{stem}.glb", own)
        _add_mesh(ET.SubElement(element, "visual", name=stem), f"meshes/{stem}.glb")


def _add_mesh(element: ET.Element, file: str) -> None:
    ET.SubElement(element, "origin", xyz="0 0 0", rpy="0 0 0")
    ET.SubElement(ET.SubElement(element, "geometry"), "mesh", filename=file)


def _add_joint(root: ET.Element, joint: JointModel, moving: set[str]) -> None:
    element = ET.SubElement(root, "joint", name=joint.name, type=joint.type)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    turn = _format_values(_roll_pitch_yaw(joint.origin))
    ET.SubElement(element, "origin", xyz=numbers(joint.origin[:3, 3]), rpy=turn)
    if joint.type == "fixed":
        return
    ET.SubElement(element, "axis", xyz=_format_values(joint.axis))
    limits = {"lower": numbers([joint.lower]), "upper": numbers([joint.upper])}
    ET.SubElement(element, "limit", limits | {"effort": "100", "velocity": "10"})
    if joint.follows in moving:
        ET.SubElement(element, "mimic", joint=joint.follows, multiplier="1", offset="0")
    dynamics = {"damping": numbers([DAMPING]), "friction": numbers([FRICTION])}
    if joint.part_type and (spring := PARTS[joint.part_type].spring):
        dynamics["stiffness"] = numbers([spring])  # no URDF of the standard has it: readers that do not know it skip it
    ET.SubElement(element, "dynamics", dynamics)


def numbers(values: Iterable[float]) -> str:
    """Numbers as URDF wants them: to a hundredth of a millimetre, without -0."""
    return " ".join(f"{round(float(value), 5) + 0.0:g}" for value in values)


def _roll_pitch_yaw(transform: Matrix) -> Matrix:
    if (transform[:3, :3] == np.eye(3)).all():
        return np.zeros(3)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Gimbal lock")  # any of the angles will do
        return np.asarray(Rotation.from_matrix(transform[:3, :3]).as_euler("xyz"))


def _format_values(values: Matrix) -> str:
    return " ".join(f"{value + 0.0:.9g}" for value in values)
