"""An articulation in memory, as a URDF describes it: one tree of links with meshes; its frames and its closed box.

Metres, radians, kilograms; every link's meshes lie in its own frame, as in a URDF.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Trimesh

from roomkin.stages.contracts.library import HandleKind
from roomkin.stages.contracts.parts import PartType
from roomkin.stages.geometry.frames import make_transform, transform_points

Matrix = NDArray[np.float64]
RGBA = tuple[float, float, float, float]  # linear, 0 to 1
JointType = Literal["fixed", "revolute", "prismatic"]


class Texture(NamedTuple):
    """A tileable picture (JPEG), identified by its name, and the metres that it covers along a part and across."""

    name: str
    image: bytes
    repeat: tuple[float, float]


@dataclass(frozen=True)
class Visual:
    """A mesh to see. `color` None: the mesh carries its own looks. `flat`: every edge looks sharp, else only those
    that are. `texture`: drawn on it instead of the color, along its longest extent, from `start` (shares) on."""

    mesh: Trimesh
    color: RGBA | None = None
    flat: bool = False
    texture: Texture | None = None
    start: tuple[float, float] = (0.0, 0.0)

    def transform(self, transform: Matrix) -> "Visual":
        """A transformed copy."""
        return replace(self, mesh=transform_mesh(self.mesh, transform))

    def paint(self) -> Trimesh:
        """The mesh with its color as a material."""
        if self.color is None:
            return self.mesh
        mesh = self.mesh.copy()
        material = trimesh.visual.material.PBRMaterial(
            baseColorFactor=np.array(self.color), metallicFactor=0.0, roughnessFactor=0.8
        )
        mesh.visual = trimesh.visual.TextureVisuals(material=material)
        return mesh


@dataclass(frozen=True)
class Link:
    """A body: what is seen of it, convex pieces that collide, mass, center of mass, inertia (3, 3) about that."""

    name: str
    visuals: list[Visual]
    collisions: list[Trimesh]
    mass: float
    center: Matrix
    inertia: Matrix
    weighed: bool = False  # the mass is stated, not estimated from the volume

    def map_linearly(self, transform: Matrix) -> "Link":
        """The link under a linear map of its frame, (4, 4); mass and inertia stay."""
        return replace(
            self,
            visuals=[visual.transform(transform) for visual in self.visuals],
            collisions=[transform_mesh(mesh, transform) for mesh in self.collisions],
            center=transform_points(transform, self.center),
        )


@dataclass(frozen=True)
class JointModel:
    """A joint. `origin` is parent_from_child, 4x4, at position 0; `axis` a unit vector in the child frame.

    An asset is closed with every joint at `lower`. A moving joint may have a part type, and its part a handle:
    `handle_link` carries it, `handle` is its kind, where they are known. `follows`: a joint of the same parent and type
    that it always stands alike, as the second leaf of a pair of doors does.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Matrix
    axis: Matrix = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    lower: float = 0.0
    upper: float = 0.0
    part_type: PartType | None = None
    handle_link: str | None = None
    handle: HandleKind | None = None
    follows: str | None = None

    def motion(self, value: float) -> Matrix:
        """Transform of the child in the joint frame at a joint position."""
        if self.type == "revolute":
            return np.asarray(trimesh.transformations.rotation_matrix(value, self.axis))
        if self.type == "prismatic":
            return make_transform(np.eye(3), value * self.axis)
        return np.eye(4)


@dataclass(frozen=True)
class RobotModel:
    """Links and joints that form one tree; joints in an order in which parents come before children.

    `touching`: pairs of links that touch when everything is closed and must not collide, as in an SRDF. `remarks`: what
    a reader left out of its file or assumed, in lines.
    """

    name: str
    links: dict[str, Link]
    joints: list[JointModel] = field(default_factory=list)
    touching: tuple[tuple[str, str], ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def root(self) -> str:
        """Name of the root link."""
        children = {joint.child for joint in self.joints}
        return next(name for name in self.links if name not in children)

    @property
    def mass(self) -> float:
        """Of all links, kg."""
        return sum(link.mass for link in self.links.values())


def transform_mesh(mesh: Trimesh, transform: Matrix) -> Trimesh:
    """A transformed copy, with its looks."""
    copy = mesh.copy()
    copy.apply_transform(transform)
    return copy


def link_frames(robot: RobotModel, opened: float = 0.0) -> dict[str, Matrix]:
    """root_from_link, 4x4, of every link, every joint at `opened` of its range (0: closed)."""
    return frames_of(robot.root, robot.joints, opened)


def frames_of(root: str, joints: list[JointModel], opened: float = 0.0) -> dict[str, Matrix]:
    """`link_frames` from the joints alone, parents before children."""
    frames = {root: np.eye(4)}
    for joint in joints:
        value = joint.lower + opened * (joint.upper - joint.lower)
        frames[joint.child] = frames[joint.parent] @ joint.origin @ joint.motion(value)
    return frames


def list_collisions(robot: RobotModel) -> list[Trimesh]:
    """The convex pieces that collide, in the root frame, every joint closed."""
    frames, links = link_frames(robot), robot.links.values()
    return [transform_mesh(piece, frames[link.name]) for link in links for piece in link.collisions]


def visual_bounds(visuals: list[Visual], frame: Matrix) -> Matrix | None:
    """Lowest and highest corner (2, 3) of what is seen of a link that stands at `frame`; None if that is nothing."""
    if not visuals:
        return None
    corners = np.concatenate([transform_points(frame, visual.mesh.vertices) for visual in visuals])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def measure_closed_box(robot: RobotModel) -> Matrix:
    """Lowest and highest corner (2, 3), in the root frame, of all that is visible, every joint closed."""
    frames = link_frames(robot)
    boxes = (visual_bounds(link.visuals, frames[link.name]) for link in robot.links.values())
    corners = np.concatenate([box for box in boxes if box is not None])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def change_root(robot: RobotModel, new_from_root: Matrix) -> RobotModel:
    """The same thing seen from another root frame (a rigid transform)."""
    root, rotation = robot.links[robot.root], new_from_root[:3, :3]
    turned = replace(root.map_linearly(new_from_root), inertia=rotation @ root.inertia @ rotation.T)
    joints = [replace(j, origin=new_from_root @ j.origin) if j.parent == root.name else j for j in robot.joints]
    return replace(robot, links=robot.links | {root.name: turned}, joints=joints)
