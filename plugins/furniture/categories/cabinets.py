"""Cabinets of all sorts; within a category the samples form a continuum of proportions, fronts and handles."""

from typing import Any

from plugins.furniture.cabinet import Cabinet
from plugins.furniture.category import category
from plugins.furniture.colours import PAINTS, STONES, TILES, WOODS, Palette, pick
from plugins.furniture.finishes import shade
from plugins.furniture.handles import HANDLE_SHARES, HANDLES, STYLES
from plugins.furniture.model import Size
from plugins.furniture.recipe import Rng, Sampled, round_size, uniform

Layout = list[list[str]]  # of kinds of cells; the recipe checks them
D, P, O = ["door"], ["drawer"], ["open"]  # noqa: E741


def box_of(rng: Rng, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Size:
    """Extents sampled within ranges, metres."""
    return round_size(rng.uniform(*x), rng.uniform(*y), rng.uniform(*z))


def cabinet_of(rng: Rng, layout: Layout, tops: Palette = WOODS, **changes: Any) -> Cabinet:
    """A recipe for the layout; `changes` overrule what was sampled."""
    front = pick(rng, PAINTS, WOODS)
    body = shade(front, 0.82) if rng.random() < 0.6 else pick(rng, PAINTS, WOODS)
    handle = str(rng.choice(HANDLES, p=HANDLE_SHARES))
    recipe = Cabinet.sample_parameters(
        rng,
        0,
        layout=layout,
        handle=handle,
        body_colour=body,
        front_colour=front,
        field_colour=lambda: shade(front, rng.choice([0.72, 0.85, 1.2])),
        top_colour=lambda: pick(rng, tops),
        protrusion=0.0,
    ).change_parameters(**changes)
    return recipe.change_parameters(protrusion=STYLES[recipe.handle].protrusion)


@category(
    "bottom_cabinet",
    founders=24,
    count=56,
    names="cabinet, cupboard, storage furniture, base cabinet, lower cabinet, floor cabinet, sink cabinet",
    kin="storage",
    varied=True,
    fronts=(
        ("columns", [D]),
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*P, *D]]),
        ("columns", [[*P, *D], [*P, *D]]),
        ("columns", [[*D, *P], [*D, *P]]),
        ("columns", [D, P * 3]),
        ("columns", [P * 4, D, D]),
        ("rows", [P, D * 2]),
        ("rows", [D * 2, P]),
    ),
)
def sample_bottom_cabinet(rng: Rng, index: int) -> Sampled:
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
    size = box_of(rng, (0.42, 0.66), (width, width + 0.08), (0.62, 1.0))
    return Sampled(size, cabinet_of(rng, layout, WOODS + STONES + TILES, major=major))


@category("nightstand", founders=5, names="bedside cabinet, bedside table", like="nighttable", kin="storage")
def sample_nightstand(rng: Rng, index: int) -> Sampled:
    """Small, beside a bed: drawers, a door, an open shelf."""
    layout = [["drawer", "open"], ["drawer", "drawer"], ["drawer", "door"], ["drawer"] * 3, ["open", "drawer"]][
        index % 5
    ]
    size = box_of(rng, (0.34, 0.44), (0.38, 0.54), (0.42, 0.64))
    base = str(rng.choice(["legs", "legs", "feet", "plinth"]))
    p = cabinet_of(rng, [layout], base=base, base_height=uniform(rng, 0.08, 0.2), drawer_weight=0.6, shelves=0)
    return Sampled(size, p)


@category(
    "tv_stand",
    founders=5,
    names="television cabinet, cabinet television, tv bench, tv cabinet, tv unit",
    like="tvconsole, mediaconsole, mediaunit",
    kin="storage",
)
def sample_tv_stand(rng: Rng, index: int) -> Sampled:
    """Long, very low, with open bays for what is beneath the screen."""
    layouts = [
        [["open"], ["drawer"]], [["door"], ["open", "open"], ["door"]], [["drawer"], ["open"], ["drawer"]],
        [["open", "drawer"], ["open", "drawer"]], [["open"], ["open"], ["open"]],
    ]  # fmt: skip
    size = box_of(rng, (0.36, 0.46), (1.1, 1.9), (0.34, 0.52))
    base = str(rng.choice(["legs", "feet", "plinth", "none"]))
    p = cabinet_of(
        rng,
        layouts[index % 5],
        base=base,
        base_height=uniform(rng, 0.05, 0.14),
        drawer_weight=0.9,
        shelves=0,
        open_weight=0.7,
    )
    return Sampled(size, p)


@category(
    "wall_cabinet",
    founders=9,
    count=27,
    names="medicine cabinet, upper cabinet, cabinet upper",
    kin="storage",
    varied=True,
    fronts=(
        ("columns", [D]),
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*D, *O], [*D, *O]]),
        ("columns", [D, O]),
        ("rows", [D * 2, P * 2]),
    ),
)
def sample_wall_cabinet(rng: Rng, index: int) -> Sampled:
    """Hangs on the wall: shallow, doors, sometimes glazed, sometimes an open shelf."""
    columns = 1 + index % 3
    layout = [["door"] for _ in range(columns)]
    if rng.random() < 0.3:
        layout = [["door", "open"] for _ in range(columns)]
    width = rng.uniform(0.32, 0.45) * columns
    size = box_of(rng, (0.30, 0.42), (width, width + 0.06), (0.5, 0.85))
    changes: dict[str, Any] = {
        "base": "none",
        "top": 0.0,
        "placement": "wall",
        "handle_at": -0.8,
        "window": bool(rng.random() < 0.3),
    }
    return Sampled(size, cabinet_of(rng, layout, **changes))


@category(
    "sideboard",
    growth=(0.5, 0.0),
    founders=7,
    count=28,
    kin="storage",
    varied=True,
    fronts=(
        ("columns", [D, P * 3, D]),
        ("columns", [D, P * 2, P * 2, D]),
        ("columns", [D, D, P * 3]),
        ("columns", [P * 3, D, D]),
        ("rows", [P * 3, D * 3]),
        ("columns", [D, O, D]),
        ("columns", [D, D, D, D]),
    ),
)
def sample_sideboard(rng: Rng, index: int) -> Sampled:
    """Long and low: doors at the ends, drawers or an open bay in the middle."""
    drawers = int(rng.integers(2, 4))
    middle = [["drawer"] * drawers, ["open"], ["drawer", "open"], ["door"]][index % 4]
    layout = [["door"], middle, ["door"]] if index % 2 == 0 else [["door"], middle, middle[:], ["door"]]
    size = box_of(rng, (0.38, 0.50), (1.1, 1.8), (0.55, 0.85))
    base = str(rng.choice(["legs", "feet", "plinth"]))
    return Sampled(size, cabinet_of(rng, layout, base=base, base_height=uniform(rng, 0.1, 0.22)))


@category(
    "wardrobe",
    founders=6,
    count=26,
    names="armoire, closet",
    kin="storage",
    varied=True,
    fronts=(
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*D, *P], [*D, *P]]),
        ("columns", [D, P * 5]),
        ("rows", [D * 2, P, P]),
    ),
)
def sample_wardrobe(rng: Rng, index: int) -> Sampled:
    """Tall doors, sometimes above drawers."""
    columns = 2 + index % 2
    layout = [["door"] for _ in range(columns)]
    changes: dict[str, Any] = {"handle_at": 0.0, "handle_length": 0.12, "drawer_weight": 0.16, "shelves": 2}
    if index % 3 == 1:
        layout = [["door", "drawer"] for _ in range(columns)]
    elif index % 3 == 2:
        layout, changes["major"] = [["door"] * columns, ["drawer"]], "rows"
    size = box_of(rng, (0.5, 0.65), (0.45 * columns, 0.56 * columns), (1.75, 2.1))
    return Sampled(size, cabinet_of(rng, layout, **changes))


@category(
    "chest_of_drawers",
    growth=(0.5, 0.5),
    founders=8,
    count=32,
    names="chest drawers, drawer chest, dresser, commode",
    kin="storage",
    varied=True,
    fronts=(
        ("columns", [P * 2]),
        ("columns", [P * 3]),
        ("columns", [P * 4]),
        ("columns", [P * 6]),
        ("columns", [P * 3, P * 3]),
        ("rows", [P * 2, P, P]),
        ("rows", [P * 3, P, P, P]),
        ("columns", [P * 4, D]),
    ),
)
def sample_chest_of_drawers(rng: Rng, index: int) -> Sampled:
    """Drawers only, in one to two columns, or two small ones above wide ones."""
    rows = int(rng.integers(2, 6))
    if index % 3 == 2:
        layout, major = [["drawer", "drawer"], *[["drawer"]] * (rows - 1)], "rows"
    else:
        layout, major = [["drawer"] * rows for _ in range(1 + index % 2)], "columns"
    width = 0.45 + 0.3 * (index % 3) + rng.uniform(0, 0.25)
    height = 0.2 + 0.17 * len(layout if major == "rows" else layout[0]) + rng.uniform(0, 0.12)
    size = box_of(rng, (0.40, 0.55), (width, width + 0.05), (height, height + 0.05))
    return Sampled(size, cabinet_of(rng, layout, major=major))
