"""The recipe of a cabinet: what the generator can be asked for, with units and bounds."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from stages.contracts.library import Placement
from stages.procedural.finishes import finish_of
from stages.procedural.front_cells import CellKind
from stages.procedural.handles import Style
from stages.procedural.model import WOOD


def _known(surface: str | list[float]) -> str | list[float]:
    finish_of(surface)
    return surface


Coating = Annotated[str | list[float], AfterValidator(_known)]  # a material in a colour: see `finishes`
Weight = Annotated[float, Field(gt=0)]
Length = Annotated[float, Field(gt=0, le=10)]
Share = Annotated[float, Field(gt=0, le=1)]


class CabinetRecipe(BaseModel):
    """Parameters of `cabinet`. Lengths in metres; thin parts shrink where the cabinet is too small for them."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    layout: list[list[CellKind]] = Field(min_length=1, description="cells of the front: see `front_cells.cells`")
    major: Literal["columns", "rows"] = "columns"
    drawer_weight: Weight = Field(description="share of the height that a drawer asks for; a door asks for 1")
    open_weight: Weight
    panel_weight: Weight
    hinge: Literal[-1, 1] = Field(description="side (low or high y) on which a door without a neighbour hangs")
    panel: Literal["flat", "frame", "raised", "planks"] = Field(description="style of doors, flaps and drawers")
    window: bool = Field(False, description="doors and flaps are glazed")
    inset_front: bool = Field(False, description="the carcass shows around the fronts")
    handle: Style
    handle_length: Share = Field(description="share of the panel's length")
    handle_at: float = Field(ge=-1, le=1, description="height on a door: -1 bottom, 1 top")
    handle_inset: Length = Field(description="from the free edge of a door")
    board: Length = Field(description="thickness of the carcass")
    front_thickness: Length
    base: Literal["none", "plinth", "legs", "feet", "skids"]
    base_height: float = Field(ge=0, le=10)
    top: float = Field(ge=0, le=10, description="overhang of the top; 0: no top")
    top_thickness: Length
    reach: Share = Field(description="share of the depth that drawers come out")
    shelves: int = Field(ge=0, le=50, description="behind every door and in every open cell")
    buttons: int = Field(3, ge=1, le=50, description="of a control panel")
    body_colour: Coating
    front_colour: Coating
    field_colour: Coating
    handle_colour: Coating
    top_colour: Coating
    base_colour: Coating
    inside_colour: Coating
    panel_colour: Coating
    placement: Placement = "floor"
    column_weights: list[Weight] | None = Field(None, description="shares of the width; default: alike")
    density: Annotated[float, Field(gt=0, le=20000)] = Field(WOOD, description="of the fronts, kg / m^3")
    protrusion: float = Field(ge=0, le=1, description="how far handles stick out")

    def changed(self, **changes: Any) -> "CabinetRecipe":
        """The recipe with some parameters changed, checked again."""
        return CabinetRecipe.model_validate(self.parameters() | changes)

    def parameters(self) -> dict[str, Any]:
        """What was given, as the recipe of an asset records it."""
        return self.model_dump(exclude_unset=True)
