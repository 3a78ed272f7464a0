"""Read a URDF with its meshes: shapes, masses, joints; mesh paths that stay inside a folder."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from trimesh import Trimesh

from roomkin.stages.articulated.mesh_reader import convex_pieces, find_reader, has_texture, load_meshes
from roomkin.stages.articulated.mesh_resolver import OutsideError, explain_missing, find_inside
from roomkin.stages.articulated.model import RGBA, JointModel, Link, Matrix, RobotModel, Visual, transform_mesh
from roomkin.stages.articulated.urdf_tree import UrdfTree
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.solids import MINIMUM_MASS, board_mass, box_around, box_inertia


def read_urdf(path: Path, folder: Path) -> RobotModel:
    """Read a URDF; meshes are looked for beside it and in the folders above, up to `folder`.

    Hinges that close at their upper limit are turned round, so that every joint is closed at its lower limit. What is
    left out or assumed is in the remarks: joints and shapes that cannot be used, as long as most of the model can.

    Raises:
        InputError: names the file and the element that is broken, missing, unsupported or outside `folder`.
    """
    reader = UrdfReader(path, folder)
    links = {name: reader.link(name) for name in reader.tree.links}
    reader.check_whole({name for name, link in links.items() if link.visuals})
    if not any(link.visuals for link in links.values()):
        raise InputError(path, "shows nothing: no link has geometry.", code="E-MODEL-UNSEEN")
    name = reader.tree.robot.get("name", Path(path).stem)
    return RobotModel(name, links, reader.joints, remarks=tuple(dict.fromkeys(reader.remarks)))


def close_at_lower(joint: JointModel) -> JointModel:
    """The same joint, turned round if its upper limit is nearer to zero: closed is then the lower one."""
    if joint.type == "fixed" or abs(joint.upper) >= abs(joint.lower):
        return joint
    return replace(joint, axis=-joint.axis, lower=-joint.upper + 0.0, upper=-joint.lower + 0.0)


class UrdfReader:
    """The links of one URDF, read when they are asked for; `joints` are closed at their lower limits.

    Shapes, colors and masses that cannot be used are left out, which `remarks` say.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder = Path(path), Path(folder).resolve()
        self.tree = UrdfTree(self.path)
        self.remarks = self.tree.remarks
        self._broken: dict[str, InputError] = {}  # by link, the first of its shapes that cannot be used
        self.joints = [close_at_lower(joint) for joint in self.tree.joints]

    def link(self, name: str) -> Link:
        """A link with what collides and its mass."""
        element, where = self.tree.links[name], f"link '{name}'"
        visuals, collisions = self._visuals(element, where), element.findall("collision")
        shapes = [self._read_usable(collision, where, visible=False) for collision in collisions]
        visuals = visuals or [visual.transform(np.eye(4)) for shape in shapes for visual in shape]
        pieces = [
            piece
            for collision, shape in zip(collisions, shapes, strict=True)
            for visual in shape  # a box, sphere, cylinder or capsule is convex as it is
            for piece in (convex_pieces(visual.mesh) if collision.find("geometry/mesh") is not None else [visual.mesh])
        ]
        if not any(shapes):
            pieces = [piece for visual in visuals for piece in convex_pieces(visual.mesh)]
        estimate = board_mass(pieces, visuals)
        mass, center, inertia, weighed = self._inertial(element.find("inertial"), pieces, estimate, where)
        return Link(name, visuals, pieces, mass, center, inertia, weighed)

    def visuals(self, name: str) -> list[Visual]:
        """What is seen of a link."""
        element, where = self.tree.links[name], f"link '{name}'"
        return self._visuals(element, where) or self._shapes(element.findall("collision"), where, visible=False)

    def _visuals(self, element: ET.Element, where: str) -> list[Visual]:
        return self._shapes(element.findall("visual"), where, visible=True)

    def _shapes(self, elements: Iterable[ET.Element], where: str, visible: bool) -> list[Visual]:
        return [visual for element in elements for visual in self._read_usable(element, where, visible)]

    def check_whole(self, shown: set[str]) -> None:
        """Refuse the model if links have no shape left that carry others, or are as many as those that have.

        Args:
            shown: links of which something is seen.

        Raises:
            InputError: names the first shape that cannot be used.
        """
        lost = {name: error for name, error in self._broken.items() if name not in shown}
        carries = any(joint.parent in lost for joint in self.joints)
        if lost and (carries or len(lost) >= len(shown)):
            raise next(iter(lost.values()))

    def _read_usable(self, element: ET.Element, where: str, visible: bool) -> list[Visual]:
        """What a shape looks like; nothing if it cannot be used."""
        try:
            return self._shape(element, where, visible)
        except InputError as error:
            self._broken.setdefault(where.removeprefix("link '").removesuffix("'"), error)
            self._remark("left out", error)
            return []

    def _remark(self, what: str, error: InputError) -> None:
        self.remarks.append(f"{what}: {str(error).removeprefix(f'{self.path}: ')}")

    def _shape(self, element: ET.Element, where: str, visible: bool) -> list[Visual]:
        where = f"{where}, <{element.tag}>"
        geometry = element.find("geometry")
        kind = next(iter(geometry), None) if geometry is not None else None
        if kind is None:
            raise InputError(self.path, f"{where}: has no <geometry>.", code="E-URDF-GEOMETRY")
        pose = self.tree.origin(element, where)
        meshes = self._geometry(kind, where, visible)
        if (pose != np.eye(4)).any():
            meshes = [transform_mesh(mesh, pose) for mesh in meshes]
        color = self._color(element, where) if visible else None
        return [Visual(mesh, None if kind.tag == "mesh" and has_texture(mesh) else color) for mesh in meshes]

    def _geometry(self, kind: ET.Element, where: str, visible: bool) -> list[Trimesh]:
        if kind.tag == "mesh":
            one = len(kind.get("scale", "").split()) == 1  # for all axes, as Drake and PyBullet take it
            scale = self.tree.numbers(kind, "scale", "1" if one else "1 1 1", 1 if one else 3, where) * np.ones(3)
            if (scale == 0).any():
                what = f'{where}: scale="{kind.get("scale")}" flattens the mesh.'
                raise InputError(self.path, what, code="E-URDF-NUMBER")
            file = self._mesh_file(kind.get("filename", ""), where)
            meshes, lost = load_meshes(file, self.folder)
            if (up := find_reader(file).up(file)) not in ("", "Z_UP"):
                lost = [*lost, f"{file.name} says {up}: not turned, as a URDF's meshes never are (RViz)"]
            self.remarks += lost if visible else []
            if (scale == 1).all():
                return meshes
            return [transform_mesh(mesh, np.diag([*scale, 1.0])) for mesh in meshes]
        if kind.tag == "box":
            return [trimesh.creation.box(self.tree.positive(kind, "size", 3, where))]
        if kind.tag == "sphere":
            return [trimesh.creation.icosphere(2, float(self.tree.positive(kind, "radius", 1, where)[0]))]
        if kind.tag in ("cylinder", "capsule"):
            radius, length = (float(self.tree.positive(kind, key, 1, where)[0]) for key in ("radius", "length"))
            make = trimesh.creation.cylinder if kind.tag == "cylinder" else trimesh.creation.capsule
            mesh = make(height=length, radius=radius)
            mesh.apply_translation([0, 0, -mesh.bounds.mean(axis=0)[2]])
            return [mesh]
        raise InputError(self.path, f"{where}: <{kind.tag}> is not a known geometry.", code="E-URDF-GEOMETRY")

    def _color(self, element: ET.Element, where: str) -> RGBA | None:
        material = element.find("material")
        if material is None:
            return None
        if (texture := material.find("texture")) is not None:
            name = texture.get("filename", "")
            self.remarks.append(f"{where}: is shown without '{name}', which its mesh does not name")
        found = material.find("color")
        found = self.tree.colors.get(material.get("name", "")) if found is None else found
        if found is None:
            return None
        try:
            r, g, b, a = self.tree.numbers(found, "rgba", "", 4, where, low=0.0).tolist()
        except InputError as error:
            self._remark("without its color", error)
            return None
        if max(r, g, b, a) > 1.0:
            self.remarks.append(f'{where}: rgba="{found.get("rgba")}" is above 1, taken for bytes')
            r, g, b, a = (min(value / 255, 1.0) for value in (r, g, b, a))
        return (r, g, b, a)

    def _inertial(
        self, element: ET.Element | None, pieces: list[Trimesh], mass: float, where: str
    ) -> tuple[float, Matrix, Matrix, bool]:
        """Mass (the given one, if the file says none), center, inertia, and whether the file says the mass.

        What it does not say, or says impossibly, is that of a solid box.
        """
        try:
            return self._read_stated_inertial(element, pieces, mass, where)
        except InputError as error:
            self._remark("weighed by its size", error)
            return self._read_stated_inertial(None, pieces, mass, where)

    def _read_stated_inertial(
        self, element: ET.Element | None, pieces: list[Trimesh], mass: float, where: str
    ) -> tuple[float, Matrix, Matrix, bool]:
        low, high = box_around(pieces)
        weighed = False
        center = (low + high) / 2
        if element is not None and element.find("mass") is not None:
            given = float(self.tree.numbers(element.find("mass"), "value", "0", 1, f"{where}, <mass>", low=0.0)[0])
            mass, weighed = (given, True) if given > MINIMUM_MASS else (mass, False)  # else it is left out, or absurd
            center = self.tree.origin(element, where)[:3, 3] if element.find("origin") is not None else center
        found = element.find("inertia") if element is not None else None
        if found is not None and element is not None:
            xx, xy, xz, yy, yz, zz = (
                self.tree.numbers(found, key, "0", 1, f"{where}, <inertia>")[0]
                for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            )
            rotation = self.tree.origin(element, where)[:3, :3]
            inertia = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
            if np.linalg.eigvalsh(inertia).min() > 0:
                return mass, center, inertia, weighed
        return mass, center, box_inertia(pieces, mass), weighed

    def _mesh_file(self, name: str, where: str) -> Path:
        """The mesh file that a URDF names, inside the folder."""
        plain = re.sub(r"^\$\(find ([^)]*)\)", r"\1", name.replace("\\", "/"))
        plain = plain.removeprefix("package://").removeprefix("file://").lstrip("/")
        with suppress(OutsideError):
            if found := find_inside(plain, self.path.parent, self.folder):
                return found
        raise explain_missing(self.path, f"{where}: there is no mesh", plain, self.path.parent, self.folder)
