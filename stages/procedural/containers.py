"""Bins and baskets."""

import itertools
from typing import Any

import numpy as np

from stages.procedural.colours import APPLIANCE, FABRICS, METALS, PAINTS, WICKER, pick
from stages.procedural.model import Draw, Model, Size, part
from stages.procedural.shapes import box, cushion, lathe, rod
from stages.procedural.vessels import hollow

Rng = np.random.Generator
LIGHT = 300.0  # kg / m^3: a shell with little in it
DARK = (0.04, 0.04, 0.05)


def trash_can(size: Size, p: dict[str, Any]) -> Model:
    """A bin. Parameters: style (open, dome, square), taper (foot / rim), pedal, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    if p["style"] == "square":
        parts = [part(cushion((-x, -y, 0), (x, y, 0.86 * z), 0.02), p["colour"], LIGHT)]
        parts.append(part(cushion((-x, -y, 0.875 * z), (x, y, z), 0.02), p["lid_colour"], LIGHT))
        parts.append(part(box((-0.9 * x, 0.9 * x), (-0.9 * y, 0.9 * y), (0.85 * z, 0.88 * z)), DARK, LIGHT))
        parts.append(part(box((x, x + 0.03), (-0.25 * y, 0.25 * y), (0.01, 0.03)), p["lid_colour"], LIGHT))
        return Model(parts)
    body = z if p["style"] == "open" else 0.84 * z
    radius = min(x, y)
    foot = float(p["taper"]) * radius
    parts = hollow(
        [(foot, 0.0), (0.5 * (foot + radius), 0.5 * body), (radius, body)], 0.004, p["colour"], p["colour"], 900.0
    )
    if p["style"] == "open":
        return Model(parts, symmetry="full")
    dome = [(radius * np.cos(a), body + (z - body) * np.sin(a)) for a in np.linspace(0, np.pi / 2, 6)]
    parts.append(part(lathe([(0, body), *dome[:-1], (0, z)]), p["lid_colour"], LIGHT, smooth=True))
    flap = box(
        (0.75 * radius, 0.985 * radius),
        (-0.4 * radius, 0.4 * radius),
        (body + 0.1 * (z - body), body + 0.4 * (z - body)),
    )
    parts.append(part(flap, DARK, solid=False))
    return Model(parts)


def draw_trash_can(rng: Rng, index: int) -> Draw:
    """Waste paper baskets, bins with a swinging lid, pedal bins."""
    style = ["open", "dome", "square"][index % 3]
    wide = float(rng.uniform(0.22, 0.32))
    deep = wide if style != "square" else wide * float(rng.uniform(0.8, 1.3))
    tall = {"open": (0.26, 0.4), "dome": (0.4, 0.7), "square": (0.45, 0.68)}[style]
    p = {
        "style": style,
        "taper": round(float(rng.uniform(0.7, 0.95)), 3),
        "colour": pick(rng, APPLIANCE, PAINTS, METALS),
        "lid_colour": pick(rng, METALS[1:3], PAINTS[:1]),
    }
    return Draw("trash_can", (round(wide, 3), round(deep, 3), round(float(rng.uniform(*tall)), 3)), p)


def basket(size: Size, p: dict[str, Any]) -> Model:
    """A woven basket. Parameters: style (round, square), taper (foot / rim), handle (none, arch), wall, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    body = 0.62 * z if p["handle"] == "arch" else z
    wall, taper = min(float(p["wall"]), 0.1 * min(size)), float(p["taper"])
    if p["style"] == "round":
        radius = min(x, y)
        outer = [(taper * radius, 0.0), (0.5 * (1 + taper) * radius, 0.5 * body), (radius, body)]
        parts = hollow(outer, wall, p["colour"], p["colour"], LIGHT)
    else:
        parts = [part(box((-x, x), (-y, y), (0, wall)), p["colour"], LIGHT)]
        parts += [part(box((s * x, s * (x - wall)), (-y, y), (wall, body)), p["colour"], LIGHT) for s in (-1, 1)]
        parts += [
            part(box((-x + wall, x - wall), (s * y, s * (y - wall)), (wall, body)), p["colour"], LIGHT) for s in (-1, 1)
        ]
        rim = p["rim_colour"]
        parts += [
            part(box((s * x, s * (x - 1.4 * wall)), (-y, y), (body - 0.03, body + 0.002)), rim, LIGHT, solid=False)
            for s in (-1, 1)
        ]
        parts += [
            part(box((-x, x), (s * y, s * (y - 1.4 * wall)), (body - 0.03, body + 0.002)), rim, LIGHT, solid=False)
            for s in (-1, 1)
        ]
    if p["handle"] == "arch":
        angles = np.linspace(0, np.pi, 9)
        path = [(0.0, (y - wall / 2) * np.cos(a), 0.9 * body + (z - 0.9 * body - 0.006) * np.sin(a)) for a in angles]
        parts += [part(rod(a, b, 0.007), p["rim_colour"], LIGHT, smooth=True) for a, b in itertools.pairwise(path)]
    return Model(
        parts, symmetry="half_turn" if p["style"] == "square" or p["handle"] == "arch" else "full", placement="object"
    )


def draw_basket(rng: Rng, index: int) -> Draw:
    """Round and square, with and without a handle."""
    style, handle = ["round", "square"][index % 2], "arch" if index % 4 in (1, 2) else "none"
    wide = float(rng.uniform(0.24, 0.4))
    long = wide if style == "round" else wide * float(rng.uniform(1.1, 1.5))
    tall = float(rng.uniform(0.16, 0.3)) * (1.5 if handle == "arch" else 1.0)
    p = {
        "style": style,
        "handle": handle,
        "wall": 0.01,
        "taper": round(float(rng.uniform(0.75, 0.95)), 3),
        "colour": pick(rng, WICKER),
        "rim_colour": pick(rng, WICKER, FABRICS[:3]),
    }
    return Draw("basket", (round(wide, 3), round(long, 3), round(tall, 3)), p)
