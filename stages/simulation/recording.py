"""Episodes as poses and joint values: recording them costs nothing, and only what is shown is rendered."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.room import Room


@dataclass(frozen=True)
class Moment:
    """The state at one moment: (4, 4) poses of the roots in the world, joint values by name."""

    robot: Array
    robot_joints: Mapping[str, float]
    asset: Array
    asset_joints: Mapping[str, float]
    props: Sequence[Array] = ()


@dataclass(frozen=True)
class Prop:
    """A rigid thing of a task besides robot and asset: its asset folder and scale (3,)."""

    folder: Path
    scale: Array


@dataclass(frozen=True)
class Recording:
    """An episode on the asset in `folder`, stretched by `scale` (3,); `side` is +1 or -1 along y, away from a door's
    hinge, 0 for a drawer; `room`: the generated scene that it happened in, whose floor frame is then the world."""

    folder: Path
    scale: Array
    side: float
    moments: Sequence[Moment]
    room: Room | None = None
    props: Sequence[Prop] = ()
