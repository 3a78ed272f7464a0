"""A model in its place, as it passes from step to step."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.stages.articulated.model import RobotModel
from roomkin.stages.contracts import Asset
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.library import Finish
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import make_transform, wrap_angle, yaw_matrix

FLOOR, WALL, UNNAMED = "floor", "wall", "unnamed"


class Prism(NamedTuple):
    """A convex outline (n, 2) in the x-y plane, from height `low` to `high`; `vertices`: of what it is around, (m, 3).

    Exact for boxes and panels, a little generous for slanted legs.
    """

    outline: NDArray[np.float64]
    low: float
    high: float
    vertices: NDArray[np.float64]


@dataclass(frozen=True)
class Placed:
    """A model whose closed box is `box` (floor frame).

    folder: of the model. robot: the model at its size, unless that is the folder's. prisms: of its collision shapes, in
    the asset frame. support: 'floor', 'wall', the id of the object beneath, or 'unnamed': it stands on something that
    is no object of the scene; as extraction saw it until it is stacked. spread: standard deviations of the logarithms
    of fitted extents. place_spread: metres, of its fitted center. cousin: its rank in cousins.json. chosen: by
    a person. steps: what each step changed so far. doubts: what may be wrong. finish: parameters of the asset's recipe
    that are other than the library's.
    """

    id: str
    label: str
    asset: Asset
    folder: Path
    box: UprightBox
    mounting: Mounting
    support: str = FLOOR
    robot: RobotModel | None = None
    prisms: tuple[Prism, ...] = ()
    spread: tuple[float, float, float] | None = None
    place_spread: float | None = None
    moved: float = 0.0
    cousin: int | None = None
    chosen: bool = False
    steps: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    finish: Finish = field(default_factory=dict)

    @property
    def center(self) -> NDArray[np.float64]:
        """Box center (3,)."""
        return self.box.center

    @property
    def size(self) -> NDArray[np.float64]:
        """Extents (3,) along the asset's own axes."""
        return self.box.size

    @property
    def bottom(self) -> float:
        """Height of the lower face."""
        return self.box.bottom

    @property
    def top(self) -> float:
        """Height of the upper face."""
        return self.box.top

    @property
    def wall_mounted(self) -> bool:
        """Whether it hangs on a wall (A.2, type 1)."""
        return self.mounting.hangs

    @property
    def held(self) -> bool:
        """Whether it cannot fall: what hangs on a wall, or stands on what nobody named."""
        return self.wall_mounted or self.support == UNNAMED

    @property
    def middle(self) -> NDArray[np.float64]:
        """Box center (3,) in the asset frame."""
        return (np.asarray(self.asset.box_min) + np.asarray(self.asset.box_max)) / 2

    @property
    def stretch(self) -> float:
        """How far the model is stretched, 1 or more: as a whole, or one axis against another, whatever is more.

        A sofa of 2 m is no stool: it would be squeezed to a fifth of its width.
        """
        scales = self.size / np.asarray(self.asset.size)
        middle = float(np.median(scales))
        return max(float(scales.max() / scales.min()), middle, 1 / middle)

    @property
    def pose(self) -> NDArray[np.float64]:
        """floor_from_asset (4, 4)."""
        turn = yaw_matrix(self.box.yaw)
        return make_transform(turn, self.center - turn @ self.middle)

    @property
    def collision_prisms(self) -> list[Prism]:
        """The prisms where it stands, in the floor frame."""
        middle, turn = self.middle, yaw_matrix(self.box.yaw)
        rise = self.center[2] - middle[2]
        return [
            Prism(
                (prism.outline - middle[:2]) @ turn[:2, :2].T + self.center[:2],
                prism.low + rise,
                prism.high + rise,
                (prism.vertices - middle) @ turn.T + self.center,
            )
            for prism in self.prisms
        ]

    def shift(self, offset: ArrayLike) -> "Placed":
        """The item moved by `offset` (3,), metres."""
        return replace(self, box=replace(self.box, center=self.center + np.asarray(offset, dtype=float)))

    def change_box(self, step: str, box: UprightBox) -> "Placed":
        """The item in another box. A change is noted in its `steps`, with the name of the step."""
        what = describe_difference(self.box, box)
        return replace(self, box=box, steps=(*self.steps, f"{step}: {what}") if what else self.steps)


def describe_difference(before: UprightBox, after: UprightBox) -> str:
    """How one box differs from another, e.g. `turned 12.0°, 0.41 x 0.90 x 0.80 m, moved 2.1 cm`; empty: not at all.

    What rounds to no tenth of a degree or millimetre is no difference.
    """
    turn = float(np.rad2deg(wrap_angle(after.yaw - before.yaw)))
    shift = after.center - before.center
    found = [f"turned {turn:+.1f}°"] if round(turn, 1) else []
    if (after.size - before.size).round(3).any():
        found.append(" x ".join(f"{extent:.3f}" for extent in after.size) + " m")
    if shift[:2].round(3).any():
        found.append(f"moved {100 * float(np.linalg.norm(shift[:2])):.1f} cm")
    if round(shift[2], 3):
        found.append(f"{'raised' if shift[2] > 0 else 'lowered'} {100 * abs(float(shift[2])):.1f} cm")
    return ", ".join(found)
