"""An asset in its place, as it passes from step to step."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stages.contracts import Asset
from stages.contracts.objects import Mounting
from stages.geometry.boxes import UprightBox

FLOOR, WALL, UNNAMED = "floor", "wall", "unnamed"


@dataclass(frozen=True)
class Placed:
    """An asset whose closed box is `box` (floor frame). `support`: 'floor', 'wall', the id of the object
    beneath, or 'unnamed': it is seen to stand on something that is no object of the scene; as extraction saw it
    until it is stacked. `cousin`: its rank in cousins.json; `chosen`: by a person; `steps`: what each step changed so
    far; `doubts`: what should not be taken for certain."""

    id: str
    label: str
    asset: Asset
    box: UprightBox
    mounting: Mounting
    support: str = FLOOR
    moved: float = 0.0
    cousin: int | None = None
    chosen: bool = False
    steps: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def center(self) -> NDArray[np.float64]:
        """Box centre (3,)."""
        return np.asarray(self.box.center, dtype=float)

    @property
    def size(self) -> NDArray[np.float64]:
        """Extents (3,) along the asset's own axes."""
        return np.asarray(self.box.size, dtype=float)

    @property
    def bottom(self) -> float:
        """Height of the lower face."""
        return float(self.center[2] - self.size[2] / 2)

    @property
    def top(self) -> float:
        """Height of the upper face."""
        return float(self.center[2] + self.size[2] / 2)

    @property
    def wall_mounted(self) -> bool:
        """Whether it hangs on a wall (A.2, type 1)."""
        return self.mounting.type == 1

    @property
    def held(self) -> bool:
        """Whether it cannot fall: what hangs on a wall, or stands on what nobody named."""
        return self.wall_mounted or self.support == UNNAMED

    def shifted(self, offset: ArrayLike) -> "Placed":
        """Moved by `offset` (3,)."""
        return replace(self, box=self.box._replace(center=self.center + np.asarray(offset, dtype=float)))
