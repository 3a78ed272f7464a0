"""What is turned on a lathe: bottles and vases, lamps, plants in pots."""

from typing import Literal

import numpy as np
from pydantic import Field
from scipy.interpolate import PchipInterpolator

from roomkin.plugins.furniture.categories.vessels import Profile
from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import CARDBOARD, GLAZES, GREENS, METALS, SHADES, pick
from roomkin.plugins.furniture.fields import between, in_turn, of, whole
from roomkin.plugins.furniture.finishes import Surface, finish_of, shade
from roomkin.plugins.furniture.model import CERAMIC, FILLED, METAL, STEEL, WOOD, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import ball, hull, lathe, rod
from roomkin.stages.contracts.library import Placement


def revolve_outline(outline: Profile, step: int, color: Surface, density: float) -> Part:
    """A solid of revolution by its outline, bottom first; to PhysX frusta of so many of its bands each."""
    mesh = lathe([(0, outline[0][1]), *outline, (0, outline[-1][1])])
    pieces = tuple(
        hull(lathe([(0, a[1]), a, b, (0, b[1])], 12).vertices)
        for a, b in zip(outline[::step], [*outline[step::step], outline[-1]], strict=False)
        if b[1] > a[1]
    )
    return Part(mesh, finish_of(color), density, pieces, True)


class TurnedVessel(Generator):
    """A closed solid of revolution (bottle, vase)."""

    radii: list[float] = Field(min_length=2)  # shares, foot to rim
    straight: bool
    band: list[float]  # two shares of the height, between which it has the second color
    colour: Coating
    band_colour: Coating
    density: float

    def build(self, size: Size) -> Model:
        radius, height = size[0] / 2, size[2]
        radii = np.array(self.radii, dtype=float)
        knots = np.linspace(0, 1, len(radii))
        fine = np.linspace(0, 1, 25)
        shares = np.interp(fine, knots, radii) if self.straight else PchipInterpolator(knots, radii)(fine)
        shares = np.clip(shares / shares.max(), 0.08, 1.0)
        cuts = [0.0, *self.band, 1.0]
        colors = [self.colour, self.band_colour, self.colour]
        parts = []
        for low, high, color in zip(cuts, cuts[1:], colors, strict=False):
            levels = np.unique(np.concatenate([[low, high], fine[(fine > low) & (fine < high)]]))
            outline = [(radius * float(np.interp(a, fine, shares)), height * float(a)) for a in levels]
            parts.append(revolve_outline(outline, 4, color, self.density))
        return Model(parts, symmetry="full", placement="object")


@category("bottle", templates=3, count=10, like="flask", kin="dish", places="top")
def sample_bottle(rng: Rng, index: int) -> Sampled:
    """Straight body, shoulder, neck with a cap."""
    diameter = uniform(rng, 0.06, 0.09, 4)
    neck, shoulder = uniform(rng, 0.28, 0.45), uniform(rng, 0.75, 0.95)
    recipe = TurnedVessel(
        radii=[0.95, 1.0, 1.0, 1.0, shoulder, neck, neck], straight=False,
        band=[0.86, 0.999] if index % 2 else [0.25, 0.55], colour=pick(rng, GLAZES), band_colour=pick(rng, GLAZES),
        density=FILLED,
    )  # fmt: skip
    return Sampled(round_size(diameter, diameter, diameter * rng.uniform(2.6, 4.0), digits=4), recipe)


@category("vase", templates=4, count=10, kin="dish, plant", places="top, floor")
def sample_vase(rng: Rng, index: int) -> Sampled:
    """A random waist and belly."""
    radii = rng.uniform(0.35, 1.0, 5).round(3).tolist()
    radii[0] = max(radii[0], 0.5)
    color = pick(rng, GLAZES)
    diameter = uniform(rng, 0.10, 0.22, 4)
    recipe = TurnedVessel(
        radii=radii, straight=index % 4 == 3, band=[0.3, 0.5] if index % 2 else [0.9, 0.999], colour=color,
        band_colour=shade(color, 0.6), density=700.0,
    )  # fmt: skip
    return Sampled(round_size(diameter, diameter, diameter * rng.uniform(1.2, 2.4), digits=4), recipe)


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
