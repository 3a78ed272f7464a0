"""Sample cabinets of all sorts; within a category the draws form a continuum of proportions, fronts and handles."""

from typing import Any

import numpy as np

from stages.procedural.cabinet_recipe import CabinetRecipe
from stages.procedural.colours import APPLIANCE, METALS, PAINTS, STONES, TILES, WOODS, Palette, pick
from stages.procedural.finishes import brightness, shade
from stages.procedural.handles import PROTRUSION
from stages.procedural.model import Draw, Size

HANDLES = ["bar", "square_bar", "knob", "arch", "edge"]
HANDLE_SHARES = [0.3, 0.2, 0.2, 0.2, 0.1]
PANELS = ["flat", "frame", "raised", "planks"]

Rng = np.random.Generator
Layout = list[list[str]]  # of kinds of cells; the recipe checks them


def _size(rng: Rng, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Size:
    a, b, c = (round(float(rng.uniform(*span)), 3) for span in (x, y, z))
    return (a, b, c)


def _recipe(rng: Rng, layout: Layout, tops: Palette = WOODS, **changes: Any) -> CabinetRecipe:
    """A recipe for the layout; `changes` overrule the draw."""
    front = pick(rng, PAINTS, WOODS)
    body = shade(front, 0.82) if rng.random() < 0.6 else pick(rng, PAINTS, WOODS)
    handle = str(rng.choice(HANDLES, p=HANDLE_SHARES))
    p: dict[str, Any] = {
        "layout": layout,
        "major": "columns",
        "drawer_weight": round(float(rng.uniform(0.28, 0.42)), 3),
        "open_weight": round(float(rng.uniform(0.5, 0.9)), 3),
        "panel_weight": 0.2,
        "hinge": int(rng.choice([-1, 1])),
        "panel": str(rng.choice(PANELS)),
        "window": False,
        "inset_front": bool(rng.random() < 0.25),
        "handle": handle,
        "handle_length": round(float(rng.uniform(0.2, 0.45)), 3),
        "handle_at": round(float(rng.uniform(0.3, 0.9)), 3),
        "handle_inset": round(float(rng.uniform(0.035, 0.055)), 3),
        "board": round(float(rng.uniform(0.016, 0.024)), 3),
        "front_thickness": 0.02,
        "base": str(rng.choice(["plinth", "legs", "feet", "none", "skids"], p=[0.35, 0.25, 0.15, 0.15, 0.1])),
        "base_height": round(float(rng.uniform(0.06, 0.16)), 3),
        "top": round(float(rng.choice([0.0, rng.uniform(0.008, 0.025)])), 3),
        "top_thickness": round(float(rng.uniform(0.03, 0.06)), 3),
        "reach": 0.8,
        "shelves": int(rng.integers(0, 3)),
        "buttons": int(rng.integers(2, 6)),
        "body_colour": body,
        "front_colour": front,
        "field_colour": shade(front, float(rng.choice([0.72, 0.85, 1.2]))),
        "handle_colour": pick(rng, METALS),
        "top_colour": pick(rng, tops),
        "base_colour": pick(rng, METALS, WOODS),
        "inside_colour": [0.62, 0.52, 0.38],
        "panel_colour": [0.20, 0.20, 0.22],
        "placement": "floor",
    } | changes
    return CabinetRecipe.model_validate(p | {"protrusion": PROTRUSION[p["handle"]]})


def _draw(size: Size, recipe: CabinetRecipe) -> Draw:
    return Draw("cabinet", size, recipe.parameters())


def bottom_cabinet(rng: Rng, index: int) -> Draw:
    """Floor cabinet; one in five has drawers only, two have doors only, two have both."""
    kind = ["doors", "mixed", "doors", "mixed", "drawers"][index % 5]
    columns = int(rng.integers(1, 4))
    major = "columns"
    if kind == "doors":
        layout = [["door"] for _ in range(columns)]
    elif kind == "drawers":
        layout = [["drawer"] * int(rng.integers(2, 5)) for _ in range(min(columns, 2))]
    elif index % 2 and columns > 1 and rng.random() < 0.6:  # a wide drawer above doors
        layout, major = [["drawer"], ["door"] * min(columns, 2)], "rows"
    else:
        stack = ["drawer"] * int(rng.integers(1, 3))
        layout = [[*stack, "door"] for _ in range(columns)]
        if columns > 1 and rng.random() < 0.4:
            layout[int(rng.integers(columns))] = ["drawer"] * 3
            if not any("door" in column for column in layout):
                layout[0] = [*stack, "door"]
    width = rng.uniform(0.38, 0.52) * max(len(line) if major == "rows" else len(layout) for line in layout)
    size = _size(rng, (0.42, 0.66), (float(width), float(width) + 0.08), (0.62, 1.0))
    return _draw(size, _recipe(rng, layout, WOODS + STONES + TILES, major=major))


def pedestal(p: dict[str, Any]) -> dict[str, Any]:
    """Parameters of the drawer unit of a desk, from those of the desk."""
    same = {key: p[key] for key in ("handle", "panel", "front_colour", "body_colour", "handle_colour")}
    rest = {
        "layout": [["drawer"] * int(p["drawers"])],
        "drawer_weight": 1.0,
        "open_weight": 1.0,
        "panel_weight": 1.0,
        "hinge": 1,
        "handle_length": 0.4,
        "handle_at": 0.0,
        "handle_inset": 0.04,
        "board": 0.016,
        "front_thickness": 0.018,
        "base": "plinth",
        "base_height": 0.04,
        "top": 0.0,
        "top_thickness": 0.02,
        "reach": 0.8,
        "shelves": 0,
        "field_colour": shade(p["front_colour"], 0.85),
        "top_colour": p["front_colour"],
        "base_colour": p["body_colour"],
        "inside_colour": [0.62, 0.52, 0.38],
        "panel_colour": [0.2, 0.2, 0.22],
        "protrusion": PROTRUSION[p["handle"]],
    }
    return same | rest


def nightstand(rng: Rng, index: int) -> Draw:
    """Small, beside a bed: drawers, a door, an open shelf."""
    layout = [["drawer", "open"], ["drawer", "drawer"], ["drawer", "door"], ["drawer"] * 3, ["open", "drawer"]][
        index % 5
    ]
    size = _size(rng, (0.34, 0.44), (0.38, 0.54), (0.42, 0.64))
    base = str(rng.choice(["legs", "legs", "feet", "plinth"]))
    p = _recipe(
        rng, [layout], base=base, base_height=round(float(rng.uniform(0.08, 0.2)), 3), drawer_weight=0.6, shelves=0
    )
    return _draw(size, p)


def tv_stand(rng: Rng, index: int) -> Draw:
    """Long, very low, with open bays for what is beneath the screen."""
    layouts = [
        [["open"], ["drawer"]], [["door"], ["open", "open"], ["door"]], [["drawer"], ["open"], ["drawer"]],
        [["open", "drawer"], ["open", "drawer"]], [["open"], ["open"], ["open"]],
    ]  # fmt: skip
    size = _size(rng, (0.36, 0.46), (1.1, 1.9), (0.34, 0.52))
    base = str(rng.choice(["legs", "feet", "plinth", "none"]))
    p = _recipe(
        rng,
        layouts[index % 5],
        base=base,
        base_height=round(float(rng.uniform(0.05, 0.14)), 3),
        drawer_weight=0.9,
        shelves=0,
        open_weight=0.7,
    )
    return _draw(size, p)


def wall_cabinet(rng: Rng, index: int) -> Draw:
    """Hangs on the wall: shallow, doors, sometimes glazed, sometimes an open shelf."""
    columns = 1 + index % 3
    layout = [["door"] for _ in range(columns)]
    if rng.random() < 0.3:
        layout = [["door", "open"] for _ in range(columns)]
    width = float(rng.uniform(0.32, 0.45) * columns)
    size = _size(rng, (0.30, 0.42), (width, width + 0.06), (0.5, 0.85))
    changes: dict[str, Any] = {
        "base": "none",
        "top": 0.0,
        "placement": "wall",
        "handle_at": -0.8,
        "window": bool(rng.random() < 0.3),
    }
    return _draw(size, _recipe(rng, layout, **changes))


def sideboard(rng: Rng, index: int) -> Draw:
    """Long and low: doors at the ends, drawers or an open bay in the middle."""
    drawers = int(rng.integers(2, 4))
    middle = [["drawer"] * drawers, ["open"], ["drawer", "open"], ["door"]][index % 4]
    layout = [["door"], middle, ["door"]] if index % 2 == 0 else [["door"], middle, middle[:], ["door"]]
    size = _size(rng, (0.38, 0.50), (1.1, 1.8), (0.55, 0.85))
    base = str(rng.choice(["legs", "feet", "plinth"]))
    return _draw(size, _recipe(rng, layout, base=base, base_height=round(float(rng.uniform(0.1, 0.22)), 3)))


def wardrobe(rng: Rng, index: int) -> Draw:
    """Tall doors, sometimes above drawers."""
    columns = 2 + index % 2
    layout = [["door"] for _ in range(columns)]
    changes: dict[str, Any] = {"handle_at": 0.0, "handle_length": 0.12, "drawer_weight": 0.16, "shelves": 2}
    if index % 3 == 1:
        layout = [["door", "drawer"] for _ in range(columns)]
    elif index % 3 == 2:
        layout, changes["major"] = [["door"] * columns, ["drawer"]], "rows"
    size = _size(rng, (0.5, 0.65), (0.45 * columns, 0.56 * columns), (1.75, 2.1))
    return _draw(size, _recipe(rng, layout, **changes))


def chest_of_drawers(rng: Rng, index: int) -> Draw:
    """Drawers only, in one to two columns, or two small ones above wide ones."""
    rows = int(rng.integers(2, 6))
    if index % 3 == 2:
        layout, major = [["drawer", "drawer"], *[["drawer"]] * (rows - 1)], "rows"
    else:
        layout, major = [["drawer"] * rows for _ in range(1 + index % 2)], "columns"
    width = 0.45 + 0.3 * (index % 3) + float(rng.uniform(0, 0.25))
    height = 0.2 + 0.17 * len(layout if major == "rows" else layout[0]) + float(rng.uniform(0, 0.12))
    size = _size(rng, (0.40, 0.55), (width, width + 0.05), (height, height + 0.05))
    return _draw(size, _recipe(rng, layout, major=major))


def _appliance(rng: Rng, layout: Layout, **changes: Any) -> CabinetRecipe:
    """A recipe in metal or glass, with a handle that is seen before the front."""
    front = pick(rng, APPLIANCE)
    handle = METALS[2] if brightness(front) > 0.4 else METALS[0]
    plain: dict[str, Any] = {
        "panel": "flat",
        "handle": str(rng.choice(["bar", "square_bar"])),
        "inset_front": False,
        "top": 0.0,
        "front_colour": front,
        "body_colour": shade(front, 0.85),
        "field_colour": front,
        "inside_colour": [0.75, 0.76, 0.78],
        "base_colour": [0.08, 0.08, 0.09],
        "handle_colour": pick(rng, [handle]),
    }
    return _recipe(rng, layout, **(plain | changes))


def fridge(rng: Rng, index: int) -> Draw:
    """One tall door, a freezer above or below, or two doors side by side."""
    layout = [[["door"]], [["door", "door"]], [["door"], ["door"]], [["door", "drawer"]]][index % 4]
    at = -0.5 if index % 4 == 1 else 0.2
    wide = 0.85 if len(layout) == 2 else 0.6
    size = _size(rng, (0.62, 0.74), (wide, wide + 0.12), (1.5, 1.9))
    p = _appliance(
        rng, layout, front_thickness=0.05, base="plinth", base_height=0.05, handle_at=at, handle_length=0.3, shelves=3,
        drawer_weight=0.5, board=0.04, density=130.0,
    )  # fmt: skip
    if index % 4 == 1:  # the freezer's door is the smaller one
        p = p.changed(layout=[["door"], ["door"]], major="rows", handle_at=0.0, handle_length=0.35)
    return _draw(size, p)


def microwave(rng: Rng, index: int) -> Draw:
    """A glazed door beside a control panel; stands on something."""
    size = _size(rng, (0.34, 0.44), (0.44, 0.58), (0.26, 0.34))
    p = _appliance(
        rng, [["door"], ["panel"]], column_weights=[round(float(rng.uniform(2.4, 4.0)), 2), 1.0], window=True, hinge=-1,
        handle_at=0.0, handle_length=0.55, handle_inset=0.022, shelves=0, base="feet" if index % 2 else "none",
        base_height=0.015, board=0.015, placement="object",
    )  # fmt: skip
    return _draw(size, p)


def oven(rng: Rng, index: int) -> Draw:
    """A glazed flap below a control panel; the large ones have a drawer beneath."""
    layout = [["panel"], ["flap"], ["drawer"]] if index % 2 else [["panel"], ["flap"]]
    size = _size(rng, (0.55, 0.65), (0.55, 0.68), (0.85, 0.95) if index % 2 else (0.55, 0.65))
    p = _appliance(
        rng, layout, major="rows", window=True, handle_length=0.75, base="plinth", base_height=0.03, shelves=0,
        panel_weight=round(float(rng.uniform(0.16, 0.28)), 3), drawer_weight=0.4,
    )  # fmt: skip
    return _draw(size, p)


def dishwasher(rng: Rng, index: int) -> Draw:
    """A plain flap below a narrow control panel."""
    size = _size(rng, (0.58, 0.64), (0.44, 0.62), (0.80, 0.88))
    p = _appliance(
        rng, [["panel"], ["flap"]], major="rows", handle_length=0.6, base="plinth", base_height=0.09, shelves=0,
        panel_weight=0.14, panel="flat" if index % 2 else "raised",
    )  # fmt: skip
    return _draw(size, p)
