"""Contracts of the `assets` stage: an `asset.json` per model, an index per shard of them and one per library."""

from operator import not_
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from roomkin.stages.contracts import types
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.parts import FRONTS, PARTS, FrontType, HingeSide, Panel, PartType

Symmetry = Literal["none", "half_turn", "third_turn", "quarter_turn", "full"]
Placement = Literal["floor", "object", "wall"]
HandleKind = Literal["bar", "arch", "knob", "edge", "face"]
Limit = Annotated[types.Finite, Field(ge=-100, le=100)]  # radians or metres
Buttons = Annotated[types.Panels, Field(exclude_if=not_, description="left out where there are none")]


class FrontPanel(Contract):
    """The front that a joint moves, closed, with its handle. Metres; left and right are those of whoever faces it."""

    hinge: HingeSide = Field(description="side on which it hangs; slide: a drawer")
    across: types.Finite | None = Field(None, description="of its center from the asset's left side; null: not known")
    height: types.Finite = Field(description="of its center above the asset's bottom")
    size: tuple[types.Extent, types.Extent] = Field(description="width and height")

    def measure_on_front(self, kind: FrontType, box: types.Vector) -> Panel | None:
        """As shares of the front of a box (x, y, z); None: nothing of it is seen there, or nobody knows where it is."""
        if self.across is None:
            return None
        sides = [
            min(max(round((middle + sign * extent / 2) / whole, 4), 0.0), 1.0)
            for middle, extent, whole in zip((self.across, self.height), self.size, box[1:], strict=True)
            for sign in (-1, 1)
        ]
        left, right, bottom, top = sides
        shown = left < right and bottom < top
        return Panel(kind=kind, left=left, right=right, bottom=bottom, top=top) if shown else None


class Joint(Contract):
    """One joint of an articulated asset. Angles in radians, lengths in metres."""

    model_config = ConfigDict(serialize_by_alias=True, validate_by_name=True)  # files say `role`

    name: types.Text
    type: Literal["revolute", "prismatic"]
    part_type: PartType = Field(alias="role")
    parent: types.Text
    link: types.Text = Field(description="child link that the joint moves")
    axis: types.UnitVector = Field(description="unit axis in the joint frame, as in the URDF")
    lower: Limit
    upper: Limit
    handle_link: str | None = Field(None, description="link that carries the handle; null: no protruding handle")
    handle: HandleKind | None = Field(
        None, description="what a gripper can hold; edge: a profile at the free edge; face: it is pushed"
    )
    panel: FrontPanel | None = Field(None, description="null: it moves nothing that is seen")

    @model_validator(mode="after")
    def _check_range(self) -> "Joint":
        if self.lower >= self.upper:
            raise ValueError(f"joint '{self.name}' cannot move: lower {self.lower:g} is not below upper {self.upper:g}")
        return self


Number = types.Finite
Finish = dict[str, str | list[str]]  # parameters of a recipe, of what it is made of in which colors


class Recipe(Contract):
    """How a procedural asset was made, so that it can be made again at another size."""

    generator: types.Text
    variation_of: types.Id | None = Field(None, description="the model of this library that it is a near relative of")
    parameters: dict[str, Number | int | str | bool | list[Number] | list[int] | list[str] | list[list[str]]]


class Asset(Document):
    """`asset.json`: one model a_i = (category t_i, geometry) of the library (paper A.1).

    The asset frame is the URDF root frame: z up, front towards +x. `box_min` and `box_max` bound
    the visual geometry in that frame with every joint at its lower limit (closed), in metres.
    """

    id: types.Id
    category: types.Id = Field(description="lower-case words joined by underscores, e.g. bottom_cabinet")
    urdf: types.RelativePath = Field("model.urdf", description="path of the URDF relative to this file")
    box_min: types.Position
    box_max: types.Position
    mass: types.Mass
    joints: list[Joint] = []
    doors: types.Panels = 0
    drawers: types.Panels = 0
    buttons: Buttons = 0
    symmetry: Symmetry = Field(
        "none", description="rotational symmetry about z: orientation is scored modulo that turn; full has none"
    )
    placement: Placement = "floor"
    recipe: Recipe | None = None
    licence: str
    provenance: str
    checksum: str = Field(description="sha256 over the names and bytes of all other files of the folder")

    @model_validator(mode="after")
    def _check_size(self) -> "Asset":
        if not all(1e-6 <= extent <= types.LARGEST for extent in self.size):
            extents = " x ".join(f"{extent:g}" for extent in self.size)
            raise ValueError(f"box_min, box_max: a box of {extents} m (0 to {types.LARGEST:g} m each)")
        types.check_unique("joints", [joint.name for joint in self.joints])
        for part, stated in zip(PARTS, (self.doors, self.drawers, self.buttons), strict=True):
            count = sum(joint.part_type == part for joint in self.joints)
            if stated != count:
                raise ValueError(f"{part}s: says {stated}, but {count} joints are {part}s")
        return self

    @property
    def size(self) -> types.Vector:
        """Extents (x, y, z) of the closed box in metres."""
        return tuple(high - low for low, high in zip(self.box_min, self.box_max, strict=True))  # type: ignore[return-value]

    @property
    def family(self) -> str:
        """The model that it is a variation of; its own id if it is none."""
        return self.recipe.variation_of or self.id if self.recipe else self.id

    @property
    def panels(self) -> list[Panel]:
        """The layout of its doors and drawers, as far as they are seen on its front."""
        fronts = [(joint.panel, front) for joint in self.joints for front in FRONTS if joint.part_type == front]
        found = [panel.measure_on_front(front, self.size) for panel, front in fronts if panel is not None]
        return [panel for panel in found if panel is not None]

    def change_finish(self, finish: Finish) -> "Asset":
        """The same by a recipe with these parameters; what has no recipe stays."""
        if self.recipe is None or not finish:
            return self
        recipe = self.recipe.model_copy(update={"parameters": self.recipe.parameters | finish})
        return self.model_copy(update={"recipe": recipe})

    @property
    def articulated(self) -> bool:
        """Whether it has doors or drawers (paper A.7)."""
        return self.doors + self.drawers > 0


class LeftOut(Document):
    """Models that matching does without: the true ones of a room and their relatives (perturbation `unknown`)."""

    assets: list[types.Id]


def model_name(category: str, index: int) -> str:
    """Id of the `index`-th model of a category."""
    return f"{category}_{index:02d}"


class LibraryEntry(Contract):
    """One line of the library's index: what matching needs without opening the asset."""

    id: types.Id
    category: types.Id
    archive: types.RelativePath = Field(description="zip archive that holds the folder <id>/, relative to the index")
    doors: types.Panels
    drawers: types.Panels
    buttons: Buttons = 0
    panels: list[Panel] = Field([], description="where they lie on its front; empty: not known")
    size: types.Size | None = Field(None, description="its closed box; null: not known")
    placement: Placement | None = Field(None, description="where it belongs; null: not known")
    checksum: str

    @classmethod
    def of(cls, asset: Asset, archive: str) -> "LibraryEntry":
        """The line of an asset in the zip file `archive`, relative to the index."""
        return cls(archive=archive, **{name: getattr(asset, name) for name in set(cls.model_fields) - {"archive"}})


class LibraryPart(Document):
    """The index of some models of a library, perhaps none, sorted by id."""

    assets: list[LibraryEntry]
    left_out: list[str] = Field([], description="the user's models that cannot be used, with the reason: a line each")
    categories: list[CategoryFacts] = Field(
        [], description="what is known of categories, those of other libraries, too"
    )

    @model_validator(mode="after")
    def _check_ids(self) -> "LibraryPart":
        types.check_unique("assets: ids", [entry.id for entry in self.assets])
        return self


class Library(LibraryPart):
    """`library.json`: the index of a library, sorted by id."""

    assets: list[LibraryEntry] = Field(min_length=1)


class SnapshotShard(Document):
    """Sidecar of a snapshot shard: N_snap yaw views and one representative per asset (paper A.1).

    The HDF5 file beside it holds `rgb` (A, V, H, W, 3) uint8 and `depth` (A, V, H, W) uint16 in thousandths
    of the asset's largest extent (0: background), V = len(yaws) + 1; view v < len(yaws) shows the asset turned
    by `yaws[v]` about z, and the last view is the representative. At yaw 0 the front faces the camera.
    """

    assets: list[types.Id]
    yaws: list[types.Angle] = Field(min_length=1)
    representative_yaw: types.Angle
    image_size: types.Side
    intrinsics: types.CameraMatrix = Field(description="3x3 camera matrix in pixels")
    elevation: types.Angle | None = Field(None, description="of the camera above level, radians; for upright normals")

    @model_validator(mode="after")
    def _check_views(self) -> "SnapshotShard":
        types.check_unique("assets", self.assets)
        types.check_unique("yaws", self.yaws)
        types.check_view(self.image_size, self.image_size, self.intrinsics)
        return self
