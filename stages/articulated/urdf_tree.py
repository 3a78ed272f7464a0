"""The kinematic tree of a URDF: its XML, its numbers and its joints, checked; complaints name file and element."""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.model import JointModel, JointType, Matrix
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.types import RIGID_TOLERANCE
from roomkin.stages.geometry.frames import make_transform

MOST_LINKS = 1000
MOST_SHAPES = 10_000  # of all links together: MuJoCo takes 3 s for so many, and four times that for twice as many
WORLD = "world"
AROUND = " \t\r\n\0\x1a"  # the document, in files of other programs: XML allows nothing before it
MAX_NUMBER = 1e6  # of any number: beyond it is a slip, in whatever unit
WIDEST_ANGLE = 4 * np.pi  # limits of a hinge; beyond them, up to a turn in degrees, they are degrees
THIN = 1e-4  # metres, or radians of a joint: a piece this thin is thickened, a joint that moves less is fixed
# What URDF has in each element; other programs' elements that say nothing of shapes are passed over.
READ = {
    "robot": {"link", "joint", "material", "transmission", "gazebo", "mujoco", "drake_ignore_self_collisions"},
    "link": {"visual", "collision", "inertial", "contact", "self_collision_checking", "verbose"},
    "joint": {"origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "calibration", "safety_controller"},
    "visual": {"origin", "geometry", "material"},
    "collision": {"origin", "geometry", "material", "contact_coefficients", "verbose"},
}
ONE_TREE = "one root, and one parent joint for each other link"
LOOSE = ("continuous", "floating", "planar")  # types of joints that are fixed


def _clean_xml(text: str) -> str:
    """XML without what robots' files get wrong: comments in comments, names of spaces that are declared nowhere, and
    blanks around it."""
    commented, end, rest = text.rpartition("-->")  # after the last, every search for one would read to the end
    text = re.sub(r"<!--.*?-->", "", commented + end, flags=re.DOTALL) + rest
    text = re.sub(r"""\sxmlns(:[\w.-]+)?\s*=\s*("[^"]*"|'[^']*')""", "", text)
    text = re.sub(r"(</?[\w.-]+):", r"\1_", text)
    return re.sub(r"""(\s[\w.-]+):([\w.-]+\s*=\s*["'])""", r"\1_\2", text).strip(AROUND)


def _unread(above: ET.Element) -> list[str]:
    """Tags in an element that nothing here reads, and that may be part of the model."""
    known = READ.get(above.tag)
    return [] if known is None else [child.tag for child in above if child.tag not in known]


class UrdfTree:
    """Links and joints of one URDF.

    Attributes:
        links: the <link> elements by name.
        joints: parents before children. Continuous joints (wheels, knobs) and those of loose things (floating, planar)
            are fixed: none is a door or a drawer. So are those that follow another otherwise than the second leaf of a
            pair of doors, and those whose axis or limits say nothing: one of them is no reason to lose the model.
        root: name of the one link that is no joint's child.
        remarks: what was fixed or assumed, in lines.

    Raises:
        InputError: the file is missing or no URDF, or its joints form no single tree.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.remarks = Path(path), list[str]()
        self.robot = self._parse()
        self.links = self._index_named("link")
        if not self.links:
            raise InputError(path, "has no <link>.", code="E-URDF-ELEMENT")
        if len(self.links) > MOST_LINKS:
            raise InputError(path, f"has {len(self.links)} links.", f"at most {MOST_LINKS}", code="E-MODEL-PARTS")
        if (shapes := sum(element.tag in ("visual", "collision") for element in self.robot.iter())) > MOST_SHAPES:
            raise InputError(path, f"has {shapes} shapes.", f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")
        if any(end.get("link") == WORLD for end in self.robot.findall("joint/parent")):  # some need not declare it
            self.links.setdefault(WORLD, ET.Element("link", name=WORLD))
        elements = self._index_named("joint")
        alone = {name: self._joint(element, name) for name, element in elements.items()}
        joints = [self._couple_joint(joint, elements[name], alone) for name, joint in alone.items()]
        for kind in LOOSE:
            if names := [f"'{name}'" for name, element in elements.items() if element.get("type") == kind]:
                self.remarks.append(f"fixed, as no door or drawer: {', '.join(names)} ({kind})")
        self.root, self.joints = self._order_joints(joints)

    def _parse(self) -> ET.Element:
        try:
            text = _clean_xml(decode_file(self.path))
        except UnicodeDecodeError:
            raise InputError(self.path, "is no UTF-8 text.", "save it as UTF-8", code="E-FILE-ENCODING") from None
        except OSError as error:
            raise InputError(self.path, f"cannot be read ({explain(error)}).", code="E-XML-BROKEN") from None
        if "<!DOCTYPE" in text:  # entities: files of this machine, or more text than its memory holds
            what = "declares a DOCTYPE, which a URDF does not need."
            raise InputError(self.path, what, "remove it", code="E-XML-DOCTYPE")
        try:
            robot = ET.fromstring(text)
        except (ET.ParseError, ValueError) as error:
            raise InputError(self.path, f"is not XML: {error}.", code="E-XML-BROKEN") from None
        if robot.tag != "robot":
            what = f"has <{robot.tag[:40]}> at the top."
            raise InputError(self.path, what, "a URDF starts with <robot>", code="E-URDF-ELEMENT")
        tags = [element.tag for element in robot.iter()]
        if macros := sorted({tag.replace("_", ":", 1) for tag in tags if tag.startswith("xacro_")}):
            mend = "xacro FILE > model.urdf, and give that"
            raise InputError(self.path, f"has {', '.join(macros)[:200]}: it is xacro.", mend, code="E-URDF-XACRO")
        if unread := Counter(tag for above in robot.iter() for tag in _unread(above)):
            names = ", ".join(f"<{tag[:40]}>{f' ({count})' if count > 1 else ''}" for tag, count in unread.items())
            self.remarks.append(f"not read: {names[:300]}")
        return robot

    def _index_named(self, tag: str) -> dict[str, ET.Element]:
        elements = self.robot.findall(tag)
        names = [element.get("name", "") for element in elements]
        for name, count in Counter(names).items():
            if not name.strip():
                raise InputError(self.path, f"a <{tag}> has no name.", code="E-URDF-ELEMENT")
            if count > 1:
                what = f"has {count} {tag}s called '{name}'."
                raise InputError(self.path, what, "a name of its own for each", code="E-URDF-ELEMENT")
        return dict(zip(names, elements, strict=True))

    @cached_property
    def colors(self) -> dict[str, ET.Element]:
        """<color> elements of the named materials."""
        found = ((m.get("name", ""), m.find("color")) for m in self.robot.iter("material"))
        return {name: color for name, color in found if color is not None}

    def numbers(
        self, element: ET.Element | None, key: str, default: str, count: int, where: str, low: float = -MAX_NUMBER
    ) -> Matrix:
        """The `count` numbers of an attribute, each from `low` to a million."""
        text = default if element is None else element.get(key, default)
        try:
            values = np.array([float(word) for word in text.replace(",", " ").split()])
        except ValueError:
            values = np.array([])
        if len(values) > count > 1:
            self.remarks.append(f'{where}: {key}="{text[:60]}" is more than {count} numbers: the first {count} count')
            values = values[:count]
        if len(values) != count or not np.isfinite(values).all():
            raise InputError(self.path, f'{where}: {key}="{text[:60]}" is not {count} number(s).', code="E-URDF-NUMBER")
        if (values < low).any() or (values > MAX_NUMBER).any():
            what = f'{where}: {key}="{text[:60]}" is not within {low:g} and {MAX_NUMBER:g}.'
            raise InputError(self.path, what, code="E-URDF-NUMBER")
        return values

    def positive(self, element: ET.Element | None, key: str, count: int, where: str) -> Matrix:
        """`numbers` above zero, which must be given."""
        values = self.numbers(element, key, "", count, where)
        if (values <= 0).any():
            what = f'{where}: {key}="{" ".join(f"{v:g}" for v in values)}" must be positive.'
            raise InputError(self.path, what, code="E-URDF-NUMBER")
        return values

    def origin(self, element: ET.Element, where: str) -> Matrix:
        """(4, 4) of an element's <origin xyz rpy>."""
        found = element.find("origin")
        xyz = self.numbers(found, "xyz", "0 0 0", 3, where)
        rpy = self.numbers(found, "rpy", "0 0 0", 3, where)
        return make_transform(Rotation.from_euler("xyz", rpy).as_matrix(), xyz)

    def _joint(self, element: ET.Element, name: str) -> JointModel:
        where, kind = f"joint '{name}'", element.get("type", "")
        parent, child = (self._end(element, tag, where) for tag in ("parent", "child"))
        if parent == child:
            raise InputError(self.path, f"{where}: link '{child}' is its own parent.", code="E-URDF-TREE")
        fixed = JointModel(name, "fixed", parent, child, self.origin(element, where))
        if kind in ("fixed", *LOOSE) or element.find("mimic") is not None:
            return fixed
        try:
            return self._make_moving(fixed, kind, element, where)
        except InputError as error:
            self.remarks.append(f"{error.what} It is fixed.")
            return fixed

    def _couple_joint(self, joint: JointModel, element: ET.Element, alone: Mapping[str, JointModel]) -> JointModel:
        """The joint as its <mimic> moves it: like its leader, from its own zero, if it moves as far as that."""
        mimic, kind = element.find("mimic"), element.get("type", "")
        if mimic is None or kind in ("fixed", *LOOSE):
            return joint
        where, leader = f"joint '{joint.name}'", alone.get(mimic.get("joint", ""))
        ratio, offset = (
            float(self.numbers(mimic, key, usual, 1, where)[0]) for key, usual in (("multiplier", "1"), ("offset", "0"))
        )
        alike = leader is not None and (leader.type, leader.parent) == (kind, joint.parent)
        if leader is None or not alike or abs(abs(ratio) - 1) > RIGID_TOLERANCE:
            how = f"follows {ratio:g} times '{mimic.get('joint', '')}': only a pair on one body that moves alike can"
            self.remarks.append(f"fixed: '{joint.name}', which {how}")
            return joint
        axis = self._axis(element, where) * np.sign(ratio)
        moved = replace(joint, type=leader.type, axis=axis, lower=leader.lower, upper=leader.upper, follows=leader.name)
        return replace(moved, origin=joint.origin @ moved.motion(offset * np.sign(ratio)))

    def _axis(self, element: ET.Element, where: str) -> Matrix:
        axis = self.numbers(element.find("axis"), "xyz", "1 0 0", 3, where)
        if np.linalg.norm(axis) < 1e-6:
            raise InputError(self.path, f"{where}: its axis is zero.", code="E-URDF-JOINT")
        return axis / np.linalg.norm(axis)

    def _make_moving(self, fixed: JointModel, kind: str, element: ET.Element, where: str) -> JointModel:
        if kind not in ("revolute", "prismatic"):
            raise InputError(self.path, f"{where}: type '{kind}' is not supported.", code="E-URDF-JOINT")
        axis = self._axis(element, where)
        limit = element.find("limit")
        if limit is None:
            raise InputError(self.path, f"{where}: a {kind} joint without <limit>.", code="E-URDF-JOINT")
        lower, upper = (float(self.numbers(limit, key, "0", 1, where)[0]) for key in ("lower", "upper"))
        if lower > upper:
            self.remarks.append(f"{where}: limits upside down ({lower:g}, {upper:g}), taken the other way round")
            lower, upper = upper, lower
        widest = max(abs(lower), abs(upper))
        if kind == "revolute" and widest > WIDEST_ANGLE:
            if widest > 360:
                what = f"{where}: limits {lower:g} and {upper:g} are more than two full turns."
                raise InputError(self.path, what, code="E-URDF-JOINT")
            self.remarks.append(f"{where}: limits {lower:g} and {upper:g}, taken for degrees")
            lower, upper = np.deg2rad([lower, upper]).tolist()
        if upper - lower < THIN:
            raise InputError(self.path, f"{where}: has no range ({lower:g} to {upper:g}).", code="E-URDF-JOINT")
        type_: JointType = "revolute" if kind == "revolute" else "prismatic"
        moving = replace(fixed, type=type_, lower=lower, upper=upper, axis=axis)
        sprung = self.numbers(element.find("dynamics"), "stiffness", "0", 1, where)[0] > 0  # as our writer says it
        return replace(moving, part_type="button") if sprung and kind == "prismatic" else moving

    def _end(self, element: ET.Element, tag: str, where: str) -> str:
        """The parent or child link of a joint."""
        found = element.find(tag)
        link = "" if found is None else found.get("link", "")
        if link not in self.links:
            raise InputError(self.path, f"{where}: <{tag}> names no link of this file ('{link}').", code="E-URDF-TREE")
        return link

    def _order_joints(self, joints: list[JointModel]) -> tuple[str, list[JointModel]]:
        """The root, and the joints in their order in the file, put off until their parent has been placed."""
        moved_by = Counter(joint.child for joint in joints)
        for name, count in moved_by.items():
            if count > 1:
                what = f"link '{name}' is the child of {count} joints: the links do not form one tree."
                raise InputError(self.path, what, "one parent joint for each link but the root", code="E-URDF-TREE")
        roots = [name for name in self.links if name not in moved_by]
        if len(roots) != 1:
            what = f"the links do not form one tree: {len(roots)} have no parent ({', '.join(roots[:3]) or 'a cycle'})."
            raise InputError(self.path, what, ONE_TREE, code="E-URDF-TREE")
        placed, ordered, waiting = {roots[0]}, list[JointModel](), joints
        while waiting:
            later = []
            for joint in waiting:
                if joint.parent in placed:
                    ordered.append(joint)
                    placed.add(joint.child)
                else:
                    later.append(joint)
            if len(later) == len(waiting):
                what = f"joint '{waiting[0].name}' is part of a cycle: the links do not form one tree."
                raise InputError(self.path, what, ONE_TREE, code="E-URDF-TREE")
            waiting = later
        return roots[0], ordered
