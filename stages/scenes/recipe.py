"""The words in which a room is described: items, where they stand, and which models may play them.

Room frame: the back wall is the plane x = 0 and x grows towards the viewer; y grows to the viewer's
right; z is up. `along`, `x` and `y` are in metres before the room is stretched to its scale.
"""

from dataclasses import dataclass, field, fields
from typing import Literal

from stages.contracts.library import Asset

WallName = Literal["back", "left", "right"]
Range = tuple[float, float]
ANY: Range = (0.0, 99.0)


@dataclass(frozen=True)
class Against:
    """On the floor, its back to a wall, at y (back wall) or x (side walls) = `along`."""

    wall: WallName
    along: float
    gap: float = 0.015


@dataclass(frozen=True)
class Beside:
    """Against the same wall as another item, to its right (+1) or left (-1) as one faces that wall."""

    item: str
    side: Literal[-1, 1]
    gap: float = 0.02


@dataclass(frozen=True)
class Floor:
    """Free on the floor; yaw 0 looks at the viewer, degrees, counter-clockwise from above."""

    x: float
    y: float
    yaw: float = 0.0


@dataclass(frozen=True)
class On:
    """On top of another item. `forward` and `right` run from -1 to 1 over the free top; yaw relative to it, degrees."""

    item: str
    forward: float = 0.0
    right: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Hung:
    """Fixed to a wall, the centre of its box at height `z`."""

    wall: WallName
    along: float
    z: float


Place = Against | Beside | Floor | On | Hung


@dataclass(frozen=True)
class Want:
    """What a model must be like to play an item: counts, and extents of its closed box in metres."""

    doors: tuple[int, int] = (0, 99)
    drawers: tuple[int, int] = (0, 99)
    depth: Range = ANY
    width: Range = ANY
    height: Range = ANY
    handles: tuple[str, ...] = ()  # every door and drawer has one of these; (): any
    door_width: Range = ANY  # width / doors

    def text(self) -> str:
        """The wishes that are set, for messages."""
        wishes = [f"{f.name} {getattr(self, f.name)}" for f in fields(self) if getattr(self, f.name) != f.default]
        return ", ".join(wishes) or "any size"

    def fits(self, asset: Asset) -> bool:
        """Whether the model will do."""
        numbers = [
            (asset.doors, self.doors),
            (asset.drawers, self.drawers),
            *zip(asset.size, (self.depth, self.width, self.height), strict=True),
            (asset.size[1] / max(1, asset.doors), self.door_width),
        ]
        handles_fit = not self.handles or all(joint.handle in self.handles for joint in asset.joints)
        return handles_fit and all(low <= value <= high for value, (low, high) in numbers)


@dataclass(frozen=True)
class Item:
    """One object: its name in the recipe, the library's category, what a person would call it, and where it is."""

    name: str
    category: str
    label: str
    place: Place
    want: Want = field(default_factory=Want)


@dataclass(frozen=True)
class Shot:
    """Where the photographer stands: degrees to the right of straight ahead, eye height, vertical field of view."""

    azimuth: float = 0.0
    height: float = 1.6
    fov: float = 50.0


@dataclass(frozen=True)
class Room:
    """A room of Table 2. `scale`: largest distance between two box centres; `half_width`: of the floor."""

    name: str
    scale: float
    items: tuple[Item, ...]
    walls: tuple[WallName, ...] = ("back",)
    half_width: float = 1.8
    shot: Shot = field(default_factory=Shot)
    wall_colour: tuple[float, float, float] = (0.86, 0.84, 0.79)
    floor_colour: tuple[float, float, float] = (0.62, 0.45, 0.30)
