"""Bins and baskets, suitcases and bags."""

import itertools
from typing import Literal

import numpy as np

from roomkin.plugins.furniture.categories.vessels import hollow
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import APPLIANCE, FABRICS, METALS, PAINTS, WICKER, WOODS
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of, one_of, whole
from roomkin.plugins.furniture.finishes import DARK, shade
from roomkin.plugins.furniture.model import FILLED, METAL, PLASTIC, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, lathe, make_sides, rod

LIGHT = 300.0  # kg / m^3: a shell with little or machinery in it
DARK_LID = (0.04, 0.04, 0.05)


class TrashCan(Generator):
    """A bin."""

    style: Literal["open", "dome", "square"] = in_turn("open", "dome", "square")
    taper: float = between(0.7, 0.95)  # foot / rim
    colour: Coating = of(APPLIANCE, PAINTS, METALS)
    lid_colour: Coating = of(METALS[1:3], PAINTS[:1])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        if self.style == "square":
            parts = Parts()
            parts.add(cushion((-x, -y, 0), (x, y, 0.86 * z), 0.02), self.colour, LIGHT)
            parts.add(cushion((-x, -y, 0.875 * z), (x, y, z), 0.02), self.lid_colour, LIGHT)
            parts.add(box((-0.9 * x, 0.9 * x), (-0.9 * y, 0.9 * y), (0.85 * z, 0.88 * z)), DARK_LID, LIGHT)
            parts.add(box((x, x + 0.03), (-0.25 * y, 0.25 * y), (0.01, 0.03)), self.lid_colour, LIGHT)
            return Model(parts)
        body = z if self.style == "open" else 0.84 * z
        radius = min(x, y)
        foot = self.taper * radius
        outer = [(foot, 0.0), (0.5 * (foot + radius), 0.5 * body), (radius, body)]
        parts = hollow(outer, 0.004, self.colour, self.colour, FILLED)
        if self.style == "open":
            return Model(parts, symmetry="full")
        dome = [(radius * np.cos(a), body + (z - body) * np.sin(a)) for a in np.linspace(0, np.pi / 2, 6)]
        parts.add(lathe([(0, body), *dome[:-1], (0, z)]), self.lid_colour, LIGHT, smooth=True)
        span = (body + 0.1 * (z - body), body + 0.4 * (z - body))
        flap = box((0.75 * radius, 0.985 * radius), (-0.4 * radius, 0.4 * radius), span)
        parts.add(flap, DARK_LID, solid=False)
        return Model(parts)


@category(
    "trash_can", templates=3, names="bin, bucket, wastebasket, garbage can, waste bin, rubbish bin",
    like="trash, trashbin, garbage, rubbish, dustbin, garbagecan", kin="box",
)  # fmt: skip
def sample_trash_can(rng: Rng, index: int) -> Sampled:
    """Waste paper baskets, bins with a swinging lid, pedal bins."""
    style = ["open", "dome", "square"][index % 3]
    wide = rng.uniform(0.22, 0.32)
    deep = wide if style != "square" else wide * rng.uniform(0.8, 1.3)
    tall = {"open": (0.26, 0.4), "dome": (0.4, 0.7), "square": (0.45, 0.68)}[style]
    recipe = TrashCan.sample_parameters(rng, index)
    return Sampled(round_size(wide, deep, rng.uniform(*tall)), recipe)


class Basket(Generator):
    """A woven basket."""

    style: Literal["round", "square"]
    handle: Literal["arch", "none"]
    wall: float = fixed(0.01)
    taper: float = between(0.75, 0.95)  # foot / rim
    colour: Coating = of(WICKER)
    rim_colour: Coating = of(WICKER, FABRICS[:3])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        body = 0.62 * z if self.handle == "arch" else z
        wall, taper = min(self.wall, 0.1 * min(size)), self.taper
        if self.style == "round":
            radius = min(x, y)
            outer = [(taper * radius, 0.0), (0.5 * (1 + taper) * radius, 0.5 * body), (radius, body)]
            parts = hollow(outer, wall, self.colour, self.colour, LIGHT)
        else:
            parts = Parts()
            parts.add(box((-x, x), (-y, y), (0, wall)), self.colour, LIGHT)
            for side in make_sides(x, y, (wall, body), wall):
                parts.add(side, self.colour, LIGHT)
            rim = (body - 0.03, body + 0.002)
            for s in (-1, 1):
                parts.add(box((s * x, s * (x - 1.4 * wall)), (-y, y), rim), self.rim_colour, LIGHT, solid=False)
            for s in (-1, 1):
                parts.add(box((-x, x), (s * y, s * (y - 1.4 * wall)), rim), self.rim_colour, LIGHT, solid=False)
        if self.handle == "arch":
            angles = np.linspace(0, np.pi, 9)
            reach, rise = y - wall / 2, z - 0.9 * body - 0.006
            path = [(0.0, reach * np.cos(a), 0.9 * body + rise * np.sin(a)) for a in angles]
            for a, b in itertools.pairwise(path):
                parts.add(rod(a, b, 0.007), self.rim_colour, LIGHT, smooth=True)
        turned = self.style == "round" and self.handle == "none"
        return Model(parts, symmetry="full" if turned else "half_turn", placement="object")


@category("basket", templates=4, kin="box", carries="inside", places="floor, top")
def sample_basket(rng: Rng, index: int) -> Sampled:
    """Round and square, with and without a handle."""
    style, handle = ["round", "square"][index % 2], "arch" if index % 4 in (1, 2) else "none"
    wide = rng.uniform(0.24, 0.4)
    long = wide if style == "round" else wide * rng.uniform(1.1, 1.5)
    tall = rng.uniform(0.16, 0.3) * (1.5 if handle == "arch" else 1.0)
    return Sampled(round_size(wide, long, tall), Basket.sample_parameters(rng, index, style=style, handle=handle))


PACKED = 120.0  # kg / m^3: half full
CLASP = "metal 0.62 0.48 0.22 0"


class Suitcase(Generator):
    """A case that stands on wheels, its handle drawn out or in."""

    out: bool = in_turn(True, False)
    ribs: int = whole(4, 8, ge=0, le=50)
    edge: float = between(0.02, 0.045)
    colour: Coating = of(PAINTS, METALS[:3])
    metal_colour: Coating = of(METALS[:3])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        wheel = min(0.05, 0.1 * z)
        top = 0.64 * z if self.out else 0.965 * z
        deep = 0.94 * x
        parts = Parts()
        parts.add(cushion((-deep, -y, wheel), (deep, y, top), self.edge), self.colour, PACKED)
        for k in range(self.ribs):
            middle = y * (1.5 * (k + 0.5) / self.ribs - 0.75)
            half = 0.35 * y / self.ribs
            rib = cushion((-x, middle - half, wheel + 0.1 * z), (x, middle + half, top - 0.08 * z), 0.004)
            parts.add(rib, shade(self.colour, 1.12), PACKED, solid=False)
        parts.add(box((-0.01, 0.01), (-1.002 * y, 1.002 * y), (wheel + 0.02, top - 0.01)), DARK, PACKED, solid=False)
        for a in (-0.7 * x, 0.7 * x):
            for b in (-0.8 * y, 0.8 * y):
                parts.add(box((a - 0.022, a + 0.022), (b - 0.015, b + 0.015), (0, wheel + 0.01)), DARK, PLASTIC)
        reach = 0.45 * y
        for b in (-reach, reach):
            post = box((-0.75 * deep, -0.75 * deep + 0.014), (b - 0.009, b + 0.009), (top - 0.02, z - 0.012))
            parts.add(post, self.metal_colour, METAL)
        grip = cushion((-0.8 * deep, -reach - 0.015, z - 0.026), (-0.8 * deep + 0.03, reach + 0.015, z), 0.006)
        parts.add(grip, DARK, PLASTIC)
        return Model(parts)


@category(
    "suitcase", templates=2, names="luggage, trolley case, baggage", like="briefcase, valise", kin="box", carries="top",
    places="floor, top",
)  # fmt: skip
def sample_suitcase(rng: Rng, index: int) -> Sampled:
    """For the cabin or the hold, with its handle out or in."""
    tall = rng.uniform(0.53, 0.78)
    deep, wide = tall * rng.uniform(0.36, 0.42), tall * rng.uniform(0.64, 0.7)
    size = round_size(deep, wide, tall * (1.5 if index % 2 == 0 else 1))
    return Sampled(size, Suitcase.sample_parameters(rng, index))


class Bag(Generator):
    """A backpack, a handbag or a tote that stands."""

    style: Literal["backpack", "handbag", "tote"] = in_turn("backpack", "handbag", "tote")
    narrow: float = between(0.7, 0.85)  # width of its top, as a share
    pocket: float = between(0.3, 0.5)  # height of the pocket, as a share
    colour: Coating = of(FABRICS, WOODS[3:4])
    second_colour: Coating = one_of("fabric 0.08 0.08 0.09 0", "paint 0.22 0.12 0.07 0")

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        return Model(self._backpack(x, y, z) if self.style == "backpack" else self._handbag(x, y, z))

    def _backpack(self, x: float, y: float, z: float) -> Parts:
        rear, body = -0.8 * x, 0.94 * z
        front = 0.55 * x
        levels = [(0.0, 0.86, 0.9), (0.06, 1.0, 1.0), (0.7, 0.97, 0.95)]  # height, width and depth, shares
        levels += [(0.9, self.narrow, 0.6), (1.0, 0.5 * self.narrow, 0.2)]
        points = [
            (rear + (front - rear) * deep * share, side * y * wide * cut, body * level)
            for level, wide, deep in levels
            for share, cut in ((0.0, 1.0), (0.7, 1.0), (1.0, 0.82))
            for side in (-1, 1)
        ]
        parts = Parts()
        parts.add(hull(points), self.colour, PACKED)
        pocket = cushion((0.5 * front, -0.72 * y, 0.05 * z), (x, 0.72 * y, self.pocket * z), 0.1 * x)
        parts.add(pocket, shade(self.colour, 0.8), PACKED)
        zips = box((0.9 * x, 1.005 * x), (-0.55 * y, 0.55 * y), (0.82 * self.pocket * z, 0.84 * self.pocket * z))
        parts.add(zips, self.second_colour, PACKED, solid=False)
        for side in (-0.5 * y, 0.5 * y):
            for start, end in ((0.15, 0.5), (0.5, 0.85)):
                low, high = (rear, -x + 0.006) if start < 0.3 else (-x + 0.006, rear)
                strap = beam((low, side, start * z), (high, side, end * z), 0.012)
                parts.add(strap, self.second_colour, PACKED, solid=False)
        parts += self._loop(0.5 * rear, 0.16 * y, (0.92 * z, 0.995 * z))
        return parts

    def _handbag(self, x: float, y: float, z: float) -> Parts:
        share, narrow = (0.62, self.narrow) if self.style == "handbag" else (0.7, 1.0)
        body = share * z
        top = 0.35 if self.style == "handbag" else 0.6
        foot = 1.0 if self.style == "handbag" else 0.85
        levels = ((0, 1, foot), (0.1 * body, 1, foot), (body, top, narrow))
        corners = [(a * deep, b * wide, level) for level, deep, wide in levels for a in (-x, x) for b in (-y, y)]
        parts = Parts()
        parts.add(hull(corners), self.colour, PACKED)
        if self.style == "handbag":
            flap = [(a, b * y, c * body) for a, c in ((0.5 * top * x, 1.01), (0.78 * x, 0.5)) for b in (-0.7, 0.7)]
            flap += [(a + 0.006, b, c) for a, b, c in flap]
            parts.add(hull(flap), shade(self.colour, 0.75), PACKED, solid=False)
            clasp = box((0.78 * x, 0.9 * x), (-0.05 * y, 0.05 * y), (0.5 * body, 0.6 * body))
            parts.add(clasp, CLASP, METAL, solid=False)
        for side in (-0.8 * top * x, 0.8 * top * x):
            parts += self._loop(side, 0.5 * y, (0.96 * body, z - 0.005))
        return parts

    def _loop(self, x: float, reach: float, z: tuple[float, float]) -> Parts:
        """A handle that arches between two heights."""
        arch = [(x, reach * np.cos(t), z[0] + (z[1] - z[0]) * np.sin(t)) for t in np.linspace(0, np.pi, 10)]
        parts = Parts()
        for start, end in itertools.pairwise(arch):
            parts.add(rod(start, end, 0.006), self.second_colour, PACKED, smooth=True, solid=False)
        return parts


BAG = Category(
    name="bag",
    sample=sized(
        Bag,
        ((0.18, 0.28, 0.4), (0.28, 0.34, 0.52)),
        ((0.11, 0.26, 0.3), (0.16, 0.36, 0.4)),
        ((0.12, 0.32, 0.44), (0.18, 0.42, 0.56)),
    ),
    templates=3,
    names="backpack, handbag, hand bag, rucksack, satchel, tote, tote bag, purse, knapsack, school bag, shopping bag",
    like="pouch, duffel",
    kin="box",
    places="floor, top",
)
