"""Read someone else's URDF: meshes, fixed, revolute and prismatic joints, paths that stay inside a folder."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation
from trimesh import Trimesh

from stages.articulated.mesh_reader import convex_pieces, has_texture, load_meshes
from stages.articulated.model import JointModel, Link, Matrix, RobotModel, moved
from stages.contracts.errors import InputError
from stages.geometry.frames import rigid

DENSITY = 500.0  # kg / m^3, for links that say nothing of their mass
MINIMUM_MASS, MINIMUM_INERTIA = 0.01, 1e-7
ROOMY = 1e-4  # metres or radians: joints with a smaller range are fixed


def read_urdf(path: Path, folder: Path) -> RobotModel:
    """Read a URDF; meshes are looked for beside it and in the folders above, up to `folder`.

    Hinges that close at their upper limit are turned round, so that every joint is closed at its lower limit.

    Raises:
        InputError: names the file and the element that is broken, missing, unsupported or outside `folder`.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        if "<!DOCTYPE" in text:
            raise InputError(path, "declares a DOCTYPE, which a URDF does not need.", "remove it")
        robot = ET.fromstring(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read ({error.__class__.__name__}).") from None
    except ET.ParseError as error:
        raise InputError(path, f"is not XML: {error}.") from None
    if robot.tag != "robot":
        raise InputError(path, f"has <{robot.tag}> at the top.", "a URDF starts with <robot>")
    reader = _Reader(path, Path(folder).resolve(), robot)
    links = {name: reader.link(element, name) for name, element in reader.named(robot.findall("link"))}
    if not links:
        raise InputError(path, "has no <link>.")
    joints = [reader.joint(element, name, links) for name, element in reader.named(robot.findall("joint"))]
    children = [joint.child for joint in joints]
    if len(set(children)) != len(children) or len(links) - len(children) != 1:
        raise InputError(path, "its links do not form one tree.", "one root, and one parent joint for each other link")
    if not any(link.visuals for link in links.values()):
        raise InputError(path, "shows nothing: no link has geometry.")
    return RobotModel(robot.get("name", path.stem), links, joints)


class _Reader:
    """Elements of one URDF; complaints name the file and the element."""

    def __init__(self, path: Path, folder: Path, robot: ET.Element) -> None:
        self.path, self.folder = path, folder
        self.colours = {
            m.get("name", ""): m.find("color") for m in robot.iter("material") if m.find("color") is not None
        }

    def named(self, elements: list[ET.Element]) -> list[tuple[str, ET.Element]]:
        pairs = [(element.get("name", ""), element) for element in elements]
        for name, element in pairs:
            if not name:
                raise InputError(self.path, f"a <{element.tag}> has no name.")
        return pairs

    def numbers(self, element: ET.Element | None, key: str, default: str, count: int, where: str) -> Matrix:
        text = default if element is None else element.get(key, default)
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError:
            values = np.array([])
        if len(values) != count or not np.isfinite(values).all():
            raise InputError(self.path, f'{where}: {key}="{text}" is not {count} number(s).')
        return values

    def origin(self, element: ET.Element, where: str) -> Matrix:
        found = element.find("origin")
        xyz = self.numbers(found, "xyz", "0 0 0", 3, where)
        rpy = self.numbers(found, "rpy", "0 0 0", 3, where)
        return rigid(Rotation.from_euler("xyz", rpy).as_matrix(), xyz)

    def link(self, element: ET.Element, name: str) -> Link:
        where = f"link '{name}'"
        visuals = [mesh for shape in element.findall("visual") for mesh in self.shape(shape, where, looks=True)]
        collisions = [mesh for shape in element.findall("collision") for mesh in self.shape(shape, where, looks=False)]
        visuals = visuals or [mesh.copy() for mesh in collisions]
        pieces = [hull for mesh in (collisions or visuals) for hull in convex_pieces(mesh)]
        mass, center, inertia = self.inertial(element.find("inertial"), pieces, where)
        return Link(name, visuals, pieces, mass, center, inertia)

    def inertial(self, element: ET.Element | None, pieces: list[Trimesh], where: str) -> tuple[float, Matrix, Matrix]:
        solid = trimesh.util.concatenate(pieces) if pieces else trimesh.creation.box([0.01, 0.01, 0.01])
        mass = max(sum(abs(piece.volume) for piece in pieces) * DENSITY, MINIMUM_MASS)
        center = np.asarray(solid.bounds.mean(axis=0))
        if element is not None and element.find("mass") is not None:
            given = float(self.numbers(element.find("mass"), "value", "0", 1, where)[0])
            mass = given if given > 0 else mass
            center = self.origin(element, where)[:3, 3] if element.find("origin") is not None else center
        found = element.find("inertia") if element is not None else None
        if found is not None and element is not None:
            xx, xy, xz, yy, yz, zz = (
                self.numbers(found, key, "0", 1, where)[0] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            )
            rotation = self.origin(element, where)[:3, :3]
            inertia = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
            if np.linalg.eigvalsh(inertia).min() > 0:
                return mass, center, inertia
        x, y, z = solid.extents**2  # as a solid box
        return mass, center, mass / 12 * np.diag([y + z, x + z, x + y]) + MINIMUM_INERTIA * np.eye(3)

    def shape(self, element: ET.Element, where: str, looks: bool) -> list[Trimesh]:
        where = f"{where}, <{element.tag}>"
        geometry = element.find("geometry")
        kind = next(iter(geometry), None) if geometry is not None else None
        if kind is None:
            raise InputError(self.path, f"{where}: has no <geometry>.")
        if kind.tag == "mesh":
            scale = self.numbers(kind, "scale", "1 1 1", 3, where)
            meshes = load_meshes(self.file(kind.get("filename", ""), where))
            meshes = [moved(mesh, np.diag([*scale, 1.0])) for mesh in meshes]
        elif kind.tag == "box":
            meshes = [trimesh.creation.box(self.numbers(kind, "size", "", 3, where))]
        elif kind.tag == "sphere":
            meshes = [trimesh.creation.icosphere(2, float(self.numbers(kind, "radius", "", 1, where)[0]))]
        elif kind.tag in ("cylinder", "capsule"):
            radius, length = (float(self.numbers(kind, key, "", 1, where)[0]) for key in ("radius", "length"))
            make = trimesh.creation.cylinder if kind.tag == "cylinder" else trimesh.creation.capsule
            meshes = [make(height=length, radius=radius)]
            meshes[0].apply_translation([0, 0, -meshes[0].bounds.mean(axis=0)[2]])
        else:
            raise InputError(self.path, f"{where}: <{kind.tag}> is not a known geometry.")
        meshes = [moved(mesh, self.origin(element, where)) for mesh in meshes]
        colour = self.colour(element, where) if looks else None
        for mesh in meshes:
            if colour is not None and (kind.tag != "mesh" or not has_texture(mesh)):
                mesh.visual = trimesh.visual.TextureVisuals(material=plain_material(colour))
        return meshes

    def colour(self, element: ET.Element, where: str) -> Matrix | None:
        material = element.find("material")
        if material is None:
            return None
        found = material.find("color")
        found = self.colours.get(material.get("name", "")) if found is None else found
        return None if found is None else self.numbers(found, "rgba", "", 4, where)

    def file(self, name: str, where: str) -> Path:
        """The mesh file that a URDF names, inside the folder."""
        relative = name.removeprefix("package://").removeprefix("file://").lstrip("/")
        here = self.path.resolve().parent
        for base in (here, *here.parents):
            if not base.is_relative_to(self.folder):
                break
            found = (base / relative).resolve()
            if found.is_file():
                if not found.is_relative_to(self.folder):
                    raise InputError(
                        self.path, f"{where}: mesh '{name}' lies outside {self.folder.name}/.", "copy it inside"
                    )
                return found
        if not (here / relative).resolve().is_relative_to(self.folder):
            raise InputError(self.path, f"{where}: mesh '{name}' lies outside {self.folder.name}/.", "copy it inside")
        raise InputError(self.path, f"{where}: there is no mesh '{name}' in {self.folder.name}/.")

    def joint(self, element: ET.Element, name: str, links: dict[str, Link]) -> JointModel:
        where, kind = f"joint '{name}'", element.get("type", "")
        parent, child = (self.end(element, tag, links, where) for tag in ("parent", "child"))
        origin = self.origin(element, where)
        if kind in ("fixed", "continuous"):  # wheels and knobs turn without end: neither doors nor drawers
            return JointModel(name, "fixed", parent, child, origin, np.array([1.0, 0.0, 0.0]))
        if kind not in ("revolute", "prismatic"):
            raise InputError(
                self.path, f"{where}: type '{kind}' is not supported.", "fixed, continuous, revolute or prismatic"
            )
        axis = self.numbers(element.find("axis"), "xyz", "1 0 0", 3, where)
        if np.linalg.norm(axis) < 1e-6:
            raise InputError(self.path, f"{where}: its axis is zero.")
        axis = axis / np.linalg.norm(axis)
        limit = element.find("limit")
        if limit is None:
            raise InputError(self.path, f"{where}: a {kind} joint needs a <limit>.")
        lower, upper = (float(self.numbers(limit, key, "0", 1, where)[0]) for key in ("lower", "upper"))
        if lower > upper:
            raise InputError(self.path, f"{where}: lower limit {lower:g} is above the upper one {upper:g}.")
        if upper - lower < ROOMY or element.find("mimic") is not None:  # a follower of another joint stays put
            return JointModel(name, "fixed", parent, child, origin, np.array([1.0, 0.0, 0.0]))
        if abs(upper) < abs(lower):
            axis, lower, upper = -axis, -upper, -lower
        return JointModel(name, kind, parent, child, origin, axis, lower + 0.0, upper + 0.0)

    def end(self, element: ET.Element, tag: str, links: dict[str, Link], where: str) -> str:
        """The parent or child link of a joint."""
        found = element.find(tag)
        link = "" if found is None else found.get("link", "")
        if link not in links:
            raise InputError(self.path, f"{where}: <{tag}> names no link of this file ('{link}').")
        return link


def plain_material(rgba: Matrix) -> trimesh.visual.material.PBRMaterial:
    """A dull material of one colour."""
    return trimesh.visual.material.PBRMaterial(baseColorFactor=rgba, metallicFactor=0.0, roughnessFactor=0.8)
