"""Plants in pots."""

from typing import Literal

import numpy as np

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import CARDBOARD, GLAZES, GREENS
from roomkin.plugins.furniture.model import FILLED, WOOD, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, in_turn, of, round_size, whole
from roomkin.plugins.furniture.shapes import ball, hull, lathe, rod

LEAF = 20.0  # kg / m^3: foliage is mostly air
BARK, EARTH = (0.25, 0.15, 0.08), (0.10, 0.06, 0.03)


class PlantPot(Generator):
    """A plant in a pot."""

    plant: Literal["blades", "ball", "cone", "tree"] = in_turn("blades", "ball", "cone", "tree")
    pot: float = between(0.25, 0.42)  # share of the height
    pot_radius: float = between(0.5, 0.7)  # share of the radius
    taper: float = between(0.6, 0.95)
    leaves: int = whole(8, 15, ge=1, le=100)
    pot_colour: Coating = of(GLAZES, CARDBOARD)
    leaf_colour: Coating = of(GREENS)

    def build(self, size: Size) -> Model:
        radius, z = min(size[0], size[1]) / 2, size[2]
        rim = self.pot_radius * radius
        top = self.pot * z
        foot = rim * self.taper
        outline = [(0, 0), (foot, 0), (0.96 * rim, 0.85 * top), (rim, 0.85 * top), (rim, top), (0, top)]
        parts = Parts()
        parts.add(lathe(outline), self.pot_colour, FILLED, smooth=True)
        earth = [(0, top), (0.9 * rim, top), (0.85 * rim, top + 0.005), (0, top + 0.005)]
        parts.add(lathe(earth), EARTH, FILLED, smooth=True)
        style, green = self.plant, self.leaf_colour
        if style == "blades":
            for k in range(self.leaves):
                t, out = 2 * np.pi * k / self.leaves, radius * (0.96 if k % 2 else 0.55)
                tip = z if k % 2 == 0 else top + 0.72 * (z - top)
                c, s, w = np.cos(t), np.sin(t), 0.10 * radius
                leaf = []  # from the earth over its widest place to the tip
                for away, half, level in ((0.1 * radius, w, top), (0.45 * out, 1.3 * w, top + 0.6 * (tip - top))):
                    leaf.append((away * c - half * s, away * s + half * c, level))
                    leaf.append((away * c + half * s, away * s - half * c, level))
                leaf.append((0.5 * out * c, 0.5 * out * s, top + 0.52 * (tip - top)))
                parts.add(hull([*leaf, (out * c, out * s, tip)]), green, LEAF)
        elif style == "cone":
            for k, share in enumerate((1.0, 0.75, 0.5)):
                low = top + (0.08 + 0.28 * k) * (z - top)
                high = z if k == 2 else low + 0.45 * (z - top)
                whorl = lathe([(0, low), (share * radius, low + 0.02 * (z - top)), (0, high)])
                parts.add(whorl, green, LEAF, smooth=True)
            parts.add(rod((0, 0, top), (0, 0, top + 0.15 * (z - top)), 0.08 * radius), BARK, WOOD, smooth=True)
        else:
            trunk = 0.45 if style == "tree" else 0.0
            low = top + trunk * (z - top) - (0.0 if trunk else 0.03 * z)
            if trunk:
                parts.add(rod((0, 0, top), (0, 0, low + 0.1 * (z - low)), 0.07 * radius), BARK, WOOD, smooth=True)
            parts.add(ball(radius, low, z, 8, segments=14), green, LEAF)
        return Model(parts, symmetry="full")


@category("plant_pot", templates=4, count=10, names="flower pot, plant", kin="plant", places="floor, top")
def sample_plant_pot(rng: Rng, index: int) -> Sampled:
    """From a desk plant to a small tree."""
    wide = rng.uniform(0.25, 0.5)
    recipe = PlantPot.sample_parameters(rng, index)
    return Sampled(round_size(wide, wide, wide * rng.uniform(1.4, 2.3)), recipe)
