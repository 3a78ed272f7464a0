"""Floor lamps and table lamps."""

from typing import Literal

import numpy as np

from roomkin.plugins.furniture.categories.turned import revolve_outline
from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import GLAZES, METALS, SHADES
from roomkin.plugins.furniture.model import CERAMIC, METAL, STEEL, WOOD, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, in_turn, of, uniform
from roomkin.plugins.furniture.shapes import ball, lathe, rod
from roomkin.stages.contracts.library import Placement

LAMPSHADE = 40.0  # kg / m^3: mostly air


class Lamp(Generator):
    """A foot, a stem and a shade."""

    foot: Literal["disc", "tripod", "turned"]
    shade: Literal["cone", "drum", "globe", "bell"] = in_turn("cone", "drum", "globe", "bell")
    shade_height: float  # share of the height
    foot_radius: float = between(0.6, 0.85)  # share of the radius
    radii: list[float]  # of a turned foot, shares
    stem_colour: Coating = of(METALS)
    foot_colour: Coating = of(METALS, GLAZES)
    shade_colour: Coating = of(SHADES)
    placement: Placement

    def build(self, size: Size) -> Model:
        radius, z = min(size[0], size[1]) / 2, size[2]
        start = z * (1 - self.shade_height)
        metal, stem = self.stem_colour, min(0.012, 0.1 * radius)
        foot = self.foot_radius * radius
        parts = Parts()
        if self.foot == "tripod":
            for t in (0.0, 2.0944, 4.1888):
                leg = rod((foot * np.cos(t), foot * np.sin(t), 0), (0, 0, 0.85 * start), 0.012, 0.014)
                parts.add(leg, metal, WOOD, smooth=True)
            stem_low = 0.82 * start
        elif self.foot == "turned":
            knots = np.linspace(0, 1, len(self.radii))
            levels = np.linspace(0, 1, 13)
            shape = np.interp(levels, knots, np.array(self.radii, dtype=float))
            shape = shape / shape.max()
            outline = [(max(foot * float(r), stem), 0.9 * start * float(a)) for r, a in zip(shape, levels, strict=True)]
            parts.append(revolve_outline(outline, 3, self.foot_colour, CERAMIC))
            stem_low = 0.88 * start
        else:
            disc = lathe([(0, 0), (foot, 0), (foot, 0.015), (0.3 * foot, 0.03), (0, 0.03)])
            parts.add(disc, self.foot_colour, STEEL, smooth=True)
            stem_low = 0.02
        parts.add(rod((0, 0, stem_low), (0, 0, start + 0.3 * (z - start)), stem), metal, METAL, smooth=True)
        tip = {"drum": 0.95, "cone": 0.55, "bell": 0.35, "globe": 1.0}[self.shade]
        if self.shade == "globe":
            mesh = ball(radius, start, z, 10)
        elif self.shade == "bell":
            waist = [(0.75 * radius, start + 0.35 * (z - start)), (0.5 * radius, start + 0.7 * (z - start))]
            mesh = lathe([(0, start), (radius, start), *waist, (tip * radius, z), (0, z)])
        else:
            mesh = lathe([(0, start), (radius, start), (tip * radius, z), (0, z)], 32)
        parts.add(mesh, self.shade_colour, LAMPSHADE, smooth=True)
        return Model(parts, symmetry="third_turn" if self.foot == "tripod" else "full", placement=self.placement)


def _sample_lamp(rng: Rng, index: int, share: float, feet: list[str], placement: Placement) -> Lamp:
    radii = [1.0, *rng.uniform(0.3, 1.0, 5).round(3).tolist()[1:-1], 0.2]
    foot = feet[index % len(feet)]
    return Lamp.sample_parameters(rng, index, foot=foot, shade_height=share, radii=radii, placement=placement)


@category("floor_lamp", templates=3, count=10, names="standing lamp", kin="lamp")
def sample_floor_lamp(rng: Rng, index: int) -> Sampled:
    """Tall: disc foot or tripod."""
    wide, tall = uniform(rng, 0.32, 0.46), uniform(rng, 1.35, 1.7)
    share = uniform(rng, 0.14, 0.22)
    return Sampled((wide, wide, tall), _sample_lamp(rng, index, share, ["disc", "tripod"], "floor"))


@category("table_lamp", templates=4, count=10, names="lamp", kin="lamp", places="top")
def sample_table_lamp(rng: Rng, index: int) -> Sampled:
    """Turned ceramic foot or disc."""
    wide, tall = uniform(rng, 0.22, 0.34), uniform(rng, 0.36, 0.58)
    share = uniform(rng, 0.35, 0.5)
    return Sampled((wide, wide, tall), _sample_lamp(rng, index, share, ["turned", "disc", "turned"], "object"))
