"""A room's description: items, where they stand, and which models may play them. One YAML file per room.

Room frame: the back wall is the plane x = 0 and x grows towards the viewer; y grows to the viewer's
right; z is up. `along`, `x` and `y` are in metres before the room is stretched to its scale.
"""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from roomkin.stages.contracts.generated import Color
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.section import Positive, check_range

WallName = Literal["back", "left", "right"]
Range = Annotated[tuple[float, float], AfterValidator(check_range)]
Counts = Annotated[tuple[int, int], AfterValidator(check_range)]
ANY: Range = (0.0, 99.0)


class RecipePart(BaseModel):
    """A part of a recipe; unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Against(RecipePart):
    """On the floor, its back to a wall, at y (back wall) or x (side walls) = `along`."""

    against: WallName
    along: float
    gap: float = 0.015


class Beside(RecipePart):
    """Against the same wall as another item, to its right or left as one faces that wall."""

    beside: str
    side: Literal["right", "left"]
    gap: float = 0.02


class Floor(RecipePart):
    """Free on the floor at (x, y); yaw 0 looks at the viewer, degrees, counter-clockwise from above."""

    floor: tuple[float, float]
    yaw: float = 0.0


class On(RecipePart):
    """On top of another item. `forward` and `right` run from -1 to 1 over the free top; yaw relative to it, degrees."""

    on_top: str
    forward: Annotated[float, Field(ge=-1, le=1)] = 0.0
    right: Annotated[float, Field(ge=-1, le=1)] = 0.0
    yaw: float = 0.0


class Hung(RecipePart):
    """Fixed to a wall, the center of its box at height `z`."""

    hung: WallName
    along: float
    z: Positive


PLACES = ("against", "beside", "floor", "on_top", "hung")


def _place_key(value: Any) -> str | None:
    """The key that says what kind of place it is."""
    keys = value if isinstance(value, dict) else dir(value)
    return next((key for key in PLACES if key in keys), None)


Place = Annotated[
    Annotated[Against, Tag("against")]
    | Annotated[Beside, Tag("beside")]
    | Annotated[Floor, Tag("floor")]
    | Annotated[On, Tag("on_top")]
    | Annotated[Hung, Tag("hung")],
    Discriminator(_place_key, custom_error_type="place", custom_error_message=f"needs one of {', '.join(PLACES)}"),
]


class ModelConstraints(RecipePart):
    """Conditions on a model that plays an item: counts, and extents of its closed box in metres."""

    doors: Counts = (0, 99)
    drawers: Counts = (0, 99)
    depth: Range = ANY
    width: Range = ANY
    height: Range = ANY
    handles: tuple[str, ...] = Field((), description="every door and drawer has one of these; (): any")
    door_width: Range = Field(ANY, description="width / doors")

    def text(self) -> str:
        """The constraints that are set, for messages."""
        wishes = [f"{name} {getattr(self, name)}" for name in type(self).model_fields if name in self.model_fields_set]
        return ", ".join(wishes) or "any size"

    def accepts(self, asset: Asset) -> bool:
        """Whether the model will do."""
        numbers = [
            (asset.doors, self.doors),
            (asset.drawers, self.drawers),
            *zip(asset.size, (self.depth, self.width, self.height), strict=True),
            (asset.size[1] / max(1, asset.doors), self.door_width),
        ]
        handles_fit = not self.handles or all(joint.handle in self.handles for joint in asset.joints)
        return handles_fit and all(low <= value <= high for value, (low, high) in numbers)


class Item(RecipePart):
    """One object: its name in the recipe, the library's category, what a person would call it, and where it is."""

    name: str
    category: str
    label: str
    place: Place
    model: ModelConstraints = ModelConstraints()


class CameraStand(RecipePart):
    """The photographer's place: degrees to the right of straight ahead, eye height, vertical field of view."""

    azimuth: Annotated[float, Field(gt=-90, lt=90)] = 0.0
    height: Positive = 1.6
    fov: Annotated[float, Field(gt=10, lt=120)] = 50.0


class RoomPlan(RecipePart):
    """A room of Table 2, or one of a user's."""

    name: str = Field(description="that of the file")
    scale: Positive = Field(description="largest distance between two box centers, metres")
    items: Annotated[tuple[Item, ...], Field(min_length=2)]
    walls: tuple[WallName, ...] = ("back",)
    half_width: Positive = Field(1.8, description="of the floor, before it is stretched")
    camera: CameraStand = CameraStand()
    wall_colour: Color = (0.86, 0.84, 0.79)
    floor_colour: Color = (0.62, 0.45, 0.30)

    @model_validator(mode="after")
    def _check_items(self) -> "RoomPlan":
        before: dict[str, Item] = {}
        for item in self.items:
            place = item.place
            if item.name in before:
                raise ValueError(f"two items are called '{item.name}'")
            wall = getattr(place, "against", None) or getattr(place, "hung", None)
            if wall and wall not in self.walls:
                raise ValueError(f"'{item.name}' is at the {wall} wall, which is not one of walls")
            other = getattr(place, "beside", None) or getattr(place, "on_top", None)
            if other and other not in before:
                raise ValueError(f"'{item.name}' refers to '{other}', which is no item before it")
            if isinstance(place, Beside) and not isinstance(before[place.beside].place, Against | Beside):
                raise ValueError(f"'{item.name}' is beside '{place.beside}', which does not stand at a wall")
            before[item.name] = item
        return self
