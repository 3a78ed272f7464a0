"""Cabinets, drawer units, wardrobes, fridges, ovens: panels with their handles in several styles, on carcasses."""

from typing import Any, Literal, NamedTuple

import numpy as np

from roomkin.plugins.furniture.finishes import DARK, Surface
from roomkin.plugins.furniture.fronts import STYLES, CabinetRecipe, CellKind, FrontCell, Span, cells, handle_parts
from roomkin.plugins.furniture.model import GLASS, METAL, PLASTIC, WOOD, Model, Moving, Part, Parts, Size, part
from roomkin.plugins.furniture.shapes import box, rim, rod

RELIEF = 0.006  # height of a frame above its field
EDGE_INSET = 0.036  # of a profile from the free edge: a finger fits between it and what is beside the panel
EDGE_LENGTH = 0.94  # share of the panel's side that a profile runs along


class PanelPlace(NamedTuple):
    """The place of a panel: its front face at `x`, its rectangle in y and z, its thickness."""

    x: float
    y: tuple[float, float]
    z: tuple[float, float]
    thickness: float

    @property
    def width(self) -> float:
        return self.y[1] - self.y[0]

    @property
    def height(self) -> float:
        return self.z[1] - self.z[0]


def panel_parts(front: PanelPlace, style: str, color: Surface, second: Surface, density: float = WOOD) -> list[Part]:
    """A panel as `flat`, `frame` (raised rim), `glass` (dark window), `planks` (grooves) or `raised` (raised field)."""
    (y0, y1), (z0, z1) = front.y, front.z
    x1, x0 = front.x, front.x - front.thickness
    wide = min(0.055, 0.22 * min(front.width, front.height))
    if style == "flat" or wide < 0.012:
        return [part(box((x0, x1), front.y, front.z), color, density)]
    back = x1 - RELIEF
    core = part(box((x0, back), front.y, front.z), second, density)
    if style in ("frame", "glass"):
        field = DARK if style == "glass" else second
        core = part(box((x0, back), front.y, front.z), field, GLASS if style == "glass" else density)
        return [core, *[part(mesh, color, density) for mesh in rim((back, x1), front.y, front.z, wide)]]
    if style == "raised":
        edge = part(box((x0, back), front.y, front.z), color, density)
        return [edge, part(box((back, x1), (y0 + wide, y1 - wide), (z0 + wide, z1 - wide)), second, density)]
    count = max(2, round(front.width / 0.09))
    pitch, groove = front.width / count, 0.006
    spans = [(y0 + k * pitch + groove / 2, y0 + (k + 1) * pitch - groove / 2) for k in range(count)]
    return [core, *[part(box((back, x1), span, front.z), color, density) for span in spans]]


def make_pulled_panel(
    front: PanelPlace, p: CabinetRecipe, kind: str, free_side: float, glass: bool = False
) -> list[Part]:
    """A panel with its handle.

    Args:
        kind: door, drawer or flap; says where the handle sits.
        free_side: for a door, +1 if its free edge is at high y, -1 if at low y.
    """
    handle = p.handle
    style = "glass" if glass else "flat" if handle == "edge" else p.panel
    parts = panel_parts(front, style, p.front_colour, p.field_colour, p.density)
    if handle == "none":
        return parts
    y_mid, z_mid = (front.y[0] + front.y[1]) / 2, (front.z[0] + front.z[1]) / 2
    along: Literal["y", "z"] = "z" if kind == "door" else "y"
    if kind == "door":
        inset = min(EDGE_INSET if handle == "edge" else p.handle_inset, 0.25 * front.width)
        length = (EDGE_LENGTH if handle == "edge" else min(p.handle_length, 0.6)) * front.height
        y = front.y[1] - inset if free_side > 0 else front.y[0] + inset
        reach = (front.height - (0.04 if handle == "knob" else length)) / 2 - min(0.03, 0.1 * front.height)
        at = (front.x, y, z_mid + p.handle_at * max(reach, 0.0))
    elif handle == "edge":
        length = EDGE_LENGTH * front.width
        at = (front.x, y_mid, front.z[1] - min(EDGE_INSET, 0.25 * front.height))
    else:
        length = min(p.handle_length, 0.7) * front.width
        z = z_mid if kind == "drawer" else front.z[1] - min(0.04, 0.2 * front.height)
        at = (front.x, y_mid, z)
    if kind == "drawer" and style in ("frame", "glass", "planks"):
        beneath = ((middle - 0.012, middle + 0.012) for middle in at[1:])
        parts.append(part(box((front.x - RELIEF, front.x), *beneath), p.front_colour))
    return parts + handle_parts(handle, at, along, length, p.protrusion, p.handle_colour)


def control_panel(front: PanelPlace, p: CabinetRecipe) -> list[Part]:
    """A fixed strip with a display and round buttons: ovens, microwaves, dishwashers."""
    x0, x1 = front.x - front.thickness, front.x
    parts = Parts()
    parts.add(box((x0, x1), front.y, front.z), p.panel_colour, PLASTIC)
    upright = front.height > front.width
    y_mid, z_mid = (front.y[0] + front.y[1]) / 2, (front.z[0] + front.z[1]) / 2
    count = p.buttons
    short = min(front.width, front.height)
    radius, out = 0.24 * short, min(0.02, 0.3 * short)
    if upright:
        half, span = 0.35 * short, (front.z[1] - 0.22 * front.height, front.z[1] - 0.08 * front.height)
        spots = [(y_mid, front.z[0] + front.height * (0.6 * (k + 0.6) / count)) for k in range(count)]
    else:
        half, span = 0.1 * front.width, (z_mid - 0.28 * short, z_mid + 0.28 * short)
        side = [(-1) ** k * (0.2 + 0.26 * (k // 2) / max(1, (count - 1) // 2)) for k in range(count)]
        spots = [(y_mid + s * front.width, z_mid) for s in side]
    parts.add(box((x1, x1 + 0.002), (y_mid - half, y_mid + half), span), DARK, PLASTIC, solid=False)
    for a, b in spots:
        button = rod((x1, a, b), (x1 + out, a, b), min(radius, 0.022))
        parts.add(button, p.handle_colour, METAL, smooth=True, solid=False)
    return parts


GAP = 0.004  # between neighbouring fronts: siblings collide in PhysX
SWING = 2.9  # so much more does a door swing out that is stretched by 1.25 in depth and by 0.75 in width
FRONTS = {"door", "drawer", "flap"}


class Cabinet(CabinetRecipe):
    """A carcass on a base, its front cut into cells (see `front_cells.cells`)."""

    def build(self, size: Size) -> Model:
        return _cabinet(self, size)

    @property
    def fronts(self) -> tuple[int, int]:
        kinds = [kind for line in self.layout for kind in line]
        return kinds.count("door") + kinds.count("flap"), kinds.count("drawer")


def _cabinet(p: CabinetRecipe, size: Size) -> Model:
    depth, width, height = size
    board = min(p.board, 0.1 * min(size))
    thick = min(p.front_thickness, 0.15 * depth)
    out = min(p.protrusion, 0.3 * depth) if p.handle != "none" else 0.0
    p = p.model_copy(update={"protrusion": out})
    out = max(out, 0.02 if any("panel" in line for line in p.layout) else 0.0)
    overhang = min(p.top, 0.1 * width, out + thick) if p.handle != "edge" else 0.0  # would leave no room above the edge
    base = min(p.base_height, 0.3 * height) if p.base != "none" else 0.0
    top = 0.6 * p.top_thickness if overhang else 0.0
    x_front = depth / 2 - out  # front face of the panels
    x_body = x_front - thick - 0.001
    half = width / 2 - overhang
    x_back = -depth / 2

    y, z = (-half, half), (base, height - top)
    parts = Parts(_base(p, (x_back, x_body), y, base))
    if overhang:
        slab = box((x_back, min(x_front + overhang, depth / 2)), (-width / 2, width / 2), (height - top, height))
        parts.add(slab, p.top_colour)
    for mesh in _shell((x_back, x_body), y, z, board):
        parts.add(mesh, p.body_colour)
    inner_y, inner_z = (-half + GAP, half - GAP), (z[0] + GAP, z[1] - GAP)
    if p.inset_front:  # the carcass shows around the fronts
        inner_y, inner_z = (-half + board, half - board), (z[0] + board, z[1] - board)
    weights: dict[CellKind, float] = {"door": 1.0, "flap": 1.0, "drawer": p.drawer_weight}
    weights |= {"open": p.open_weight, "panel": p.panel_weight}
    grid = cells(p.layout, p.major, inner_y, inner_z, weights, p.hinge, p.column_weights, p.row_weights)
    moving: list[Moving] = []
    for cell in grid:
        parts += _dividers(cell, (x_back, x_body), inner_y, inner_z, board, p)
        if cell.kind in FRONTS:
            moving.append(_make_moving(cell, p, x_front, thick, x_back + board, len(moving)))
        elif cell.kind == "panel":
            parts += control_panel(_front(cell, x_front, thick), p)
    return Model(parts, moving, placement=p.placement)


def _front(cell: FrontCell, x: float, thick: float) -> PanelPlace:
    return PanelPlace(x, (cell.y[0] + GAP / 2, cell.y[1] - GAP / 2), (cell.z[0] + GAP / 2, cell.z[1] - GAP / 2), thick)


def _make_moving(cell: FrontCell, p: CabinetRecipe, x: float, thick: float, x_back: float, number: int) -> Moving:
    front = _front(cell, x, thick)
    handle = STYLES[p.handle].kind
    if cell.kind == "drawer":
        parts = make_pulled_panel(front, p, "drawer", 0.0) + _tray(front, x_back, p)
        travel = p.reach * (x - thick - x_back)
        origin = (x - thick, sum(front.y) / 2, sum(front.z) / 2)
        return Moving(f"drawer_{number}", "drawer", parts, origin, (1.0, 0.0, 0.0), travel, handle)
    if cell.kind == "flap":  # the hinge line is the front lower edge, so that the panel clears the carcass
        parts = make_pulled_panel(front, p, "flap", 0.0, glass=p.window)
        origin = (x, sum(front.y) / 2, front.z[0])
        return Moving(f"door_{number}", "door", parts, origin, (0.0, 1.0, 0.0), np.pi / 2, handle)
    # The rear free corner of a thick door swings beyond its edge, by more if it is stretched: room for it.
    room = max(0.0, SWING * thick**2 / (2 * front.width) - GAP) / 2
    front = front._replace(y=(front.y[0] + room * (cell.hinge > 0), front.y[1] - room * (cell.hinge < 0)))
    parts = make_pulled_panel(front, p, "door", -cell.hinge, glass=p.window)
    edge = front.y[1] if cell.hinge > 0 else front.y[0]
    origin = (x, edge, sum(front.z) / 2)  # front outer edge: the panel never turns into its neighbour
    return Moving(f"door_{number}", "door", parts, origin, (0.0, 0.0, float(cell.hinge)), np.pi / 2, handle)


def _tray(front: PanelPlace, x_back: float, p: CabinetRecipe) -> list[Part]:
    """Bottom, sides and back of a drawer box behind its front."""
    wall, clear = 0.010, 0.024
    x1 = front.x - front.thickness
    x0 = x_back + 0.1 * (x1 - x_back)
    y0, y1 = front.y[0] + clear, front.y[1] - clear
    z0 = front.z[0] + min(0.03, 0.3 * front.height)
    z1 = z0 + 0.6 * (front.z[1] - z0)
    meshes = [
        box((x0, x1), (y0, y1), (z0, z0 + wall)),
        box((x0, x1), (y0, y0 + wall), (z0 + wall, z1)),
        box((x0, x1), (y1 - wall, y1), (z0 + wall, z1)),
        box((x0, x0 + wall), (y0 + wall, y1 - wall), (z0 + wall, z1)),
    ]
    return [part(mesh, p.inside_colour) for mesh in meshes]


def _shell(x: Span, y: Span, z: Span, board: float) -> list[Any]:
    back = min(board, 0.008)
    return [
        box(x, (y[0], y[0] + board), z),
        box(x, (y[1] - board, y[1]), z),
        box(x, (y[0] + board, y[1] - board), (z[0], z[0] + board)),
        box(x, (y[0] + board, y[1] - board), (z[1] - board, z[1])),
        box((x[0], x[0] + back), (y[0] + board, y[1] - board), (z[0] + board, z[1] - board)),
    ]


def _dividers(cell: FrontCell, x: Span, y: Span, z: Span, board: float, p: CabinetRecipe) -> list[Part]:
    """Boards on a cell's low-y side and floor where they are not the carcass's own, and shelves inside."""
    thin = min(board, 0.016)
    meshes = []
    inside = (x[0] + 0.008, x[1])
    low_y, high_y = max(cell.y[0], y[0] + board), min(cell.y[1], y[1] - board)
    if cell.y[0] > y[0] + 1e-6:
        upright = (max(cell.z[0], z[0] + board), min(cell.z[1], z[1] - board))
        meshes.append(box(inside, (cell.y[0] - thin / 2, cell.y[0] + thin / 2), upright))
        low_y = cell.y[0] + thin / 2
    if cell.z[0] > z[0] + 1e-6:
        meshes.append(box(inside, (low_y, high_y), (cell.z[0] - thin / 2, cell.z[0] + thin / 2)))
    count = p.shelves if cell.kind in ("door", "open") else 0
    for k in range(count):
        middle = cell.z[0] + (k + 1) / (count + 1) * (cell.z[1] - cell.z[0])
        meshes.append(box((inside[0], inside[1] - 0.02), (low_y, high_y), (middle - thin / 2, middle + thin / 2)))
    return [part(mesh, p.body_colour) for mesh in meshes]


def _base(p: CabinetRecipe, x: tuple[float, float], y: tuple[float, float], height: float) -> list[Part]:
    """The base below the carcass."""
    style, color = p.base, p.base_colour
    if style == "none":
        return []
    if style == "plinth":
        return [part(box((x[0] + 0.01, x[1] - 0.05), (y[0] + 0.002, y[1] - 0.002), (0.0, height)), color)]
    if style == "skids":
        width = 0.08 * (y[1] - y[0])
        return [part(box(x, span, (0.0, height)), color) for span in ((y[0], y[0] + width), (y[1] - width, y[1]))]
    inset = 0.035
    corners = [(a, b) for a in (x[0] + inset, x[1] - inset) for b in (y[0] + inset, y[1] - inset)]
    radius = 0.022
    if style == "legs":
        return [part(rod((a, b, 0), (a, b, height), 0.55 * radius, radius), color, smooth=True) for a, b in corners]
    return [part(box((a - radius, a + radius), (b - radius, b + radius), (0.0, height)), color) for a, b in corners]
