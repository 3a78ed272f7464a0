"""What tests of physics need: a floor, and where a body is."""

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation, PhysxMaterial

from roomkin.stages.articulated.urdf_writer import SURFACE_FRICTION


def add_ground(scene: sapien.Scene, height: float = 0.0) -> sapien.Entity:
    """A static floor without looks, 20 x 20 m, its surface at z = `height`."""
    builder = scene.create_actor_builder()
    material = PhysxMaterial(SURFACE_FRICTION, SURFACE_FRICTION, 0.0)
    builder.add_box_collision(sapien.Pose([0, 0, height - 0.5]), [10, 10, 0.5], material=material)
    return builder.build_static("ground")


def position_of(body: PhysxArticulation | sapien.Entity) -> NDArray[np.float64]:
    """Translation of the URDF root in the world."""
    pose = body.get_root_pose() if isinstance(body, PhysxArticulation) else body.get_pose()
    return np.asarray(pose.p, dtype=float)
