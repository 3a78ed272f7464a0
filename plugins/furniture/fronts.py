"""The front of a cabinet: divided into cells of doors, drawers and shelves, with handles that a gripper can hold."""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from roomkin.plugins.furniture.colors import METALS, WOODS
from roomkin.plugins.furniture.fields import between, chance, fixed, of, one_of, whole, zero_or
from roomkin.plugins.furniture.finishes import Surface
from roomkin.plugins.furniture.model import METAL, WOOD, Part, part
from roomkin.plugins.furniture.recipe import Coating, Generator
from roomkin.plugins.furniture.shapes import hull, lathe, rod, rotate, slab, translate
from roomkin.stages.contracts.library import HandleKind, Placement

Style = Literal["bar", "square_bar", "knob", "arch", "edge", "none"]


class Pull(NamedTuple):
    """A style of handle: how far it sticks out (metres), its kind, and the share of sampled cabinets that have it."""

    protrusion: float
    kind: HandleKind | None
    share: float = 0.0


STYLES: dict[Style, Pull] = {
    "bar": Pull(0.038, "bar", 0.3),
    "square_bar": Pull(0.036, "bar", 0.2),
    "knob": Pull(0.034, "knob", 0.2),
    "arch": Pull(0.040, "arch", 0.2),
    "edge": Pull(0.032, "edge", 0.1),
    "none": Pull(0.0, None),
}
HANDLES = [style for style, pull in STYLES.items() if pull.share]
HANDLE_SHARES = [STYLES[style].share for style in HANDLES]


def handle_parts(
    style: Style,
    at: tuple[float, float, float],
    along: Literal["y", "z"],
    length: float,
    protrusion: float,
    color: Surface,
) -> list[Part]:
    """Parts of a handle on a panel that faces +x.

    Args:
        at: point on the panel's face at the handle's middle.
        along: direction of its length: z on doors, y on drawers.
        length: metres; a knob ignores it.
        protrusion: distance from face to the handle's front.
    """
    if style == "none":
        return []
    make = {"bar": _bar, "square_bar": _square_bar, "knob": _knob, "arch": _arch, "edge": _edge}[style]
    parts = make(max(length, 0.06), protrusion, color)
    if along == "y":
        parts = [part(rotate(p.mesh, np.pi / 2, [1, 0, 0]), color, p.density, p.smooth) for p in parts]
    return [part(translate(p.mesh, at), color, p.density, p.smooth) for p in parts]


def _bar(length: float, out: float, color: Surface) -> list[Part]:
    radius = 0.0055
    x, inset = out - radius, length * 0.38
    posts = [rod((-0.004, 0, z), (x, 0, z), 0.004) for z in (-inset, inset)]
    bar = rod((x, 0, -length / 2), (x, 0, length / 2), radius)
    return [part(mesh, color, METAL, smooth=True) for mesh in (bar, *posts)]


def _square_bar(length: float, out: float, color: Surface) -> list[Part]:
    thickness, width = 0.010, 0.013
    middle = (out - 0.003) / 2 - 0.002
    bar = slab((out - thickness / 2, 0, 0), (thickness, width, length))
    posts = [slab((middle, 0, z), (out - 0.001, width, 0.012)) for z in (0.006 - length / 2, length / 2 - 0.006)]
    return [part(mesh, color, METAL) for mesh in (bar, *posts)]


def _edge(length: float, out: float, color: Surface) -> list[Part]:
    """A profile along the panel that two fingers take hold of from either side."""
    return [part(slab(((out - 0.004) / 2, 0, 0), (out + 0.004, 0.010, length)), color, METAL)]


def _knob(length: float, out: float, color: Surface) -> list[Part]:
    low, side = (0.009, out * 0.45), [(0.015, out * 0.68), (0.015, out * 0.82), (0.010, out)]
    head = rotate(lathe([(0, low[1]), low, *side, (0, out)], 16), np.pi / 2, [0, 1, 0])
    meshes = [rod((-0.004, 0, 0), (out * 0.5, 0, 0), 0.0065), head]
    return [part(mesh, color, METAL, smooth=True) for mesh in meshes]


def _arch(length: float, out: float, color: Surface) -> list[Part]:
    half, thickness, width = length / 2, 0.010, 0.014
    angles = np.linspace(0, np.pi, 9)
    outline = np.column_stack([out * np.sin(angles) ** 0.7, -half * np.cos(angles)])
    inner = np.column_stack([np.maximum(outline[:, 0] - thickness, -0.004), outline[:, 1] * (1 - 0.009 / half)])
    outline[[0, -1], 0] = -0.004
    pieces = []
    for k in range(len(angles) - 1):
        corners = [outline[k], outline[k + 1], inner[k], inner[k + 1]]
        pieces.append(hull([(x, y, z) for x, z in corners for y in (-width / 2, width / 2)]))
    return [part(mesh, color, METAL) for mesh in pieces]


Span = tuple[float, float]
CellKind = Literal["door", "drawer", "open", "flap", "panel"]


class FrontCell(NamedTuple):
    """One cell of the front. `hinge` is -1 or +1: the side (low or high y) on which a door hangs."""

    kind: CellKind
    y: Span
    z: Span
    hinge: int


def cells(
    layout: list[list[CellKind]],
    major: Literal["columns", "rows"],
    y: Span,
    z: Span,
    weights: dict[CellKind, float],
    hinge: int,
    column_weights: list[float] | None = None,
    row_weights: list[float] | None = None,
) -> list[FrontCell]:
    """Cells of the rectangle y x z.

    Args:
        layout: with `columns`, one list per column (low y first) of kinds from the top down; with `rows`, one list
            per row from the top down of kinds from low y to high y.
        weights: share of the height that each kind asks for.
        hinge: side of the doors that stand alone in their row; others hang on the outer side of their pair.
    """
    found = []
    if major == "columns":
        widths, doors = column_weights or [1.0] * len(layout), ["door" in column for column in layout]
        for index, (column, across) in enumerate(zip(layout, _split(y, widths), strict=True)):
            heights = _split((z[1], z[0]), [weights[kind] for kind in column])
            for kind, (top, bottom) in zip(column, heights, strict=True):
                found.append(FrontCell(kind, across, (bottom, top), _hinge(doors, index, hinge)))
        return found
    heights = _split((z[1], z[0]), row_weights or [max(weights[kind] for kind in row) for row in layout])
    for row, (top, bottom) in zip(layout, heights, strict=True):
        for index, (kind, across) in enumerate(zip(row, _split(y, [1.0] * len(row)), strict=True)):
            found.append(FrontCell(kind, across, (bottom, top), _hinge([k == "door" for k in row], index, hinge)))
    return found


def _split(span: Span, weights: list[float]) -> list[Span]:
    total, start, parts = sum(weights), span[0], []
    for weight in weights:
        end = start + (span[1] - span[0]) * weight / total
        parts.append((start, end))
        start = end
    return parts


def _hinge(doors: list[bool], index: int, alone: int) -> int:
    """Side on which a door hangs. Doors pair up from low y on and open from the middle of their pair; the last of an
    odd number hangs on the outer side; a single one on the side `alone`."""
    place, count = sum(doors[:index]), sum(doors)
    if count == 1:
        return alone
    left_over = count % 2 == 1 and place == count - 1
    return 1 if place % 2 == 1 or left_over else -1


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
