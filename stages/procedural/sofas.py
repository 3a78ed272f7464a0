"""Sofas and armchairs; the back is at -x."""

from typing import Any

import numpy as np

from stages.procedural.colours import FABRICS, METALS, WOODS, pick
from stages.procedural.model import FOAM, Draw, Model, Size, part
from stages.procedural.shapes import box, cushion, rod

Rng = np.random.Generator


def sofa(size: Size, p: dict[str, Any]) -> Model:
    """Parameters: seats, seat and arm heights (shares), arm (width), back (depth), legs (height), edge (chamfer),
    pillows, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    arm, back, legs, edge = (
        float(p["arm"]),
        min(float(p["back"]), 0.4 * size[0]),
        min(float(p["legs"]), 0.3 * z),
        float(p["edge"]),
    )
    seat, arm_top = max(float(p["seat"]) * z, legs + 0.15 * z), float(p["arm_height"]) * z
    cloth = p["colour"]
    parts = [
        part(rod((a, b, 0), (a, b, legs + 0.02), 0.02, 0.028), p["leg_colour"], smooth=True)
        for a in (-x + 0.06, x - 0.06)
        for b in (-y + 0.06, y - 0.06)
    ]
    inner = y - arm
    low = legs + 0.45 * (seat - legs)
    parts.append(part(box((-x + 0.02, x - 0.02), (-inner - 0.01, inner + 0.01), (legs, low)), cloth, 120.0))
    parts.append(part(cushion((-x, -inner, legs), (-x + 0.55 * back, inner, 0.94 * z), edge), cloth, 100.0))
    if arm > 0.03:
        parts += [
            part(cushion((-x, min(s * y, s * inner), legs), (x, max(s * y, s * inner), arm_top), edge), cloth, 100.0)
            for s in (-1, 1)
        ]
    count = int(p["seats"])
    for k in range(count):
        a, b = -inner + 2 * inner * k / count, -inner + 2 * inner * (k + 1) / count
        parts.append(
            part(
                cushion((-x + 0.5 * back, a + 0.004, low), (x, b - 0.004, seat), 1.2 * edge), p["cushion_colour"], FOAM
            )
        )
        parts.append(
            part(
                cushion((-x + 0.45 * back, a + 0.006, seat), (-x + back, b - 0.006, z), 1.4 * edge),
                p["cushion_colour"],
                FOAM,
            )
        )
    for s in (-1, 1) if p["pillows"] else ():
        mid = s * (inner - 0.2)
        parts.append(
            part(
                cushion((-x + back, mid - 0.16, seat), (-x + back + 0.1, mid + 0.16, seat + 0.3), 0.04),
                p["pillow_colour"],
                FOAM,
            )
        )
    return Model(parts)


def draw_sofa(rng: Rng, index: int) -> Draw:
    """Armchair to three-seater."""
    seats = [2, 3, 1, 3][index % 4]
    size = (
        round(float(rng.uniform(0.8, 0.98)), 3),
        round(0.45 + 0.55 * seats + float(rng.uniform(-0.05, 0.15)), 3),
        round(float(rng.uniform(0.7, 0.9)), 3),
    )
    colour = pick(rng, FABRICS)
    p = {
        "seats": seats,
        "seat": 0.52,
        "arm": round(float(rng.uniform(0.1, 0.24)), 3),
        "arm_height": round(float(rng.uniform(0.62, 0.85)), 3),
        "back": round(float(rng.uniform(0.25, 0.34)), 3),
        "legs": round(float(rng.uniform(0.04, 0.14)), 3),
        "edge": round(float(rng.uniform(0.015, 0.05)), 3),
        "pillows": bool(seats > 1 and rng.random() < 0.6),
        "colour": colour,
        "cushion_colour": colour if rng.random() < 0.6 else pick(rng, FABRICS),
        "pillow_colour": pick(rng, FABRICS),
        "leg_colour": pick(rng, WOODS, METALS),
    }
    return Draw("sofa", size, p)
