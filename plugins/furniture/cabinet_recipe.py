"""The recipe of a cabinet: what the generator can be asked for, with units and bounds."""

from typing import Annotated, Literal

from pydantic import Field

from roomkin.plugins.furniture.colors import METALS, WOODS
from roomkin.plugins.furniture.front_cells import CellKind
from roomkin.plugins.furniture.handles import Style
from roomkin.plugins.furniture.model import WOOD
from roomkin.plugins.furniture.recipe import Coating, Generator, between, chance, fixed, of, one_of, whole, zero_or
from roomkin.stages.contracts.library import Placement

Weight = Annotated[float, Field(gt=0)]
Length = Annotated[float, Field(gt=0, le=10)]
Share = Annotated[float, Field(gt=0, le=1)]
PanelStyle = Literal["flat", "frame", "raised", "planks"]


class CabinetRecipe(Generator):
    """Parameters of `cabinet`. Lengths in metres; thin parts shrink where the cabinet is too small for them."""

    layout: list[list[CellKind]] = Field(min_length=1)  # cells of the front: see `front_cells.cells`
    major: Literal["columns", "rows"] = fixed("columns")
    drawer_weight: Weight = between(0.28, 0.42)  # share of the height that a drawer asks for; a door asks for 1
    open_weight: Weight = between(0.5, 0.9)
    panel_weight: Weight = fixed(0.2)
    hinge: Literal[-1, 1] = one_of(-1, 1)  # side (low or high y) on which a door without a neighbour hangs
    panel: PanelStyle = one_of("flat", "frame", "raised", "planks")  # of doors, flaps and drawers
    window: bool = fixed(False)  # doors and flaps are glazed
    inset_front: bool = chance(0.25, default=False)  # the carcass shows around the fronts
    handle: Style
    handle_length: Share = between(0.2, 0.45)  # share of the panel's length
    handle_at: float = between(0.3, 0.9, ge=-1, le=1)  # height on a door: -1 bottom, 1 top
    handle_inset: Length = between(0.035, 0.055)  # from the free edge of a door
    board: Length = between(0.016, 0.024)  # thickness of the carcass
    front_thickness: Length = fixed(0.02)
    base: Literal["none", "plinth", "legs", "feet", "skids"] = one_of(
        "plinth", "legs", "feet", "none", "skids", shares=[0.35, 0.25, 0.15, 0.15, 0.1]
    )
    base_height: float = between(0.06, 0.16, ge=0, le=10)
    top: float = zero_or(0.008, 0.025, ge=0, le=10)  # overhang of the top; 0: no top
    top_thickness: Length = between(0.03, 0.06)
    reach: Share = fixed(0.8)  # share of the depth that drawers come out
    shelves: int = whole(0, 3, ge=0, le=50)  # behind every door and in every open cell
    buttons: int = whole(2, 6, ge=1, le=50, default=3)  # of a control panel
    body_colour: Coating
    front_colour: Coating
    field_colour: Coating
    handle_colour: Coating = of(METALS)
    top_colour: Coating
    base_colour: Coating = of(METALS, WOODS)
    inside_colour: Coating = fixed([0.62, 0.52, 0.38])
    panel_colour: Coating = fixed([0.20, 0.20, 0.22])
    placement: Placement = fixed("floor")
    column_weights: list[Weight] | None = None  # shares of the width; default: alike
    row_weights: list[Weight] | None = None  # shares of the height, of rows; default: by the kinds of their cells
    density: float = Field(WOOD, gt=0, le=20000)  # of the fronts, kg / m^3
    protrusion: float = Field(ge=0, le=1)  # how far handles stick out
