"""Cabinets of all sorts; within a category the samples form a continuum of proportions, fronts and handles."""

from typing import Any

from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.category import Fronts, category
from roomkin.plugins.furniture.colors import PAINTS, STONES, TILES, WOODS, Palette, pick
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.fronts import HANDLE_SHARES, HANDLES, STYLES
from roomkin.plugins.furniture.model import Size
from roomkin.plugins.furniture.recipe import Rng, Sampled, round_size, uniform

Layout = list[list[str]]  # of kinds of cells; the recipe checks them
KINDS = {"D": "door", "P": "drawer", "O": "open", "F": "flap", "C": "panel"}


def cells_of(words: str) -> Layout:
    """The layout of a word per column (or row), with a letter per cell: 'PPD D' is two drawers above a door, a door."""
    return [[KINDS[letter] for letter in word] for word in words.split()]


def columns(*layouts: str) -> tuple[Fronts, ...]:
    """Fronts divided into columns, see `cells_of`."""
    return tuple(("columns", cells_of(words)) for words in layouts)


def rows(*layouts: str) -> tuple[Fronts, ...]:
    """Fronts divided into rows."""
    return tuple(("rows", cells_of(words)) for words in layouts)


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
    "bottom_cabinet", templates=24, count=56,
    names="cabinet, cupboard, storage furniture, base cabinet, lower cabinet, floor cabinet, sink cabinet",
    kin="storage", carries="top", varied=True,
    fronts=columns("D", "D D", "D D D", "D D D D", "PD", "PD PD", "DP DP", "D PPP", "PPPP D D") + rows("P DD", "DD P"),
)  # fmt: skip
def sample_bottom_cabinet(rng: Rng, index: int) -> Sampled:
    """Floor cabinet; one in five has drawers only, two have doors only, two have both."""
    kind = ["doors", "mixed", "doors", "mixed", "drawers"][index % 5]
    count, major = int(rng.integers(1, 4)), "columns"
    if kind == "doors":
        words = ["D"] * count
    elif kind == "drawers":
        words = ["P" * int(rng.integers(2, 5)) for _ in range(min(count, 2))]
    elif index % 2 and count > 1 and rng.random() < 0.6:  # a wide drawer above doors
        words, major = ["P", "D" * min(count, 2)], "rows"
    else:
        words = ["P" * int(rng.integers(1, 3)) + "D"] * count
        if count > 1 and rng.random() < 0.4:
            words[int(rng.integers(count))] = "PPP"
    layout = cells_of(" ".join(words))
    width = rng.uniform(0.38, 0.52) * max(len(line) if major == "rows" else len(layout) for line in layout)
    size = box_of(rng, (0.42, 0.66), (width, width + 0.08), (0.62, 1.0))
    return Sampled(size, cabinet_of(rng, layout, WOODS + STONES + TILES, major=major))


@category(
    "nightstand", templates=5, names="bedside cabinet, bedside table", like="nighttable", kin="storage", carries="top"
)
def sample_nightstand(rng: Rng, index: int) -> Sampled:
    """Small, beside a bed: drawers, a door, an open shelf."""
    layout = cells_of("PO PP PD PPP OP")[index % 5]
    size = box_of(rng, (0.34, 0.44), (0.38, 0.54), (0.42, 0.64))
    base = str(rng.choice(["legs", "legs", "feet", "plinth"]))
    p = cabinet_of(rng, [layout], base=base, base_height=uniform(rng, 0.08, 0.2), drawer_weight=0.6, shelves=0)
    return Sampled(size, p)


@category(
    "tv_stand", templates=5, names="television cabinet, cabinet television, tv bench, tv cabinet, tv unit",
    like="tvconsole, mediaconsole, mediaunit", kin="storage", carries="top",
)  # fmt: skip
def sample_tv_stand(rng: Rng, index: int) -> Sampled:
    """Long, very low, with open bays for what is beneath the screen."""
    layouts = ("O P", "D OO D", "P O P", "OP OP", "O O O")
    size = box_of(rng, (0.36, 0.46), (1.1, 1.9), (0.34, 0.52))
    base = str(rng.choice(["legs", "feet", "plinth", "none"]))
    p = cabinet_of(
        rng, cells_of(layouts[index % 5]), base=base, base_height=uniform(rng, 0.05, 0.14), drawer_weight=0.9,
        shelves=0, open_weight=0.7,
    )  # fmt: skip
    return Sampled(size, p)


@category(
    "wall_cabinet", templates=9, count=27, names="medicine cabinet, upper cabinet, cabinet upper", kin="storage",
    carries="top", places="wall", varied=True,
    fronts=columns("D", "D D", "D D D", "D D D D", "DO DO", "D O") + rows("DD PP"),
)  # fmt: skip
def sample_wall_cabinet(rng: Rng, index: int) -> Sampled:
    """Hangs on the wall: shallow, doors, sometimes glazed, sometimes an open shelf."""
    count = 1 + index % 3
    layout = cells_of(("DO " if rng.random() < 0.3 else "D ") * count)
    width = rng.uniform(0.32, 0.45) * count
    size = box_of(rng, (0.30, 0.42), (width, width + 0.06), (0.5, 0.85))
    window = bool(rng.random() < 0.3)
    p = cabinet_of(rng, layout, base="none", top=0.0, placement="wall", handle_at=-0.8, window=window)
    return Sampled(size, p)


@category(
    "sideboard", growth=(0.5, 0.0), templates=7, count=28, kin="storage", carries="top", varied=True,
    fronts=columns("D PPP D", "D PP PP D", "D D PPP", "PPP D D") + rows("PPP DDD") + columns("D O D", "D D D D"),
)  # fmt: skip
def sample_sideboard(rng: Rng, index: int) -> Sampled:
    """Long and low: doors at the ends, drawers or an open bay in the middle."""
    drawers = int(rng.integers(2, 4))
    middle = ("P" * drawers, "O", "PO", "D")[index % 4]
    layout = cells_of(f"D {middle} D" if index % 2 == 0 else f"D {middle} {middle} D")
    size = box_of(rng, (0.38, 0.50), (1.1, 1.8), (0.55, 0.85))
    base = str(rng.choice(["legs", "feet", "plinth"]))
    return Sampled(size, cabinet_of(rng, layout, base=base, base_height=uniform(rng, 0.1, 0.22)))


@category(
    "wardrobe", templates=6, count=26, names="armoire, closet", kin="storage", carries="top", varied=True,
    fronts=columns("D D", "D D D", "D D D D", "DP DP", "D PPPPP") + rows("DD P P"),
)  # fmt: skip
def sample_wardrobe(rng: Rng, index: int) -> Sampled:
    """Tall doors, sometimes above drawers."""
    count = 2 + index % 2
    words = ("D " * count, "DP " * count, "D" * count + " P")[index % 3]
    size = box_of(rng, (0.5, 0.65), (0.45 * count, 0.56 * count), (1.75, 2.1))
    changes: dict[str, Any] = {"major": "rows"} if index % 3 == 2 else {}
    changes |= {"handle_at": 0.0, "handle_length": 0.12, "drawer_weight": 0.16, "shelves": 2}
    return Sampled(size, cabinet_of(rng, cells_of(words), **changes))


@category(
    "chest_of_drawers", growth=(0.5, 0.5), templates=8, count=32, names="chest drawers, drawer chest, dresser, commode",
    kin="storage", carries="top", varied=True,
    fronts=columns("PP", "PPP", "PPPP", "PPPPPP", "PPP PPP") + rows("PP P P", "PPP P P P") + columns("PPPP D"),
)  # fmt: skip
def sample_chest_of_drawers(rng: Rng, index: int) -> Sampled:
    """Drawers only, in one to two columns, or two small ones above wide ones."""
    count = int(rng.integers(2, 6))
    major = "rows" if index % 3 == 2 else "columns"
    layout = cells_of("PP" + " P" * (count - 1) if major == "rows" else ("P" * count + " ") * (1 + index % 2))
    width = 0.45 + 0.3 * (index % 3) + rng.uniform(0, 0.25)
    height = 0.2 + 0.17 * count + rng.uniform(0, 0.12)
    size = box_of(rng, (0.40, 0.55), (width, width + 0.05), (height, height + 0.05))
    return Sampled(size, cabinet_of(rng, layout, major=major))
