"""Bottles and vases: closed solids of revolution."""

from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.procedural.colours import GLAZES, pick
from stages.procedural.finishes import finish_of, shade
from stages.procedural.model import Draw, Model, Part, Size
from stages.procedural.shapes import hull, lathe

Rng = np.random.Generator


def turned_vessel(size: Size, p: dict[str, Any]) -> Model:
    """A closed solid of revolution (bottle, vase). Parameters: radii (shares, foot to rim), cap (share of height),
    band: two shares of the height between which it has the second colour."""
    radius, height = size[0] / 2, size[2]
    radii = np.array(p["radii"], dtype=float)
    knots = np.linspace(0, 1, len(radii))
    fine = np.linspace(0, 1, 25)
    shares = np.interp(fine, knots, radii) if p["straight"] else PchipInterpolator(knots, radii)(fine)
    shares = np.clip(shares / shares.max(), 0.08, 1.0)
    cuts = [0.0, *p["band"], 1.0]
    colours = [p["colour"], p["band_colour"], p["colour"]]
    parts = []
    for low, high, colour in zip(cuts, cuts[1:], colours, strict=False):
        levels = np.unique(np.concatenate([[low, high], fine[(fine > low) & (fine < high)]]))
        outline = [(radius * float(np.interp(a, fine, shares)), height * float(a)) for a in levels]
        mesh = lathe([(0, outline[0][1]), *outline, (0, outline[-1][1])])
        pieces = tuple(
            hull(lathe([(0, a[1]), a, b, (0, b[1])], 12).vertices)
            for a, b in zip(outline[::4], [*outline[4::4], outline[-1]], strict=False)
            if b[1] > a[1]
        )
        parts.append(Part(mesh, finish_of(colour), float(p["density"]), pieces, True))
    return Model(parts, symmetry="full", placement="object")


def draw_bottle(rng: Rng, index: int) -> Draw:
    """Straight body, shoulder, neck with a cap."""
    diameter = round(float(rng.uniform(0.06, 0.09)), 4)
    neck, shoulder = float(rng.uniform(0.28, 0.45)), float(rng.uniform(0.75, 0.95))
    colour = pick(rng, GLAZES)
    p = {
        "radii": [0.95, 1.0, 1.0, 1.0, round(shoulder, 3), round(neck, 3), round(neck, 3)],
        "straight": False,
        "band": [0.86, 0.999] if index % 2 else [0.25, 0.55],
        "colour": colour,
        "band_colour": pick(rng, GLAZES),
        "density": 900.0,
    }
    return Draw("turned_vessel", (diameter, diameter, round(diameter * float(rng.uniform(2.6, 4.0)), 4)), p)


def draw_vase(rng: Rng, index: int) -> Draw:
    """A random waist and belly."""
    radii = [round(float(r), 3) for r in rng.uniform(0.35, 1.0, 5)]
    radii[0] = max(radii[0], 0.5)
    colour = pick(rng, GLAZES)
    diameter = round(float(rng.uniform(0.10, 0.22)), 4)
    p = {
        "radii": radii, "straight": bool(index % 4 == 3), "band": [0.3, 0.5] if index % 2 else [0.9, 0.999],
        "colour": colour, "band_colour": shade(colour, 0.6), "density": 700.0,
    }  # fmt: skip
    return Draw("turned_vessel", (diameter, diameter, round(diameter * float(rng.uniform(1.2, 2.4)), 4)), p)
