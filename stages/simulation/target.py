"""The geometry that a task needs of its asset: the target joint, its handle, its moving and its fixed meshes."""

from dataclasses import dataclass

import numpy as np
import trimesh
from mani_skill.utils.geometry.trimesh_utils import get_component_meshes, merge_meshes
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.handle import Handle, find_handle
from roomkin.stages.geometry.frames import invert_transform

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Target:
    """The joint to open, in the asset frame with all joints closed.

    axis: (3,) unit axis of rotation (revolute) or motion (prismatic); positive values open the joint.
    origin: (3,) point on the axis. moving, fixed: collision meshes of the moving links and of all others.
    """

    index: int  # among the articulation's active joints
    revolute: bool
    axis: Array
    origin: Array
    lower: float
    upper: float
    moving: trimesh.Trimesh
    fixed: trimesh.Trimesh
    handle: Handle | None

    @property
    def reference(self) -> Array:
        """(3,) the handle, or the middle of the front if there is none: the robot is placed relative to it."""
        if self.handle is not None:
            return self.handle.position
        low, high = self.moving.bounds
        return np.array([high[0], (low[1] + high[1]) / 2, (low[2] + high[2]) / 2])

    @property
    def side(self) -> float:
        """+1 or -1: the y direction from the hinge to the handle; 0 for a drawer and for a flap."""
        across = self.reference[1] - self.origin[1]
        return float(np.sign(across)) if self.revolute and not self.flap else 0.0

    @property
    def flap(self) -> bool:
        """Whether it turns about a horizontal hinge."""
        return self.revolute and abs(self.axis[2]) <= 0.5

    def motions(self, values: Array) -> Array:
        """(K, 4, 4) motions of the moving link when the joint goes from closed to `values` (K,), asset frame."""
        travel = (np.asarray(values) - self.lower)[:, None] * self.axis
        moved = np.tile(np.eye(4), (len(travel), 1, 1))
        if self.revolute:
            moved[:, :3, :3] = Rotation.from_rotvec(travel).as_matrix()
            moved[:, :3, 3] = self.origin - moved[:, :3, :3] @ self.origin
        else:
            moved[:, :3, 3] = travel
        return moved


def read_target(raw: PhysxArticulation, index: int) -> Target:
    """Measure the target joint of a loaded asset, the active joint of that index; its joints must be closed."""
    root_inverse = invert_transform(raw.root.pose.to_transformation_matrix())
    joint = raw.active_joints[index]
    joint_frame = root_inverse @ joint.get_global_pose().to_transformation_matrix()
    moving: list[trimesh.Trimesh] = []
    fixed: list[trimesh.Trimesh] = []
    for link in raw.links:
        root_from_link = root_inverse @ link.pose.to_transformation_matrix()
        group = moving if descends(link, joint.child_link) else fixed
        group += [mesh.apply_transform(root_from_link) for mesh in get_component_meshes(link)]
    lower, upper = joint.limits[0].tolist()
    mesh = merge_meshes(moving)
    still = merge_meshes(fixed) if fixed else trimesh.Trimesh()
    return Target(
        index=index, revolute=joint.type.startswith("revolute"), axis=joint_frame[:3, 0], origin=joint_frame[:3, 3],
        lower=float(lower), upper=float(upper), moving=mesh, fixed=still, handle=find_handle(mesh),
    )  # fmt: skip


def descends(link: object, ancestor: object) -> bool:
    """Whether `ancestor` is `link` or above it in the tree."""
    while link is not None:
        if link == ancestor:
            return True
        link = link.parent  # type: ignore[attr-defined]
    return False
