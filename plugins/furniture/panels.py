"""Front panels of doors, flaps and drawers in several styles, with their handles."""

from typing import Literal, NamedTuple

from roomkin.plugins.furniture.cabinet_recipe import CabinetRecipe
from roomkin.plugins.furniture.finishes import DARK, Surface
from roomkin.plugins.furniture.handles import handle_parts
from roomkin.plugins.furniture.model import GLASS, METAL, PLASTIC, WOOD, Part, Parts, part
from roomkin.plugins.furniture.shapes import box, rim, rod

RELIEF = 0.006  # height of a frame above its field
EDGE_INSET = 0.036  # of a profile from the free edge: a finger fits between it and what is beside the panel
EDGE_LENGTH = 0.94  # share of the panel's side that a profile runs along


class Front(NamedTuple):
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


def panel_parts(front: Front, style: str, color: Surface, second: Surface, density: float = WOOD) -> list[Part]:
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
    planks = [
        box((back, x1), (y0 + k * pitch + groove / 2, y0 + (k + 1) * pitch - groove / 2), front.z) for k in range(count)
    ]
    return [core, *[part(mesh, color, density) for mesh in planks]]


def make_pulled_panel(front: Front, p: CabinetRecipe, kind: str, free_side: float, glass: bool = False) -> list[Part]:
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


def control_panel(front: Front, p: CabinetRecipe) -> list[Part]:
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
