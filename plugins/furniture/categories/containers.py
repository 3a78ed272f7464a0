"""Bins and baskets."""

import itertools
from typing import Literal

import numpy as np

from roomkin.plugins.furniture.categories.vessels import hollow
from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import APPLIANCE, FABRICS, METALS, PAINTS, WICKER
from roomkin.plugins.furniture.model import FILLED, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, fixed, in_turn, of, round_size
from roomkin.plugins.furniture.shapes import box, cushion, lathe, make_sides, rod

LIGHT = 300.0  # kg / m^3: a shell with little or machinery in it
DARK = (0.04, 0.04, 0.05)


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
            parts.add(box((-0.9 * x, 0.9 * x), (-0.9 * y, 0.9 * y), (0.85 * z, 0.88 * z)), DARK, LIGHT)
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
        parts.add(flap, DARK, solid=False)
        return Model(parts)


@category(
    "trash_can",
    templates=3,
    names="bin, bucket, wastebasket, garbage can, waste bin, rubbish bin",
    like="trash, trashbin, garbage, rubbish, dustbin, garbagecan",
    kin="box",
)
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
