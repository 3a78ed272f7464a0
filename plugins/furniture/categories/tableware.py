"""Cans, wine glasses and cutlery."""

import itertools
from typing import Literal

import numpy as np

from roomkin.plugins.furniture.categories.vessels import hollow
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import GLAZES, METALS, WOODS
from roomkin.plugins.furniture.fields import between, in_turn, of, one_of
from roomkin.plugins.furniture.model import FILLED, GLASS, STEEL, Model, Part, Parts, Size, move_model, part
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import hull, lathe, rod

TIN = "metal 0.6 0.61 0.63 0"
CLEAR = "paint 0.82 0.86 0.87 0"  # glass is opaque here


class Can(Generator):
    """A tin: a drinks can with necks, a food can with rims."""

    style: Literal["drink", "food"] = in_turn("drink", "food")
    low: float = between(0.06, 0.14)  # where its label begins, as a share of the height
    colour: Coating = of(GLAZES)
    band_colour: Coating = of(GLAZES[:5])

    def build(self, size: Size) -> Model:
        radius, z = size[0] / 2, size[2]
        if self.style == "drink":
            side = [(0.8, 0.0), (1.0, 0.06), (1.0, 0.9), (0.82, 0.985), (0.82, 1.0)]
        else:
            side = [(1.0, 0.0), (1.0, 0.025), (0.97, 0.03), (0.97, 0.97), (1.0, 0.975), (1.0, 1.0)]
        parts = Parts()
        parts.add(lathe([(0, 0), *((radius * r, z * h) for r, h in side), (0, z)], 32), TIN, FILLED, smooth=True)
        high = 0.9 if self.style == "drink" else 1 - self.low
        wide = 1.004 if self.style == "drink" else 0.985
        label, band = (self.low, high, wide, self.colour), (0.4, 0.62, wide + 0.006, self.band_colour)
        for start, end, share, color in (label, band):
            levels = [(0, start * z), (share * radius, start * z), (share * radius, end * z), (0, end * z)]
            parts.add(lathe(levels, 32), color, smooth=True, solid=False)
        return Model(parts, symmetry="full", placement="object")


@category(
    "can", templates=3, names="tin, tin can, soda can, soup can, drink can, beer can, tuna can", kin="dish",
    places="top",
)  # fmt: skip
def sample_can(rng: Rng, index: int) -> Sampled:
    """Of drinks, of soup, flat ones of fish."""
    if index % 2 == 0:
        size = (0.066, 0.066, uniform(rng, 0.112, 0.168, 4))
    else:
        wide = uniform(rng, 0.07, 0.1, 4)
        size = round_size(wide, wide, wide * (0.45 if index % 4 == 3 else rng.uniform(1.1, 1.5)), digits=4)
    return Sampled(size, Can.sample_parameters(rng, index))


class WineGlass(Generator):
    """A bowl on a stem and a foot, hollow."""

    style: Literal["wine", "flute", "coupe"] = in_turn("wine", "flute", "coupe")
    stem: float  # share of the height
    foot: float = between(0.75, 0.95)  # share of the radius
    colour: Coating = one_of(CLEAR, CLEAR, "paint 0.7 0.78 0.8 0", "paint 0.42 0.55 0.5 0")

    def build(self, size: Size) -> Model:
        radius, z = size[0] / 2, size[2]
        stem = self.stem * z
        shape = {
            "wine": [(0.3, 0.0), (0.8, 0.18), (1.0, 0.45), (0.94, 0.75), (0.78, 1.0)],
            "flute": [(0.3, 0.0), (0.75, 0.2), (1.0, 0.55), (0.96, 0.8), (0.86, 1.0)],
            "coupe": [(0.2, 0.0), (0.65, 0.3), (0.9, 0.65), (0.98, 0.85), (1.0, 1.0)],
        }[self.style]
        outer = [(radius * r, (z - stem) * h) for r, h in shape]
        wall = min(0.002, 0.08 * min(radius, z - stem))
        bowl = hollow(outer, wall, self.colour, self.colour, GLASS)
        parts = Parts(move_model(Model(bowl), (0.0, 0.0, stem)).base)
        thin = min(0.004, 0.12 * radius)
        parts.add(rod((0, 0, 0.01 * z), (0, 0, stem + wall), thin), self.colour, GLASS, smooth=True)
        foot = self.foot * radius if self.style != "flute" else 1.05 * radius
        base = [(0, 0), (foot, 0), (foot, 0.012 * z), (thin, 0.04 * z), (0, 0.04 * z)]
        parts.add(lathe(base, 32), self.colour, GLASS, smooth=True)
        return Model(parts, symmetry="full", placement="object")


@category(
    "wine_glass", templates=3, names="wineglass, goblet, champagne glass, champagne flute, stemware, cocktail glass",
    like="chalice, flute", kin="dish", places="top",
)  # fmt: skip
def sample_wine_glass(rng: Rng, index: int) -> Sampled:
    """Of wine, flutes, flat ones."""
    wide = [(0.07, 0.095), (0.052, 0.064), (0.085, 0.105)][index % 3]
    tall = [(0.17, 0.23), (0.2, 0.25), (0.13, 0.17)][index % 3]
    diameter = uniform(rng, *wide, digits=4)
    recipe = WineGlass.sample_parameters(rng, index, stem=uniform(rng, 0.36, 0.5))
    return Sampled(round_size(diameter, diameter, rng.uniform(*tall), digits=4), recipe)


Knot = tuple[float, float, float]  # along, half of the width, height of the underside


class Cutlery(Generator):
    """A fork, a knife or a spoon that lies, its grip towards +x."""

    style: Literal["fork", "knife", "spoon"] = in_turn("fork", "knife", "spoon")
    grip: float = between(0.5, 0.6)  # share of the length
    colour: Coating = of(METALS[:2], METALS[3:4])
    wooden: bool = in_turn(False, False, False, True)  # its grip
    wood: Coating = of(WOODS[1:4])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        thick = min(0.003, 0.35 * z)
        neck = x - self.grip * size[0]
        parts = Parts()
        bent = 0.0 if self.style == "knife" else 0.35 * (z - thick)
        grip = [(x, 0.42 * y, 0.0), (0.5 * (x + neck), 0.36 * y, 0.0), (neck, 0.2 * y, bent)]
        held = self.wood if self.wooden else self.colour
        parts += _strip(grip, z if self.style == "knife" else 2 * thick if self.wooden else thick, held)
        if self.style == "knife":
            blade = [(neck, 0.3 * y, 0.3 * z), (-0.5 * x, y, 0.0), (-0.8 * x, y, 0.0), (-x, 0.2 * y, 0.0)]
            parts += _strip(blade, thick, self.colour)
        elif self.style == "spoon":
            middle, long = -0.68 * x, 0.32 * x
            angles = np.linspace(0, 2 * np.pi, 20, endpoint=False)
            rim = [(middle + long * np.cos(t), y * np.sin(t), z) for t in angles]
            base = [(middle + 0.5 * long * np.cos(t), 0.5 * y * np.sin(t), 0.0) for t in angles]
            stem = [(neck, 0.2 * y, bent), (middle + 0.9 * long, 0.25 * y, z - thick)]
            parts += _strip(stem, thick, self.colour)
            parts.add(hull([*rim, *base]), self.colour, STEEL, smooth=True)
            dip = [(middle + 0.85 * (a - middle), 0.85 * b, z + 1e-4) for a, b, _ in rim]
            parts.add(hull([*dip, *((a, b, z - 1e-4) for a, b, _ in dip)]), "metal 0.36 0.37 0.39 0", solid=False)
        else:
            root = [(neck, 0.2 * y, bent), (-0.3 * x, 0.6 * y, 0.2 * (z - thick)), (-0.5 * x, y, 0.0)]
            parts += _strip(root, thick, self.colour)
            for middle in np.linspace(-0.85, 0.85, 4) * y:
                tine = [(-0.49 * x, 0.15 * y, 0.0), (-0.75 * x, 0.13 * y, 0.0), (-x, 0.07 * y, z - thick)]
                parts += move_model(Model(_strip(tine, thick, self.colour)), (0.0, float(middle), 0.0)).base
        return Model(parts, placement="object")


def _strip(knots: list[Knot], thick: float, color: str | list[float]) -> list[Part]:
    """Sheet metal along x through knots, of one thickness."""
    ends = [[(a, side * half, low + up) for side in (-1, 1) for up in (0, thick)] for a, half, low in knots]
    return [part(hull([*one, *other]), color, STEEL) for one, other in itertools.pairwise(ends)]


CUTLERY = Category(
    name="cutlery",
    sample=sized(
        Cutlery,
        ((0.17, 0.024, 0.012), (0.23, 0.03, 0.018)),
        ((0.17, 0.018, 0.007), (0.23, 0.026, 0.01)),
        ((0.17, 0.036, 0.012), (0.23, 0.046, 0.018)),
        digits=4,
    ),
    templates=3,
    names="fork, knife, spoon, silverware, flatware, teaspoon, tablespoon",
    like="utensil, ladle, spatula, whisk",
    kin="dish",
    places="top",
)
