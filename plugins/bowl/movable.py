"""The task of Pick and Place: the object that they move, and its goal."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import trimesh

from roomkin.plugins.bowl.region import Region
from roomkin.stages.simulation.kinematics import Array


@dataclass(frozen=True)
class Movable:
    """An object as it stands now; poses (4, 4) in the robot base frame.

    mesh: in its own frame, upright. region: what it is put into, in the frame that `base_from_region` says, which moves
    with a drawer. there: whether the object is where it belongs, in the gripper or not.
    """

    mesh: trimesh.Trimesh
    base_from_object: Array
    region: Region
    base_from_region: Array
    there: bool


@runtime_checkable
class CarryEnv(Protocol):
    """An environment with something to carry."""

    def movable(self) -> Movable:
        """The object that Pick and Place move, in the first environment."""
