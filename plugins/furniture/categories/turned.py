"""Bottles and vases: closed solids of revolution."""

import numpy as np
from pydantic import Field
from scipy.interpolate import PchipInterpolator

from roomkin.plugins.furniture.categories.vessels import Profile
from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import GLAZES, pick
from roomkin.plugins.furniture.finishes import Surface, finish_of, shade
from roomkin.plugins.furniture.model import FILLED, Model, Part, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import hull, lathe


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
        radii=[0.95, 1.0, 1.0, 1.0, shoulder, neck, neck],
        straight=False,
        band=[0.86, 0.999] if index % 2 else [0.25, 0.55],
        colour=pick(rng, GLAZES),
        band_colour=pick(rng, GLAZES),
        density=FILLED,
    )
    return Sampled(round_size(diameter, diameter, diameter * rng.uniform(2.6, 4.0), digits=4), recipe)


@category("vase", templates=4, count=10, kin="dish, plant", places="top, floor")
def sample_vase(rng: Rng, index: int) -> Sampled:
    """A random waist and belly."""
    radii = rng.uniform(0.35, 1.0, 5).round(3).tolist()
    radii[0] = max(radii[0], 0.5)
    color = pick(rng, GLAZES)
    diameter = uniform(rng, 0.10, 0.22, 4)
    recipe = TurnedVessel(
        radii=radii,
        straight=index % 4 == 3,
        band=[0.3, 0.5] if index % 2 else [0.9, 0.999],
        colour=color,
        band_colour=shade(color, 0.6),
        density=700.0,
    )
    return Sampled(round_size(diameter, diameter, diameter * rng.uniform(1.2, 2.4), digits=4), recipe)
