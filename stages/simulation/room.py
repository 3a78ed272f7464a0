"""What a task may stand in, in the way of the robot and behind its work (the package `in_scene`: generated scenes)."""

from collections.abc import Mapping
from typing import Protocol, TypeAlias

import sapien
from sapien.physx import PhysxArticulation

from roomkin.stages.simulation.kinematics import Array

Body: TypeAlias = PhysxArticulation | sapien.Entity


class Room(Protocol):
    """Furniture, floor and walls about the object of a task; its own frame is then the world, z up, metres."""

    @property
    def world_from_nominal(self) -> Array:
        """(4, 4) pose of the frame in which the object's box stands above the origin, on z = 0, and faces +x."""
        ...

    def stand(self, base: Array) -> Array:
        """Where the robot stands, (4, 4), of its pose (4, 4) in the object's nominal frame."""
        ...

    def load(self, scene: sapien.Scene) -> Mapping[str, Body]:
        """Add all but the object, which stays where it is; by name."""
        ...

    @property
    def obstacles(self) -> Mapping[str, Array]:
        """(N, 3) points on the surfaces about, by name, as far as the robot may reach."""
        ...
