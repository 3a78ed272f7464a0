"""Armchairs; the back is at -x."""

from typing import Any

import numpy as np

from stages.procedural.colours import FABRICS, METALS, WOODS, pick
from stages.procedural.model import FOAM, Draw, Model, Part, Size, part
from stages.procedural.shapes import beam, box, cushion, hull, rod

Rng = np.random.Generator
UPHOLSTERY = 100.0  # kg / m^3


def armchair(size: Size, p: dict[str, Any]) -> Model:
    """Parameters: style (open: cushions in a wooden frame, wing: a high back with ears, tub: a low round back), seat
    (height share), lean (share of the depth), arm_height (share), legs (metres), leg, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    seat, arm = float(p["seat"]) * z, float(p["arm_height"]) * z
    lean = float(p["lean"]) * size[0]
    if p["style"] == "open":
        return Model(_open(p, x, y, z, seat, arm, lean))
    legs = min(float(p["legs"]), 0.6 * seat)
    parts = [
        part(rod((a, b, 0), (0.9 * a, 0.9 * b, legs + 0.02), 0.014, 0.022), p["frame_colour"], smooth=True)
        for a in (-0.82 * x, 0.82 * x)
        for b in (-0.8 * y, 0.8 * y)
    ]
    cloth, wall = p["colour"], min(0.14, 0.2 * size[1])
    low = legs + 0.45 * (seat - legs)
    parts.append(part(cushion((-0.95 * x, -0.95 * y, legs), (0.95 * x, 0.95 * y, low), 0.02), cloth, UPHOLSTERY))
    parts.append(
        part(cushion((-x + wall, -y + wall, low), (x - 0.01, y - wall, seat), 0.04), p["cushion_colour"], FOAM)
    )
    if p["style"] == "wing":
        parts.append(part(_leaning(-x + lean, -x, wall, (-y + 0.4 * wall, y - 0.4 * wall), low, z), cloth, UPHOLSTERY))
        for s in (-1, 1):
            outer, inner = s * y, s * (y - wall)
            parts.append(
                part(
                    cushion((-x + wall, min(outer, inner), legs), (0.9 * x, max(outer, inner), arm), 0.03),
                    cloth,
                    UPHOLSTERY,
                )
            )
            ear = [
                (a, b, c)
                for b in (outer, s * (y - 0.5 * wall))
                for a, c in (
                    (-x + lean * (1 - arm / z), arm),
                    (-x, z),
                    (-x + 0.3 * size[0], arm),
                    (-x + 0.16 * size[0], 0.97 * z),
                )
            ]
            parts.append(part(hull(ear), cloth, UPHOLSTERY))
        return Model(parts)
    for t in np.linspace(np.pi / 2, 3 * np.pi / 2, 8)[:-1]:  # a low wall of staves around the back, higher behind
        ends = []
        for angle in (t, t + np.pi / 7):
            rise = arm + (z - arm) * max(0.0, -np.cos(angle)) ** 0.7
            for share in (1.0, 1.0 - wall / y):
                at = (max(x * share * 0.98 * np.cos(angle), -x), y * share * np.sin(angle))
                ends += [(*at, legs), (*at, rise)]
        parts.append(part(hull(ends), cloth, UPHOLSTERY))
    for s in (-1, 1):
        parts.append(
            part(
                cushion((0.0, min(s * y, s * (y - wall)), legs), (0.8 * x, max(s * y, s * (y - wall)), arm), 0.02),
                cloth,
                UPHOLSTERY,
            )
        )
    return Model(parts)


def _open(p: dict[str, Any], x: float, y: float, z: float, seat: float, arm: float, lean: float) -> list[Part]:
    """Two frames of beams, a seat and a back cushion on boards between them."""
    frame, leg = p["frame_colour"], float(p["leg"])
    parts: list[Part] = []
    for s in (-1, 1):
        b = s * (y - leg / 2)
        parts += [
            part(beam((x - leg, b, 0), (x - 1.6 * leg, b, arm), leg), frame),
            part(beam((-x + leg, b, 0), (-x + 1.6 * leg, b, arm), leg), frame),
            part(box((-x, x), (b - 0.7 * leg, b + 0.7 * leg), (arm, arm + 0.6 * leg)), frame),
            part(box((-x + leg, x - leg), (b - leg / 3, b + leg / 3), (seat - 0.13, seat - 0.09)), frame),
        ]
    inner = y - 1.1 * leg
    parts.append(part(box((-x + lean, x - 0.02), (-y + leg / 2, y - leg / 2), (seat - 0.12, seat - 0.10)), frame))
    parts.append(part(cushion((-x + lean, -inner, seat - 0.10), (x, inner, seat + 0.02), 0.03), p["colour"], FOAM))
    parts.append(part(_leaning(-x + lean + 0.06, -x, 0.1, (-inner, inner), seat, z), p["colour"], FOAM))
    parts.append(part(_leaning(-x + lean - 0.02, -x, 0.02, (-inner, inner), seat - 0.11, 0.9 * z), frame))
    return parts


def _leaning(low_x: float, high_x: float, thick: float, y: tuple[float, float], low: float, high: float) -> Any:
    """A board or cushion that leans back from low_x (its rear, at the height low) to high_x."""
    return hull([(a + d, b, c) for a, c in ((low_x, low), (high_x, high)) for d in (0, thick) for b in y])


def draw_armchair(rng: Rng, index: int) -> Draw:
    """Cushions in a wooden frame, with wings, or a tub."""
    style = ["open", "wing", "tub", "open"][index % 4]
    tall = {"open": (0.74, 0.88), "wing": (0.95, 1.12), "tub": (0.68, 0.8)}[style]
    size = (
        round(float(rng.uniform(0.68, 0.82)), 3),
        round(float(rng.uniform(0.62, 0.8)), 3),
        round(float(rng.uniform(*tall)), 3),
    )
    colour = pick(rng, FABRICS)
    p = {
        "style": style,
        "seat": round(float(rng.uniform(0.4, 0.45)) / size[2], 3),
        "lean": round(float(rng.uniform(0.12, 0.25)), 3),
        "arm_height": round(float(rng.uniform(0.56, 0.63)) / size[2], 3),
        "legs": round(float(rng.uniform(0.1, 0.2)), 3),
        "leg": round(float(rng.uniform(0.035, 0.05)), 3),
        "colour": colour,
        "cushion_colour": colour if rng.random() < 0.6 else pick(rng, FABRICS),
        "frame_colour": pick(rng, WOODS, METALS[:3]),
    }
    return Draw("armchair", size, p)
