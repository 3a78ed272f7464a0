"""Clocks, mirrors, laptops, candlesticks."""

import itertools
from typing import Any

import numpy as np

from stages.procedural.colours import METALS, PAINTS, WOODS, pick
from stages.procedural.finishes import shade
from stages.procedural.model import CERAMIC, METAL, PLASTIC, Draw, Model, Part, Size, part
from stages.procedural.shapes import box, cushion, hull, lathe, rod, rotated, translated

Rng = np.random.Generator
SILVER = (0.62, 0.68, 0.72)
DARK = (0.05, 0.05, 0.06)
WAX = 900.0


def clock(size: Size, p: dict[str, Any]) -> Model:
    """A clock for the wall. Parameters: shape (round, square), rim (metres), marks (4 or 12), hour, minute (turns),
    colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    rim, radius = min(float(p["rim"]), 0.2 * min(y, z)), min(y, z / 2)
    face, thin = 0.5 * x, 0.0015
    if p["shape"] == "round":
        parts = [_disc(-x, x, radius, p["rim_colour"]), _disc(face, x + 0.0005, radius - rim, p["face_colour"])]
        parts[1] = part(parts[1].mesh, p["face_colour"], solid=False, smooth=True)
    else:
        parts = [part(box((-x, x), (-y, y), (-z / 2, z / 2)), p["rim_colour"])]
        parts.append(
            part(
                box((face, x + 0.0005), (-y + rim, y - rim), (-z / 2 + rim, z / 2 - rim)), p["face_colour"], solid=False
            )
        )
    inner, count = radius - rim, int(p["marks"])
    for k in range(count):
        long = 0.12 if k % (count // 4) == 0 else 0.07
        parts.append(
            _hand(x, thin, 2 * np.pi * k / count, (0.88 - long) * inner, 0.9 * inner, 0.022 * inner, p["hand_colour"])
        )
    parts.append(
        _hand(x + thin, thin, 2 * np.pi * float(p["hour"]), -0.1 * inner, 0.5 * inner, 0.035 * inner, p["hand_colour"])
    )
    parts.append(
        _hand(
            x + 2 * thin,
            thin,
            2 * np.pi * float(p["minute"]),
            -0.1 * inner,
            0.78 * inner,
            0.022 * inner,
            p["hand_colour"],
        )
    )
    raised = [
        part(translated(a.mesh, (0, 0, z / 2)), str(a.finish), a.density, a.smooth, bool(a.pieces)) for a in parts
    ]
    return Model(raised, placement="wall")


def _disc(start: float, end: float, radius: float, colour: str) -> Part:
    return part(rod((start, 0, 0), (end, 0, 0), radius, segments=40), colour, smooth=True)


def _hand(x: float, thin: float, turn: float, start: float, end: float, half: float, colour: str) -> Part:
    """A mark or hand on the face at x, `turn` clockwise from noon as seen from the front."""
    return part(rotated(box((x, x + thin), (-half, half), (start, end)), turn, [1, 0, 0]), colour, solid=False)


def draw_clock(rng: Rng, index: int) -> Draw:
    """Round and square."""
    wide = round(float(rng.uniform(0.22, 0.42)), 3)
    p = {
        "shape": "square" if index % 3 == 2 else "round",
        "rim": round(float(rng.uniform(0.01, 0.03)), 3),
        "marks": [12, 4, 12][index % 3],
        "hour": round(float(rng.uniform()), 3),
        "minute": round(float(rng.uniform()), 3),
        "rim_colour": pick(rng, WOODS, METALS),
        "face_colour": pick(rng, PAINTS[:2], PAINTS[4:5]),
        "hand_colour": list(DARK),
    }
    if "paint 0.1" in str(p["face_colour"]):
        p["hand_colour"] = [0.8, 0.8, 0.78]
    return Draw("clock", (round(float(rng.uniform(0.03, 0.05)), 3), wide, wide), p)


def mirror(size: Size, p: dict[str, Any]) -> Model:
    """A mirror in a frame, on the wall. Parameters: shape (rectangle, oval, arch), frame (width), colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    frame = min(float(p["frame"]), 0.15 * min(size[1], z))
    face = 0.6 * x
    if p["shape"] == "rectangle":
        strips = [((-y, -y + frame), (0.0, z)), ((y - frame, y), (0.0, z))]
        strips += [((-y + frame, y - frame), span) for span in ((0.0, frame), (z - frame, z))]
        parts = [part(box((-x, x), a, b), p["frame_colour"]) for a, b in strips]
        parts.append(part(box((-x, face), (-y + frame, y - frame), (frame, z - frame)), SILVER, 2400.0))
        return Model(parts, placement="wall")

    def outline(inset: float) -> list[tuple[float, float]]:
        if p["shape"] == "oval":
            angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
            return [((y - inset) * np.cos(a), z / 2 + (z / 2 - inset) * np.sin(a)) for a in angles]
        angles = np.linspace(0, np.pi, 20)
        crown = [((y - inset) * np.cos(a), z - y + (y - inset) * np.sin(a)) for a in angles]
        return [*crown, (-(y - inset), inset), (y - inset, inset)]

    parts = [part(hull([(a, b, c) for b, c in outline(0.0) for a in (-x, x - 0.002)]), p["frame_colour"])]
    glass = hull([(a, b, c) for b, c in outline(frame) for a in (face, x)])
    return Model([*parts, part(glass, SILVER, 2400.0, solid=False)], placement="wall")


def draw_mirror(rng: Rng, index: int) -> Draw:
    """Rectangular, oval, arched."""
    wide, tall = float(rng.uniform(0.35, 0.65)), float(rng.uniform(0.75, 1.3))
    p = {
        "shape": ["rectangle", "oval", "arch"][index % 3],
        "frame": round(float(rng.uniform(0.015, 0.06)), 3),
        "frame_colour": pick(rng, WOODS, METALS),
    }
    return Draw("mirror", (round(float(rng.uniform(0.025, 0.045)), 3), round(wide, 3), round(tall, 3)), p)


def laptop(size: Size, p: dict[str, Any]) -> Model:
    """An open laptop, its screen facing +x. Parameters: lean (share of the depth behind the hinge), rim, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    thick = min(0.014, 0.1 * z)
    hinge = -x + float(p["lean"]) * size[0]
    parts = [part(cushion((hinge, -y, 0), (x, y, thick), 0.004), p["colour"], 1500.0)]
    keys = box((hinge + 0.12 * (x - hinge), hinge + 0.56 * (x - hinge)), (-0.88 * y, 0.88 * y), (thick, thick + 0.001))
    pad = box((hinge + 0.64 * (x - hinge), hinge + 0.94 * (x - hinge)), (-0.25 * y, 0.25 * y), (thick, thick + 0.0007))
    parts += [part(keys, DARK, solid=False), part(pad, shade(p["colour"], 0.8), solid=False)]
    lid = 0.007

    def plane(low: float, high: float, side: float, front: float, back: float) -> Any:
        ends = [(hinge + (-x + lid - hinge) * s, thick + (z - thick) * s) for s in (low, high)]
        return hull([(a + d, b, c) for a, c in ends for d in (back, front) for b in (-side, side)])

    parts.append(part(plane(0.0, 1.0, y, 0.0, -lid), p["colour"], 1200.0))
    rim = float(p["rim"])
    parts.append(part(plane(0.06, 1 - rim / z, y - rim, 0.0012, 0.0), p["screen_colour"], solid=False))
    return Model(parts, placement="object")


def draw_laptop(rng: Rng, index: int) -> Draw:
    """Small to large, more or less open."""
    wide, lean = float(rng.uniform(0.29, 0.38)), float(rng.uniform(0.12, 0.3))
    size = (round(wide * 0.68 / (1 - lean), 3), round(wide, 3), round(wide * float(rng.uniform(0.58, 0.66)), 3))
    p = {
        "lean": round(lean, 3),
        "rim": round(float(rng.uniform(0.006, 0.014)), 3),
        "colour": pick(rng, METALS[:3]),
        "screen_colour": [0.10, 0.16, 0.26] if index % 2 else [0.03, 0.04, 0.06],
    }
    return Draw("laptop", size, p)


def candlestick(size: Size, p: dict[str, Any]) -> Model:
    """A candle in a holder. Parameters: radii (shares, foot to cup), candle (share of the height), colours."""
    radius, z = size[0] / 2, size[2]
    top = z * (1 - float(p["candle"]))
    shape = np.array(p["radii"], dtype=float)
    levels = np.linspace(0.03, 1, len(shape)) * top
    outline = [(radius * float(r), float(a)) for r, a in zip(shape / shape.max(), levels, strict=True)]
    parts = [part(lathe([(0, 0), (outline[0][0], 0), outline[0], (0, outline[0][1])]), p["colour"], METAL, smooth=True)]
    parts += [
        part(lathe([(0, a[1]), a, b, (0, b[1])]), p["colour"], METAL if p["metal"] else CERAMIC, smooth=True)
        for a, b in itertools.pairwise(outline)
    ]
    wide = 0.8 * outline[-1][0]
    parts.append(part(rod((0, 0, top), (0, 0, 0.97 * z), wide, 0.94 * wide), p["candle_colour"], WAX, smooth=True))
    parts.append(part(rod((0, 0, 0.97 * z), (0, 0, z), 0.0015), DARK, PLASTIC, solid=False))
    return Model(parts, symmetry="full", placement="object")


def draw_candlestick(rng: Rng, index: int) -> Draw:
    """Turned holders, low and tall."""
    wide, tall = float(rng.uniform(0.07, 0.12)), float(rng.uniform(0.14, 0.34))
    radii = [1.0, *(round(float(r), 3) for r in rng.uniform(0.14, 0.42, 3)), round(float(rng.uniform(0.28, 0.42)), 3)]
    p = {
        "radii": radii,
        "candle": round(float(rng.uniform(0.3, 0.55)), 3),
        "metal": bool(index % 2 == 0),
        "colour": pick(rng, METALS, WOODS),
        "candle_colour": pick(rng, PAINTS[:2], PAINTS[7:]),
    }
    return Draw("candlestick", (round(wide, 3), round(wide, 3), round(tall, 3)), p)
