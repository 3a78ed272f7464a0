"""Rooms as data: the config section `scenes`, what a room's YAML file says, and which files there are."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError, model_validator

from roomkin.stages.config.categories import CATEGORIES, Known
from roomkin.stages.contracts.errors import InputError, fault_of, first_error, line_of
from roomkin.stages.contracts.files import read_text
from roomkin.stages.contracts.generated import Color
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.objects import object_ids
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.contracts.section import Positive, Section, check_range
from roomkin.stages.plugins import data_file, list_available


class ScenesConfig(Section):
    """Photographs of the rooms."""

    width: int = Field(800, ge=64, description="Width of the photograph in pixels.")
    height: int = Field(600, ge=48, description="Height of the photograph in pixels.")
    supersampling: int = Field(2, ge=1, le=4, description="Colors are rendered so many times larger and averaged.")


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


Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # five times as fast where it is there


def series() -> list[Path]:
    """Files of the rooms of Table 2, in its order: no model stands in two of them."""
    return sorted(Path(__file__).with_name("rooms").glob("*.yaml"), key=lambda path: (len(path.stem), path.stem))


def room_files(own: Iterable[str] = (), packages: Sequence[str] = ()) -> dict[str, Path]:
    """Files of all rooms by their names: ours, those of the packages, and the files `own`.

    Raises:
        InputError: a file is not there, or a name is taken twice.
    """
    files = {path.stem: path for path in series()}
    files |= {name: data_file("rooms", module) for name, module in list_available("rooms", packages).items()}
    for path in map(Path, own):
        if not path.is_file():
            raise InputError("scenes.rooms", f"there is no file {path}.", "correct the path", code="E-ROOM-MISSING")
        if path.stem in files:
            fault = f"room '{path.stem}' is in {files[path.stem]} and in {path}."
            raise InputError("scenes.rooms", fault, "rename it", code="E-ROOM-NAME")
        files[path.stem] = path
    return files


def recipe_digest(path: Path | None) -> str:
    """Digest (12 hex digits) of what a room is made by: its own file and, of ours, those before it."""
    ours = series()
    used = ours[: ours.index(path) + 1] if path in ours else [path] if path else []
    return sha256(b"\0".join(file.read_bytes() for file in used)).hexdigest()[:12]


def read_room(path: Path) -> RoomPlan:
    """The room of a YAML file.

    Raises:
        InputError: it is no YAML, or no room; the field is named.
    """
    fix = "see docs/scenes.md"
    try:
        content = yaml.load(read_text(path, fix), Loader)
    except yaml.YAMLError as error:
        raise InputError(line_of(path, error), f"is no YAML: {fault_of(error)}.", fix, code="E-ROOM-FILE") from None
    if not isinstance(content, dict) or "name" in content:
        fault = "is no room: it needs keys like scale and items; its name is that of the file."
        raise InputError(path, fault, fix, code="E-ROOM-FILE")
    try:
        return RoomPlan.model_validate({"name": path.stem, **content})
    except ValidationError as error:
        raise InputError(path, f"is no room: {first_error(error)}.", fix, code="E-ROOM-FILE") from None


def count_models(files: Iterable[Path]) -> dict[str, int]:
    """Models per category that rooms need when no model stands in two of them."""
    return dict(Counter(item.category for path in files for item in read_room(path).items))


def list_objects(file: Path) -> dict[str, Mapping[str, bool]]:
    """Ids of the objects of a room, each with whether it can have a door and a drawer; empty: it cannot be read."""
    try:
        items = read_room(file).items
    except InputError:
        return {}
    found: dict[str, Mapping[str, bool]] = {}
    for name, item in zip(object_ids(item.label for item in items), items, strict=True):
        kind = CATEGORIES.get(item.category, Known(0, False, False))
        found[name] = {each: getattr(kind, f"{each}s") and getattr(item.model, f"{each}s")[1] > 0 for each in FRONTS}
    return found
