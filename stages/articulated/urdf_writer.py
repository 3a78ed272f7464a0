"""Write a `RobotModel` as an asset folder: model.urdf, one GLB per link to see, boxes and convex OBJs to collide."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation
from trimesh import Trimesh

from stages.articulated.mesh_reader import has_texture
from stages.articulated.model import JointModel, Link, Matrix, RobotModel
from stages.contracts.library import Joint
from stages.procedural.shapes import is_box
from stages.procedural.urdf import DOOR_DAMPING, DRAWER_DAMPING, FRICTION, SHARP, numbers, write_obj

HANDLE_NAMES = ("handle", "knob", "nob", "pull", "grip")


def write_robot(robot: RobotModel, folder: Path) -> float:
    """Write the URDF and its meshes; returns the mass in kg."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    root = ET.Element("robot", name=robot.name)
    for number, link in enumerate(robot.links.values()):
        _add_link(root, folder, link, f"link_{number}")
    for joint in robot.joints:
        _add_joint(root, joint)
    ET.indent(root)
    (folder / "model.urdf").write_text(ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
    return sum(link.mass for link in robot.links.values())


def _origin(parent: ET.Element, transform: Matrix) -> None:
    rpy = Rotation.from_matrix(transform[:3, :3]).as_euler("xyz")
    ET.SubElement(parent, "origin", xyz=numbers(transform[:3, 3]), rpy=" ".join(f"{angle + 0.0:.9g}" for angle in rpy))


def _add_link(root: ET.Element, folder: Path, link: Link, stem: str) -> None:
    element = ET.SubElement(root, "link", name=link.name)
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(link.center), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{link.mass:.6g}")
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ET.SubElement(inertial, "inertia", {key: f"{link.inertia[index]:.6g}" for key, index in keys.items()})
    if link.visuals:
        file = f"meshes/{stem}.glb"
        scene = trimesh.Scene([solid_looking(mesh) for mesh in link.visuals])
        (folder / file).write_bytes(trimesh.exchange.gltf.export_glb(scene, include_normals=True))
        visual = ET.SubElement(element, "visual", name=stem)
        ET.SubElement(visual, "origin", xyz="0 0 0", rpy="0 0 0")
        ET.SubElement(ET.SubElement(visual, "geometry"), "mesh", filename=file)
    for number, piece in enumerate(link.collisions):
        collision = ET.SubElement(element, "collision")
        center = piece.bounds.mean(axis=0) if is_box(piece) else np.zeros(3)
        ET.SubElement(collision, "origin", xyz=numbers(center), rpy="0 0 0")
        geometry = ET.SubElement(collision, "geometry")
        if is_box(piece):
            ET.SubElement(geometry, "box", size=numbers(piece.extents))
        else:
            file = f"meshes/{stem}_hull_{number}.obj"
            write_obj(folder / file, [piece], np.zeros(3), normals=False)
            ET.SubElement(geometry, "mesh", filename=file)


def _add_joint(root: ET.Element, joint: JointModel) -> None:
    element = ET.SubElement(root, "joint", name=joint.name, type=joint.type)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    _origin(element, joint.origin)
    if joint.type == "fixed":
        return
    damping = DOOR_DAMPING if joint.type == "revolute" else DRAWER_DAMPING
    ET.SubElement(element, "axis", xyz=" ".join(f"{value + 0.0:.9g}" for value in joint.axis))
    limits = {"lower": numbers([joint.lower]), "upper": numbers([joint.upper])}
    ET.SubElement(element, "limit", limits | {"effort": "100", "velocity": "10"})
    ET.SubElement(element, "dynamics", damping=numbers([damping]), friction=numbers([FRICTION]))


def solid_looking(mesh: Trimesh) -> Trimesh:
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
        shaded, uv = mesh.copy(), mesh.visual.uv
    else:
        shaded, uv = trimesh.graph.smooth_shade(mesh, angle=SHARP), None
    shaded.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return shaded


def contract_joints(robot: RobotModel) -> list[Joint]:
    """Doors (revolute) and drawers (prismatic) as the contract names them."""
    fixed = {joint.child: joint.parent for joint in robot.joints if joint.type == "fixed"}

    def handle_of(link: str) -> str:
        named = (child for child, parent in fixed.items() if parent == link)
        return next((child for child in named if any(word in child.lower() for word in HANDLE_NAMES)), link)

    return [
        Joint(
            name=joint.name,
            type="revolute" if joint.type == "revolute" else "prismatic",
            role="door" if joint.type == "revolute" else "drawer",
            parent=joint.parent,
            link=joint.child,
            axis=tuple(joint.axis.round(9).tolist()),
            lower=round(joint.lower, 5),
            upper=round(joint.upper, 5),
            handle_link=handle_of(joint.child),
        )
        for joint in robot.joints
        if joint.type != "fixed"
    ]
