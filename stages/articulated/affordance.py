"""Which joint of an asset a task opens: doors and drawers with a handle that a gripper can hold (paper A.4)."""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.contracts import Asset, InputError, read_json
from stages.contracts.library import Joint
from stages.geometry.frames import apply, rigid

Task = Literal["door", "drawer"]
LARGE = 0.5  # a panel with at least this share of the largest panel's area is as good a target
UPRIGHT = 0.9  # |z| of a hinge: a flap that falls open is another motion than a door
Array = NDArray[np.float64]


class Panel(NamedTuple):
    """A joint that a task could open: front area (m^2), height of its centre (m), axis in the asset frame."""

    joint: str
    area: float
    height: float
    axis: Array


def target_joint(folder: Path, task: Task, like: Panel | None = None) -> Panel | None:
    """The joint of the asset in `folder` that the task opens; None if no joint will do.

    A door has an upright hinge, a drawer slides, and either has a handle link. Among those with a large
    panel (half of the largest or more) the choice is one that turns the same way as the twin's (`like`),
    then the largest, then the one nearest to mid-height, then the first by name.
    """
    asset = read_json(Asset, folder / "asset.json", "make the library again")
    wanted = ("revolute", "door") if task == "door" else ("prismatic", "drawer")
    joints = [joint for joint in asset.joints if (joint.type, joint.role) == wanted and joint.handle_link is not None]
    if not joints:
        return None
    frames = Urdf(folder / asset.urdf)
    panels = [_panel(joint, frames) for joint in joints]
    panels = [panel for panel in panels if task == "drawer" or abs(panel.axis[2]) >= UPRIGHT]
    if not panels:
        return None
    middle = (asset.box_min[2] + asset.box_max[2]) / 2
    largest = max(panel.area for panel in panels)

    def order(panel: Panel) -> tuple[bool, float, float, str]:
        other_way = like is not None and float(panel.axis @ like.axis) < 0
        # rounded, so that panels of equal size tie whatever their handles add
        return other_way, -round(panel.area / largest, 1), round(abs(panel.height - middle), 3), panel.joint

    return min((panel for panel in panels if panel.area >= LARGE * largest), key=order)


def _panel(joint: Joint, frames: "Urdf") -> Panel:
    low, high = frames.link_bounds(joint.link)
    size = high - low
    axis = frames.root_from(joint.link)[:3, :3] @ np.array(joint.axis)
    return Panel(joint.name, float(size[1] * size[2]), float((low + high)[2] / 2), axis)


class Urdf:
    """Where the links of a closed asset are, from its URDF."""

    def __init__(self, path: Path) -> None:
        try:
            robot = ET.parse(path).getroot()
        except (OSError, ET.ParseError) as error:
            raise InputError(path, f"is no readable URDF ({error.__class__.__name__}).") from None
        self.path = path
        self._links = {link.get("name", ""): link for link in robot.iter("link")}
        self._joints = {child.get("link", ""): joint for joint in robot.iter("joint") for child in joint.iter("child")}

    def root_from(self, link: str) -> Array:
        """4x4 pose of a link in the asset frame, joints at 0."""
        joint = self._joints.get(link)
        if joint is None:
            return np.eye(4)
        parent = joint.find("parent")
        above = self.root_from(parent.get("link", "")) if parent is not None else np.eye(4)
        return above @ _origin(joint)

    def link_bounds(self, link: str) -> tuple[Array, Array]:
        """Bounds of a link's visual meshes and boxes in the asset frame."""
        corners = []
        for visual in self._links[link].iter("visual") if link in self._links else ():
            pose = self.root_from(link) @ _origin(visual)
            mesh, box = visual.find("geometry/mesh"), visual.find("geometry/box")
            if mesh is not None:
                shape = trimesh.load(self.path.parent / mesh.get("filename", ""), force="mesh")
                scale = np.array(mesh.get("scale", "1 1 1").split(), dtype=float)
                corners.append(apply(pose, trimesh.bounds.corners(shape.bounds * scale)))
            elif box is not None:
                half = np.array(box.get("size", "0 0 0").split(), dtype=float) / 2
                corners.append(apply(pose, trimesh.bounds.corners([-half, half])))
        if not corners:
            raise InputError(self.path, f"has no link '{link}' with a visual mesh or box.")
        points = np.concatenate(corners)
        return points.min(axis=0), points.max(axis=0)


def _origin(element: ET.Element) -> Array:
    """4x4 of an element's <origin xyz rpy>."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    xyz = np.array(origin.get("xyz", "0 0 0").split(), dtype=float)
    roll_pitch_yaw = np.array(origin.get("rpy", "0 0 0").split(), dtype=float)
    return rigid(Rotation.from_euler("xyz", roll_pitch_yaw).as_matrix(), xyz)
