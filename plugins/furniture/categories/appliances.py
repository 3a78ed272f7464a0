"""Fridges, microwaves, ovens, dishwashers: cabinets in metal or glass; and washing machines, with a round door."""

from typing import Any, Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.categories.cabinets import Layout, box_of, cabinet_of, cells_of
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import APPLIANCE, METALS, pick
from roomkin.plugins.furniture.fields import between, in_turn, of, one_of, whole
from roomkin.plugins.furniture.finishes import DARK, finish_of, shade
from roomkin.plugins.furniture.fronts import STYLES, handle_parts
from roomkin.plugins.furniture.model import GLASS, METAL, PLASTIC, Model, Moving, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, uniform
from roomkin.plugins.furniture.shapes import box, cushion, lathe, rod, rotate, translate


def _appliance(rng: Rng, layout: Layout, **changes: Any) -> Cabinet:
    """A recipe in metal or glass, with a handle that is seen before the front."""
    front = pick(rng, APPLIANCE)
    handle = METALS[2] if np.mean(finish_of(front).color) > 0.4 else METALS[0]
    plain: dict[str, Any] = {
        "panel": "flat", "handle": str(rng.choice(["bar", "square_bar"])), "inset_front": False, "top": 0.0,
        "front_colour": front, "body_colour": shade(front, 0.85), "field_colour": front,
        "inside_colour": [0.75, 0.76, 0.78], "base_colour": [0.08, 0.08, 0.09], "handle_colour": pick(rng, [handle]),
    }  # fmt: skip
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
    "fridge", templates=4, count=21, further=FURTHER_FRIDGES, names="refrigerator", like="freezer, icebox",
    kin="appliance", carries="top", varied=True, appliance=True,
)  # fmt: skip
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
    "microwave", templates=4, count=12, names="microwave oven", kin="appliance", carries="top", places="top",
    varied=True, appliance=True,
)  # fmt: skip
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
    "oven", templates=3, count=15, further=FURTHER_OVENS, like="stove, cooker, hob, cooktop", kin="appliance",
    carries="top", varied=True, appliance=True,
)  # fmt: skip
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


MACHINE = 200.0  # kg / m^3: 65 kg in 60 x 60 x 85 cm
WHITE = "paint 0.84 0.84 0.83 0"
GAP = 0.003  # metres between the closed door and the body


class WashingMachine(Generator):
    """A front loader."""

    hinge: Literal[-1, 1] = one_of(-1, 1)  # side (low or high y) on which its door hangs
    porthole: float = between(0.27, 0.31)  # radius of the door, as a share of the width
    at: float = between(0.46, 0.54)  # height of its middle, as a share
    ring: float = between(0.68, 0.8)  # radius of its glass, as a share
    thickness: float = between(0.03, 0.04)  # of the door
    strip: float = between(0.11, 0.15)  # height of the controls, as a share
    buttons: int = whole(2, 6, ge=1, le=50)
    colour: Coating = one_of(WHITE, WHITE, "steel 0.52 0.53 0.55 0", "enamel 0.1 0.1 0.11 0")
    ring_colour: Coating = of(METALS[:3])
    handle_colour: Coating = in_turn(str(METALS[2]), str(METALS[0]))

    @property
    def fronts(self) -> tuple[int, int]:
        return 1, 0

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        out = min(STYLES["arch"].protrusion, 0.2 * x)
        thick = min(self.thickness, 0.2 * x)
        face = x - out - thick - GAP  # the body's front
        radius = min(self.porthole * size[1], 0.3 * z)
        middle = self.at * z
        parts = Parts()
        parts.add(cushion((-x, -y, 0.02), (face, y, z), 0.008), self.colour, MACHINE)
        for a in (-0.8 * x, 0.6 * face):
            for b in (-0.8 * y, 0.8 * y):
                parts.add(rod((a, b, 0), (a, b, 0.025), 0.022), DARK, PLASTIC)
        opening = rod((face - 0.01, 0, middle), (face + 0.001, 0, middle), 0.8 * self.ring * radius, segments=32)
        parts.add(opening, DARK, METAL, solid=False)
        parts += self._controls(face, y, z)
        return Model(parts, [self._door(face + GAP, thick, out, radius, middle)])

    def _controls(self, face: float, y: float, z: float) -> Parts:
        low, high = z * (1 - self.strip), 0.985 * z
        level, short = (low + high) / 2, high - low
        parts = Parts()
        parts.add(box((face, face + 0.002), (-y, y), (low - 0.006, low - 0.003)), DARK, PLASTIC, solid=False)
        drawer = box((face, face + 0.006), (-0.95 * y, -0.4 * y), (low, high))
        parts.add(drawer, shade(self.colour, 0.9), PLASTIC, solid=False)
        knob = rod((face, 0, level), (face + 0.02, 0, level), 0.36 * short)
        parts.add(knob, self.ring_colour, PLASTIC, smooth=True, solid=False)
        display = box((face, face + 0.003), (0.2 * y, 0.5 * y), (level - 0.25 * short, level + 0.25 * short))
        parts.add(display, DARK, PLASTIC, solid=False)
        for k in range(self.buttons):
            across = y * (0.58 + 0.36 * (k + 0.5) / self.buttons)
            button = rod((face, across, level), (face + 0.006, across, level), min(0.01, 0.12 * short))
            parts.add(button, self.ring_colour, PLASTIC, smooth=True, solid=False)
        return parts

    def _door(self, face: float, thick: float, out: float, radius: float, middle: float) -> Moving:
        """A ring with a bulging glass; it hangs at its front's edge, so that it turns away from the body."""
        inner = self.ring * radius
        profile = [(inner, 0.0), (radius, 0.0), (radius, 0.6 * thick), (0.95 * radius, thick), (inner, 0.8 * thick)]
        ring = lathe([*profile, profile[0]], 32)
        disc = lathe([(0, 0), *profile[1:4], (0, thick)])
        bulge = [(inner, 0.0), (inner, 0.5 * thick), (0.7 * inner, 0.8 * thick), (0.3 * inner, 0.95 * thick)]
        glass = lathe([(0, 0), *bulge, (0, thick)], 32)

        def upright(mesh: Trimesh) -> Trimesh:
            return translate(rotate(mesh, np.pi / 2, [0, 1, 0]), (face, 0, middle))

        parts = [
            Part(upright(ring), finish_of(self.ring_colour), PLASTIC, (upright(disc),), True),
            Part(upright(glass), finish_of("paint 0.06 0.07 0.09 0"), GLASS, (), True),
        ]
        at = (face + 0.97 * thick, -self.hinge * 0.86 * radius, middle)
        parts += handle_parts("arch", at, "z", min(0.13, 0.5 * radius), out, self.handle_colour)
        origin = (face + thick, self.hinge * radius, middle)
        return Moving("door_0", "door", parts, origin, (0.0, 0.0, float(self.hinge)), np.pi / 2, "arch")


DEEP = ((0.58, 0.59, 0.83), (0.66, 0.62, 0.87))
WASHING_MACHINE = Category(
    name="washing_machine", sample=sized(WashingMachine, DEEP, DEEP, ((0.42, 0.59, 0.83), (0.5, 0.62, 0.87))),
    templates=3, names="washer, clothes washer, laundry machine, front loader, tumble dryer",
    like="tumbledryer, spinner", kin="appliance", carries="top",
)  # fmt: skip
