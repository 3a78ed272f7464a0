"""Bowls, mugs, plates and pots: open vessels, hollow to PhysX as well."""

import itertools

import numpy as np

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import GLAZES, METALS, pick
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of, zero_or
from roomkin.plugins.furniture.finishes import Surface, finish_of
from roomkin.plugins.furniture.model import CERAMIC, METAL, PLASTIC, Model, Part, Parts, Size, move_model, part
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import cushion, hull, lathe, rod, shell_pieces

Profile = list[tuple[float, float]]  # (radius, z), bottom first


def hollow(outer: Profile, wall: float, color: Surface, inside: Surface, density: float) -> Parts:
    """An open vessel: the outer profile from its foot to its rim, a wall inside it, a floor one wall thick."""
    inner = [(max(r - wall, 0.2 * r), max(z, wall)) for r, z in outer]
    floor = inner[0][0]
    middle = [(0.5 * (a + c), 0.5 * (b + d)) for (a, b), (c, d) in zip(outer, inner, strict=True)]
    middle[0], middle[-1] = (0.5 * floor, 0.5 * wall), (inner[-1][0], outer[-1][1])
    body = lathe([(0, 0), *outer, *inner[::-1], (0, wall)])
    coarse = sorted({0, len(outer) // 2, len(outer) - 1})
    pieces = shell_pieces([outer[k] for k in coarse], [inner[k] for k in coarse])
    base = lathe([(0, 0), (outer[0][0], 0), (floor, wall), (0, wall)], 16)
    lining = lathe([(0, wall), *[(0.985 * r, z + 2e-4) for r, z in inner], *[(0.95 * r, z) for r, z in inner[::-1]]])
    parts = Parts([Part(body, finish_of(color), density, (base, *pieces), True)])
    if inside != color:
        parts.add(lining, inside, 1.0, smooth=True, solid=False)
    return parts


class Bowl(Generator):
    """A bowl on a foot ring."""

    foot: float = between(0.3, 0.6)  # share of the radius
    bulge: float  # exponent of the side
    wall: float = fixed(0.005)
    colour: Coating
    inside: Coating

    def build(self, size: Size) -> Model:
        radius, height = size[0] / 2, size[2]
        t = np.linspace(0, 1, 8)
        foot = self.foot
        outer = [(radius * (foot + (1 - foot) * a**self.bulge), height * a) for a in t]
        wall = min(self.wall, 0.15 * min(radius, height))
        return Model(hollow(outer, wall, self.colour, self.inside, CERAMIC), symmetry="full", placement="object")


@category("bowl", templates=5, count=10, kin="dish", carries="inside", places="top")
def sample_bowl(rng: Rng, index: int) -> Sampled:
    """Shallow and wide to deep and steep."""
    radius = rng.uniform(0.06, 0.11)
    size = round_size(2 * radius, 2 * radius, radius * rng.uniform(0.55, 1.15), digits=4)
    color = pick(rng, GLAZES)
    inside = color if rng.random() < 0.5 else pick(rng, GLAZES)
    bulge = uniform(rng, 0.3, 0.95)
    return Sampled(size, Bowl.sample_parameters(rng, index, bulge=bulge, colour=color, inside=inside))


class Mug(Generator):
    """A cup with its handle towards +y."""

    taper: float = between(0.65, 1.05)  # foot / rim
    belly: float = zero_or(0.08, 0.3)
    handle: float = between(0.45, 0.8)  # share of the height
    wall: float = fixed(0.004)
    angular: bool = in_turn(False, False, True)
    colour: Coating
    inside: Coating

    def build(self, size: Size) -> Model:
        radius, height = size[0] / 2, size[2]
        reach = size[1] - 2 * radius if size[1] > 2.15 * radius else 0.6 * radius
        t = np.linspace(0, 1, 7)
        taper, belly = self.taper, self.belly
        shape = (taper + (1 - taper) * t) * (1 + belly * np.sin(np.pi * t))
        outer = [(radius * r / shape.max(), height * a) for r, a in zip(shape, t, strict=True)]
        parts = hollow(outer, min(self.wall, 0.2 * min(radius, height)), self.colour, self.inside, CERAMIC)
        parts += ear(radius, reach, self.handle * height, 0.52 * height, self.colour, self.angular)
        return Model(move_model(Model(parts), (0.0, -reach / 2, 0.0)).base, placement="object")


def ear(radius: float, reach: float, height: float, z: float, color: Surface, angular: bool) -> list[Part]:
    """A bent handle of short convex pieces in the y-z plane."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, (3 if angular else 8) + 1)
    thick = min(0.009, 0.3 * reach, 0.2 * height)
    out, half = reach - thick / 2, (height - thick) / 2
    path = np.column_stack([radius * 0.93 + (out + 0.07 * radius) * np.cos(angles), z + half * np.sin(angles)])
    pieces = []
    sides = (-thick / 2, thick / 2)
    for both in itertools.pairwise(path):
        ends = [(y + dy, w + dz) for y, w in both for dy in sides for dz in sides]
        pieces.append(hull([(x, y, w) for y, w in ends for x in (-0.6 * thick, 0.6 * thick)]))
    return [part(mesh, color, CERAMIC, smooth=not angular) for mesh in pieces]


@category("mug", templates=5, count=10, names="cup", like="beaker", kin="dish", places="top")
def sample_mug(rng: Rng, index: int) -> Sampled:
    """Straight, tapered or bellied, round or angular handle."""
    radius, height = rng.uniform(0.035, 0.05), rng.uniform(0.07, 0.13)
    size = round_size(2 * radius, 2 * radius + rng.uniform(0.025, 0.04), height, digits=4)
    color = pick(rng, GLAZES)

    def pick_inside() -> str:
        return pick(rng, GLAZES[:1]) if rng.random() < 0.6 else color

    return Sampled(size, Mug.sample_parameters(rng, index, colour=color, inside=pick_inside))


class Plate(Generator):
    """A plate: flat well and rising rim."""

    well: float = between(0.5, 0.75)  # share of the radius
    colour: Coating
    inside: Coating = of(GLAZES)

    def build(self, size: Size) -> Model:
        radius, height = size[0] / 2, size[2]
        well = self.well * radius
        wall = min(0.005, 0.4 * height)
        outer = [(well, 0.0), (well + 0.5 * (radius - well), 0.55 * height), (radius, height)]
        return Model(hollow(outer, wall, self.colour, self.inside, CERAMIC), symmetry="full", placement="object")


@category("plate", templates=3, count=10, kin="dish", carries="inside", places="top")
def sample_plate(rng: Rng, index: int) -> Sampled:
    """Small to large, flat to deep."""
    diameter = uniform(rng, 0.18, 0.28, 4)
    recipe = Plate.sample_parameters(rng, index, colour=pick(rng, GLAZES))
    return Sampled((diameter, diameter, uniform(rng, 0.018, 0.045, 4)), recipe)


class CookingPot(Generator):
    """A pot with two grips (towards +y and -y) and perhaps a lid."""

    lid: bool
    colour: Coating
    lid_colour: Coating
    grip_colour: Coating = of(METALS[2:])

    def build(self, size: Size) -> Model:
        radius = size[0] / 2
        reach = max((size[1] - size[0]) / 2, 0.012)
        body = size[2] * (0.72 if self.lid else 1.0)
        wall = min(0.004, 0.1 * min(radius, body))
        outer = [(0.94 * radius, 0.0), (radius, 0.12 * body), (radius, body)]
        parts = hollow(outer, wall, self.colour, self.colour, METAL)
        for side in (-1.0, 1.0):
            low = (-0.35 * radius, side * 0.9 * radius, 0.70 * body)
            high = (0.35 * radius, side * (radius + reach), 0.70 * body + min(0.014, 0.2 * body))
            parts.add(cushion(low, high, 0.004), self.grip_colour, PLASTIC)
        if self.lid:
            rise = 0.5 * (size[2] - body)
            dome = [(radius, body), (0.96 * radius, body + 0.3 * rise), (0.3 * radius, body + rise)]
            parts.add(lathe([(0, body), *dome, (0, body + rise)]), self.lid_colour, METAL, smooth=True)
            knob = rod((0, 0, body + 0.8 * rise), (0, 0, size[2]), 0.1 * radius, 0.17 * radius)
            parts.add(knob, self.grip_colour, PLASTIC, smooth=True)
        return Model(parts, symmetry="half_turn", placement="object")


@category(
    "cooking_pot", templates=3, count=10, names="kitchen pot, pot", kin="dish, plant", carries="inside", places="top"
)
def sample_cooking_pot(rng: Rng, index: int) -> Sampled:
    """Low casserole to tall stock pot."""
    diameter, lid = uniform(rng, 0.18, 0.30, 4), index % 2 == 0
    height = diameter * rng.uniform(0.45, 0.9) * (1.3 if lid else 1.0)
    color = pick(rng, METALS, GLAZES)

    def pick_lid_color() -> str:
        return color if index % 3 else pick(rng, METALS)

    recipe = CookingPot.sample_parameters(rng, index, lid=lid, colour=color, lid_colour=pick_lid_color)
    return Sampled(round_size(diameter, diameter + 0.07, height, digits=4), recipe)
