"""Televisions and pictures."""

from typing import Any

import numpy as np

from stages.procedural.colours import GLAZES, METALS, PAINTS, WOODS, pick
from stages.procedural.finishes import made_of
from stages.procedural.model import STEEL, Draw, Model, Part, Size, part
from stages.procedural.shapes import beam, box, cushion, hull, rod

Rng = np.random.Generator


def television(size: Size, p: dict[str, Any]) -> Model:
    """A flat screen on a stand. Parameters: stand (feet, neck, bar), stand_height (share), rim (metres), colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    stand = float(p["stand_height"]) * z
    rim, thick = min(float(p["rim"]), 0.1 * z), min(0.025, 0.3 * x)
    parts = [part(box((-thick, thick), (-y, y), (stand, z)), p["case_colour"], 400.0)]
    parts.append(
        part(
            box((thick, thick + 0.002), (-y + rim, y - rim), (stand + rim, z - rim)),
            p["screen_colour"],
            400.0,
            solid=False,
        )
    )
    parts.append(
        part(
            cushion(
                (-2.2 * thick, -0.6 * y, stand + 0.1 * (z - stand)), (-thick, 0.6 * y, stand + 0.6 * (z - stand)), 0.02
            ),
            p["case_colour"],
            400.0,
        )
    )
    if p["stand"] == "feet":
        for s in (-0.7 * y, 0.7 * y):
            parts.append(part(box((-x, x), (s - 0.015, s + 0.015), (0, 0.012)), p["case_colour"], STEEL))
            parts.append(part(beam((0, s, 0.012), (0, s, stand + 0.02), 0.02), p["case_colour"], STEEL))
        return Model(parts, placement="object")
    wide = 0.28 * y if p["stand"] == "neck" else 0.65 * y
    parts.append(part(cushion((-x, -wide * 1.3, 0), (x, wide * 1.3, 0.016), 0.005), p["case_colour"], STEEL))
    parts.append(
        part(box((-0.8 * thick, 0.2 * thick), (-0.5 * wide, 0.5 * wide), (0.01, stand + 0.03)), p["case_colour"], STEEL)
    )
    return Model(parts, placement="object")


def draw_television(rng: Rng, index: int) -> Draw:
    """Small to large, wide or old-fashioned 4:3."""
    wide = float(rng.uniform(0.7, 1.25))
    shape = 0.72 if index % 4 == 3 else float(rng.uniform(0.58, 0.64))
    p = {
        "stand": ["feet", "neck", "bar"][index % 3],
        "stand_height": round(float(rng.uniform(0.08, 0.16)), 3),
        "rim": round(float(rng.uniform(0.008, 0.035)), 3),
        "case_colour": pick(rng, METALS[:3]),
        "screen_colour": [0.02, 0.03, 0.05],
    }
    return Draw("television", (round(float(rng.uniform(0.18, 0.26)), 3), round(wide, 3), round(wide * shape, 3)), p)


def picture(size: Size, p: dict[str, Any]) -> Model:
    """A framed picture for the wall.

    Parameters: frame (width), mat (width), motif (bands, circle, grid, diagonal), colours.
    """
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    frame, mat = min(float(p["frame"]), 0.15 * min(size[1], z)), float(p["mat"])
    face = 0.4 * x
    parts = [part(box((-x, face - 0.004), (-y + frame, y - frame), (frame, z - frame)), (0.86, 0.85, 0.80))]
    strips = [
        ((-y, -y + frame), (0, z)),
        ((y - frame, y), (0, z)),
        ((-y + frame, y - frame), (0, frame)),
        ((-y + frame, y - frame), (z - frame, z)),
    ]
    parts += [part(box((-x, x), a, b), p["frame_colour"]) for a, b in strips]
    inset = frame + min(mat, 0.2 * min(size[1], z))
    y0, y1, z0, z1 = -y + inset, y - inset, inset, z - inset
    motif: list[Part] = [part(box((face - 0.004, face), (y0, y1), (z0, z1)), p["colour_1"], solid=False)]
    if p["motif"] == "bands":
        motif += [
            part(box((face, face + 0.001), (y0, y1), (z0 + a * (z1 - z0), z0 + b * (z1 - z0))), c, solid=False)
            for a, b, c in ((0.0, 0.3, p["colour_2"]), (0.3, 0.45, p["colour_3"]))
        ]
    elif p["motif"] == "circle":
        radius = 0.3 * min(y1 - y0, z1 - z0)
        motif.append(
            part(rod((face, 0, z / 2), (face + 0.001, 0, z / 2), radius, segments=32), p["colour_2"], solid=False)
        )
        motif.append(part(box((face, face + 0.001), (y0, y1), (z0, z0 + 0.2 * (z1 - z0))), p["colour_3"], solid=False))
    elif p["motif"] == "grid":
        for k in range(9):
            a, b = y0 + (0.1 + 0.3 * (k % 3)) * (y1 - y0), z0 + (0.1 + 0.3 * (k // 3)) * (z1 - z0)
            motif.append(
                part(
                    box((face, face + 0.001), (a, a + 0.2 * (y1 - y0)), (b, b + 0.2 * (z1 - z0))),
                    p["colour_2"] if k % 2 else p["colour_3"],
                    solid=False,
                )
            )
    else:
        corners = [(face + dx, a, b) for dx in (0, 0.001) for a, b in ((y0, z0), (y1, z0), (y0, z1))]
        motif.append(part(hull(corners), p["colour_2"], solid=False))
    return Model(parts + motif, placement="wall")


def draw_picture(rng: Rng, index: int) -> Draw:
    """Portrait and landscape."""
    wide, tall = sorted(float(v) for v in rng.uniform([0.3, 0.5], [0.5, 0.8]))
    y, z = (wide, tall) if index % 2 else (tall, wide)
    p = {
        "frame": round(float(rng.uniform(0.015, 0.05)), 3),
        "mat": round(float(rng.choice([0.0, rng.uniform(0.03, 0.08)])), 3),
        "motif": ["bands", "circle", "grid", "diagonal"][index % 4],
        "frame_colour": pick(rng, WOODS, METALS),
        "colour_1": made_of("card", pick(rng, PAINTS)),
        "colour_2": made_of("card", pick(rng, GLAZES)),
        "colour_3": made_of("card", pick(rng, GLAZES)),
    }
    return Draw("picture", (0.035, round(y, 3), round(z, 3)), p)
