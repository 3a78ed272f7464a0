"""Floor lamps and table lamps."""

from typing import Any

import numpy as np

from stages.procedural.colours import GLAZES, METALS, SHADES, pick
from stages.procedural.finishes import finish_of
from stages.procedural.model import CERAMIC, METAL, STEEL, WOOD, Draw, Model, Part, Size, part
from stages.procedural.shapes import hull, lathe, rod

Rng = np.random.Generator
LAMPSHADE = 40.0  # kg / m^3: mostly air


def lamp(size: Size, p: dict[str, Any]) -> Model:
    """A foot, a stem and a shade.

    Parameters: foot (disc, tripod, turned), shade (drum, cone, globe, bell), shade_height (share), foot_radius (share),
    radii (of a turned foot), placement, colours.
    """
    radius, z = min(size[0], size[1]) / 2, size[2]
    start = z * (1 - float(p["shade_height"]))
    metal, stem = p["stem_colour"], min(0.012, 0.1 * radius)
    foot = float(p["foot_radius"]) * radius
    parts: list[Part] = []
    if p["foot"] == "tripod":
        parts += [
            part(
                rod((foot * np.cos(t), foot * np.sin(t), 0), (0, 0, 0.85 * start), 0.012, 0.014),
                metal,
                WOOD,
                smooth=True,
            )
            for t in (0.0, 2.0944, 4.1888)
        ]
        stem_low = 0.82 * start
    elif p["foot"] == "turned":
        knots = np.linspace(0, 1, len(p["radii"]))
        levels = np.linspace(0, 1, 13)
        shape = np.interp(levels, knots, np.array(p["radii"], dtype=float))
        shape = shape / shape.max()
        outline = [(max(foot * float(r), stem), 0.9 * start * float(a)) for r, a in zip(shape, levels, strict=True)]
        mesh = lathe([(0, 0), *outline, (0, outline[-1][1])])
        pieces = tuple(
            hull(lathe([(0, a[1]), a, b, (0, b[1])], 12).vertices)
            for a, b in zip(outline[::3], outline[3::3], strict=False)
        )
        parts.append(Part(mesh, finish_of(p["foot_colour"]), CERAMIC, pieces, True))
        stem_low = 0.88 * start
    else:
        parts.append(
            part(
                lathe([(0, 0), (foot, 0), (foot, 0.015), (0.3 * foot, 0.03), (0, 0.03)]),
                p["foot_colour"],
                STEEL,
                smooth=True,
            )
        )
        stem_low = 0.02
    parts.append(part(rod((0, 0, stem_low), (0, 0, start + 0.3 * (z - start)), stem), metal, METAL, smooth=True))
    tip = {"drum": 0.95, "cone": 0.55, "bell": 0.35, "globe": 1.0}[p["shade"]]
    if p["shade"] == "globe":
        angles = np.linspace(-np.pi / 2, np.pi / 2, 11)
        profile = [(radius * float(np.cos(t)), (start + z) / 2 + (z - start) / 2 * float(np.sin(t))) for t in angles]
        profile[0], profile[-1] = (0.0, start), (0.0, z)
        mesh = lathe(profile)
    elif p["shade"] == "bell":
        mesh = lathe(
            [
                (0, start),
                (radius, start),
                (0.75 * radius, start + 0.35 * (z - start)),
                (0.5 * radius, start + 0.7 * (z - start)),
                (tip * radius, z),
                (0, z),
            ]
        )
    else:
        mesh = lathe([(0, start), (radius, start), (tip * radius, z), (0, z)], 32)
    parts.append(part(mesh, p["shade_colour"], LAMPSHADE, smooth=True))
    return Model(parts, symmetry="third_turn" if p["foot"] == "tripod" else "full", placement=p["placement"])


def _lamp(rng: Rng, index: int, size: Size, share: float, feet: list[str], placement: str) -> Draw:
    radii = [round(float(r), 3) for r in rng.uniform(0.3, 1.0, 5)]
    radii[0], radii[-1] = 1.0, 0.2
    p = {
        "foot": feet[index % len(feet)],
        "shade": ["cone", "drum", "globe", "bell"][index % 4],
        "shade_height": round(share, 3),
        "foot_radius": round(float(rng.uniform(0.6, 0.85)), 3),
        "radii": radii,
        "stem_colour": pick(rng, METALS),
        "foot_colour": pick(rng, METALS, GLAZES),
        "shade_colour": pick(rng, SHADES),
        "placement": placement,
    }
    return Draw("lamp", size, p)


def draw_floor_lamp(rng: Rng, index: int) -> Draw:
    """Tall: disc foot or tripod."""
    wide = round(float(rng.uniform(0.32, 0.46)), 3)
    return _lamp(
        rng,
        index,
        (wide, wide, round(float(rng.uniform(1.35, 1.7)), 3)),
        float(rng.uniform(0.14, 0.22)),
        ["disc", "tripod"],
        "floor",
    )


def draw_table_lamp(rng: Rng, index: int) -> Draw:
    """Turned ceramic foot or disc."""
    wide = round(float(rng.uniform(0.22, 0.34)), 3)
    return _lamp(
        rng,
        index,
        (wide, wide, round(float(rng.uniform(0.36, 0.58)), 3)),
        float(rng.uniform(0.35, 0.5)),
        ["turned", "disc", "turned"],
        "object",
    )
