"""Appliances: cabinets in metal or glass."""

from typing import Any

import numpy as np

from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.categories.cabinets import Layout, box_of, cabinet_of, cells_of
from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import APPLIANCE, METALS, pick
from roomkin.plugins.furniture.finishes import finish_of, shade
from roomkin.plugins.furniture.recipe import Rng, Sampled, uniform


def _appliance(rng: Rng, layout: Layout, **changes: Any) -> Cabinet:
    """A recipe in metal or glass, with a handle that is seen before the front."""
    front = pick(rng, APPLIANCE)
    handle = METALS[2] if np.mean(finish_of(front).color) > 0.4 else METALS[0]
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
    return cabinet_of(rng, layout, **(plain | changes))


# Rows from the top down, shares of the height, widths and heights in metres.
WIDE = (0.72, 0.94), (1.7, 1.85)
FRENCH, FRENCH_2 = ("DD P", [1.0, 0.5], *WIDE), ("DD P P", [1.0, 0.28, 0.28], *WIDE)
FRIDGES: list[tuple[str, list[float], tuple[float, float], tuple[float, float]]] = [
    FRENCH, FRENCH_2, FRENCH, ("DD DD", [1.0, 1.0], *WIDE), FRENCH, FRENCH_2, ("D", [1.0], (0.5, 0.6), (0.82, 0.9)),
    ("D D", [0.42, 1.0], (0.6, 0.75), (1.5, 1.75)), ("D D", [1.0, 0.5], (0.6, 0.75), (1.65, 1.8)),
]  # fmt: skip
FURTHER_FRIDGES = range(12, 12 + len(FRIDGES))


@category(
    "fridge",
    templates=4,
    count=21,
    further=FURTHER_FRIDGES,
    names="refrigerator",
    like="freezer, icebox",
    kin="appliance",
    carries="top",
    varied=True,
    appliance=True,
)
def sample_fridge(rng: Rng, index: int) -> Sampled:
    """One tall door, a freezer above or below, or two doors side by side; and further styles."""
    if index in FURTHER_FRIDGES:
        return _sample_further_fridge(rng, FURTHER_FRIDGES.index(index))
    layout = cells_of(("D", "DD", "D D", "DP")[index % 4])
    at = -0.5 if index % 4 == 1 else 0.2
    wide = 0.85 if len(layout) == 2 else 0.6
    size = box_of(rng, (0.62, 0.74), (wide, wide + 0.12), (1.5, 1.9))
    p = _appliance(
        rng, layout, front_thickness=0.05, base="plinth", base_height=0.05, handle_at=at, handle_length=0.3, shelves=3,
        drawer_weight=0.5, board=0.04, density=130.0,
    )  # fmt: skip
    if index % 4 == 1:  # the freezer's door is the smaller one
        p = p.change_parameters(layout=cells_of("D D"), major="rows", handle_at=0.0, handle_length=0.35)
    return Sampled(size, p)


def _sample_further_fridge(rng: Rng, number: int) -> Sampled:
    """Two doors above one or two freezer drawers (French doors), four doors, a low one for a counter, a small freezer
    above or below.

    The kinds of buying guides (kitchens.com, consumersearch.com, kitchensbycountryside.com) and of RoboCasa's fridges
    that templates lack; widths and heights of those guides.
    """
    words, shares, widths, heights = FRIDGES[number]
    layout = cells_of(words)
    size = box_of(rng, (0.62, 0.74) if len(layout[0]) == 1 else (0.65, 0.76), widths, heights)
    p = _appliance(
        rng, layout, major="rows", row_weights=shares, front_thickness=0.05, base="plinth", base_height=0.05,
        handle_length=0.3, shelves=2, board=0.04, density=130.0, handle_at=-0.4 if len(layout[0]) == 2 else 0.2,
    )  # fmt: skip
    return Sampled(size, p)


@category(
    "microwave",
    templates=4,
    count=12,
    names="microwave oven",
    kin="appliance",
    carries="top",
    places="top",
    varied=True,
    appliance=True,
)
def sample_microwave(rng: Rng, index: int) -> Sampled:
    """A glazed door beside a control panel; stands on something."""
    size = box_of(rng, (0.34, 0.44), (0.44, 0.58), (0.26, 0.34))
    p = _appliance(
        rng, cells_of("D C"), column_weights=[uniform(rng, 2.4, 4.0, digits=2), 1.0], window=True, hinge=-1,
        handle_at=0.0, handle_length=0.55, handle_inset=0.022, shelves=0, base="feet" if index % 2 else "none",
        base_height=0.015, board=0.015, placement="object",
    )  # fmt: skip
    return Sampled(size, p)


FURTHER_OVENS = range(12, 15)


@category(
    "oven",
    templates=3,
    count=15,
    further=FURTHER_OVENS,
    like="stove, cooker, hob, cooktop",
    kin="appliance",
    carries="top",
    varied=True,
    appliance=True,
)
def sample_oven(rng: Rng, index: int) -> Sampled:
    """A glazed flap below a control panel; the large ones have a drawer beneath. Further ones have two flaps."""
    if index in FURTHER_OVENS:
        return _double_oven(rng, high=index == FURTHER_OVENS[-1])
    layout = cells_of("C F P" if index % 2 else "C F")
    size = box_of(rng, (0.55, 0.65), (0.55, 0.68), (0.85, 0.95) if index % 2 else (0.55, 0.65))
    p = _appliance(
        rng, layout, major="rows", window=True, handle_length=0.75, base="plinth", base_height=0.03, shelves=0,
        panel_weight=uniform(rng, 0.16, 0.28), drawer_weight=0.4,
    )  # fmt: skip
    return Sampled(size, p)


def _double_oven(rng: Rng, high: bool) -> Sampled:
    """Two ovens one above the other: as high as a counter, or built into a wall."""
    size = box_of(rng, (0.56, 0.65), (0.56, 0.74), (1.15, 1.3) if high else (0.86, 0.94))
    p = _appliance(
        rng, cells_of("C F F"), major="rows", window=True, handle_length=0.75, base="plinth",
        base_height=0.03, shelves=0, panel_weight=uniform(rng, 0.16, 0.24),
    )  # fmt: skip
    return Sampled(size, p)


@category("dishwasher", templates=2, count=10, kin="appliance", carries="top", varied=True, appliance=True)
def sample_dishwasher(rng: Rng, index: int) -> Sampled:
    """A plain flap below a narrow control panel."""
    size = box_of(rng, (0.58, 0.64), (0.44, 0.62), (0.80, 0.88))
    p = _appliance(
        rng, cells_of("C F"), major="rows", handle_length=0.6, base="plinth", base_height=0.09, shelves=0,
        panel_weight=0.14, panel="flat" if index % 2 else "raised",
    )  # fmt: skip
    return Sampled(size, p)
