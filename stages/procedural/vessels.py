"""Bowls, mugs, plates and pots: open vessels, hollow to PhysX as well."""

import itertools
from typing import Any

import numpy as np

from stages.procedural.colours import GLAZES, METALS, pick
from stages.procedural.finishes import finish_of
from stages.procedural.model import CERAMIC, METAL, PLASTIC, Draw, Model, Part, Size, moved, part
from stages.procedural.shapes import cushion, hull, lathe, rod, shell_pieces

Rng = np.random.Generator
Profile = list[tuple[float, float]]  # (radius, z), bottom first


def hollow(outer: Profile, wall: float, colour: list[float], inside: list[float], density: float) -> list[Part]:
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
    parts = [Part(body, finish_of(colour), density, (base, *pieces), True)]
    return parts if inside == colour else [*parts, part(lining, inside, 1.0, smooth=True, solid=False)]


def bowl(size: Size, p: dict[str, Any]) -> Model:
    """A bowl on a foot ring. Parameters: foot (share of the radius), bulge (exponent of the side), wall, colours."""
    radius, height = size[0] / 2, size[2]
    t = np.linspace(0, 1, 8)
    foot = float(p["foot"])
    outer = [(radius * (foot + (1 - foot) * a ** float(p["bulge"])), height * a) for a in t]
    wall = min(float(p["wall"]), 0.15 * min(radius, height))
    return Model(hollow(outer, wall, p["colour"], p["inside"], CERAMIC), symmetry="full", placement="object")


def draw_bowl(rng: Rng, index: int) -> Draw:
    """Shallow and wide to deep and steep."""
    radius = float(rng.uniform(0.06, 0.11))
    size = (round(2 * radius, 4), round(2 * radius, 4), round(radius * float(rng.uniform(0.55, 1.15)), 4))
    colour = pick(rng, GLAZES)
    inside = colour if rng.random() < 0.5 else pick(rng, GLAZES)
    bulge = round(float(rng.uniform(0.3, 0.95)), 3)
    return Draw(
        "bowl",
        size,
        {
            "foot": round(float(rng.uniform(0.3, 0.6)), 3),
            "bulge": bulge,
            "wall": 0.005,
            "colour": colour,
            "inside": inside,
        },
    )


def mug(size: Size, p: dict[str, Any]) -> Model:
    """A cup with its handle towards +y. Parameters: taper (foot / rim), belly, handle (share of the height), wall."""
    radius, height = size[0] / 2, size[2]
    reach = size[1] - 2 * radius if size[1] > 2.15 * radius else 0.6 * radius
    t = np.linspace(0, 1, 7)
    taper, belly = float(p["taper"]), float(p["belly"])
    shape = (taper + (1 - taper) * t) * (1 + belly * np.sin(np.pi * t))
    outer = [(radius * r / shape.max(), height * a) for r, a in zip(shape, t, strict=True)]
    wall = min(float(p["wall"]), 0.2 * min(radius, height))
    parts = hollow(outer, wall, p["colour"], p["inside"], CERAMIC)
    parts += ear(radius, reach, float(p["handle"]) * height, 0.52 * height, p["colour"], bool(p["angular"]))
    parts = moved(Model(parts), (0.0, -reach / 2, 0.0)).base
    return Model(parts, placement="object")


def ear(radius: float, reach: float, height: float, z: float, colour: list[float], angular: bool) -> list[Part]:
    """A bent handle of short convex pieces in the y-z plane."""
    count = 3 if angular else 8
    angles = np.linspace(-np.pi / 2, np.pi / 2, count + 1)
    thick = min(0.009, 0.3 * reach, 0.2 * height)
    out, half = reach - thick / 2, (height - thick) / 2
    path = np.column_stack([radius * 0.93 + (out + 0.07 * radius) * np.cos(angles), z + half * np.sin(angles)])
    pieces = []
    for (ya, za), (yb, zb) in itertools.pairwise(path):
        ends = [
            (y + dy, w + dz)
            for y, w in ((ya, za), (yb, zb))
            for dy in (-thick / 2, thick / 2)
            for dz in (-thick / 2, thick / 2)
        ]
        pieces.append(hull([(x, y, w) for y, w in ends for x in (-0.6 * thick, 0.6 * thick)]))
    return [part(mesh, colour, CERAMIC, smooth=not angular) for mesh in pieces]


def draw_mug(rng: Rng, index: int) -> Draw:
    """Straight, tapered or bellied, round or angular handle."""
    radius, height = float(rng.uniform(0.035, 0.05)), float(rng.uniform(0.07, 0.13))
    size = (round(2 * radius, 4), round(2 * radius + float(rng.uniform(0.025, 0.04)), 4), round(height, 4))
    colour = pick(rng, GLAZES)
    p = {
        "taper": round(float(rng.uniform(0.65, 1.05)), 3),
        "belly": round(float(rng.choice([0.0, rng.uniform(0.08, 0.3)])), 3),
        "handle": round(float(rng.uniform(0.45, 0.8)), 3),
        "wall": 0.004,
        "angular": bool(index % 3 == 2),
        "colour": colour,
        "inside": pick(rng, GLAZES[:1]) if rng.random() < 0.6 else colour,
    }
    return Draw("mug", size, p)


def plate(size: Size, p: dict[str, Any]) -> Model:
    """A plate: flat well and rising rim. Parameters: well (share of the radius), wall, colours."""
    radius, height = size[0] / 2, size[2]
    well = float(p["well"]) * radius
    wall = min(0.005, 0.4 * height)
    outer = [(well, 0.0), (well + 0.5 * (radius - well), 0.55 * height), (radius, height)]
    return Model(hollow(outer, wall, p["colour"], p["inside"], CERAMIC), symmetry="full", placement="object")


def draw_plate(rng: Rng, index: int) -> Draw:
    """Small to large, flat to deep."""
    diameter = round(float(rng.uniform(0.18, 0.28)), 4)
    colour = pick(rng, GLAZES)
    p = {"well": round(float(rng.uniform(0.5, 0.75)), 3), "colour": colour, "inside": pick(rng, GLAZES)}
    return Draw("plate", (diameter, diameter, round(float(rng.uniform(0.018, 0.045)), 4)), p)


def cooking_pot(size: Size, p: dict[str, Any]) -> Model:
    """A pot with two grips (towards +y and -y) and perhaps a lid. Parameters: lid, grip, colours."""
    radius = size[0] / 2
    reach = max((size[1] - size[0]) / 2, 0.012)
    body = size[2] * (0.72 if p["lid"] else 1.0)
    wall = min(0.004, 0.1 * min(radius, body))
    parts = hollow([(0.94 * radius, 0.0), (radius, 0.12 * body), (radius, body)], wall, p["colour"], p["colour"], METAL)
    for side in (-1.0, 1.0):
        low = np.array([-0.35 * radius, side * 0.9 * radius, 0.70 * body])
        high = np.array([0.35 * radius, side * (radius + reach), 0.70 * body + min(0.014, 0.2 * body)])
        parts.append(part(cushion(np.minimum(low, high), np.maximum(low, high), 0.004), p["grip_colour"], PLASTIC))
    if p["lid"]:
        top = size[2]
        rise = 0.5 * (top - body)
        parts.append(
            part(
                lathe(
                    [
                        (0, body),
                        (radius, body),
                        (0.96 * radius, body + 0.3 * rise),
                        (0.3 * radius, body + rise),
                        (0, body + rise),
                    ]
                ),
                p["lid_colour"],
                METAL,
                smooth=True,
            )
        )
        parts.append(
            part(
                rod((0, 0, body + 0.8 * rise), (0, 0, top), 0.1 * radius, 0.17 * radius),
                p["grip_colour"],
                PLASTIC,
                smooth=True,
            )
        )
    return Model(parts, symmetry="half_turn", placement="object")


def draw_cooking_pot(rng: Rng, index: int) -> Draw:
    """Low casserole to tall stock pot."""
    diameter, lid = round(float(rng.uniform(0.18, 0.30)), 4), bool(index % 2 == 0)
    height = diameter * float(rng.uniform(0.45, 0.9)) * (1.3 if lid else 1.0)
    colour = pick(rng, METALS, GLAZES)
    p = {
        "lid": lid,
        "colour": colour,
        "lid_colour": colour if index % 3 else pick(rng, METALS),
        "grip_colour": pick(rng, METALS[2:]),
    }
    return Draw("cooking_pot", (diameter, round(diameter + 0.07, 4), round(height, 4)), p)
