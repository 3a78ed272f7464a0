"""Domain randomisation of a task's object: its friction and mass, drawn with the episode."""

from typing import NamedTuple

import numpy as np
from sapien.physx import PhysxArticulation, PhysxMaterial

from roomkin.stages.config.demonstrations import RandomiseOptions


class Factors(NamedTuple):
    """Factors on friction of the surfaces, mass of the links, and friction and damping of the joints."""

    friction: float
    mass: float
    joint_friction: float


def sample_factors(seed: int, options: RandomiseOptions) -> Factors:
    """The factors of episode `seed`, log-uniform in their ranges: half and double are equally likely."""
    rng = np.random.default_rng((seed, 4))
    ranges = (options.friction, options.mass, options.joint_friction)
    return Factors(*(float(np.exp(rng.uniform(*np.log(each)))) for each in ranges))


def randomise(body: PhysxArticulation, factors: Factors) -> None:
    """Change an articulation that was just built."""
    for link in body.links:
        link.mass, link.inertia = link.mass * factors.mass, link.inertia * factors.mass
        for shape in link.collision_shapes:
            was = shape.physical_material  # shared with other bodies
            friction = (was.static_friction * factors.friction, was.dynamic_friction * factors.friction)
            shape.physical_material = PhysxMaterial(*friction, was.restitution)
    for joint in body.active_joints:
        joint.set_friction(joint.friction * factors.joint_friction)
        joint.set_drive_properties(stiffness=joint.stiffness, damping=joint.damping * factors.joint_friction)
