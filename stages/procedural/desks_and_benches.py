"""Desks with drawers, benches, shelves on the wall."""

from typing import Any

import numpy as np

from stages.procedural.cabinet import cabinet
from stages.procedural.cabinet_draws import HANDLE_SHARES, HANDLES, pedestal
from stages.procedural.colours import FABRICS, METALS, PAINTS, WOODS, pick
from stages.procedural.finishes import shade
from stages.procedural.model import FOAM, METAL, Draw, Model, Moving, Part, Size, moved, part
from stages.procedural.shapes import beam, box, cushion
from stages.procedural.tables_and_beds import supports

Rng = np.random.Generator
MARGIN = 0.012  # between the top's rim and a pedestal's handles


def desk(size: Size, p: dict[str, Any]) -> Model:
    """A top, legs, and pedestals of drawers beside the knees; drawers open towards +x.

    Parameters: pedestals (none, left, right, both), pedestal_width, drawers (of each), legs (square, panels),
    top_thickness, leg, modesty (a board at the back), raised (height of a shelf on the top, 0: none), handle, panel,
    colours.
    """
    x, y, high = size[0] / 2, size[1] / 2, size[2]
    z = high - min(float(p["raised"]), 0.3 * high)
    thick = min(float(p["top_thickness"]), 0.1 * z)
    under, leg = z - thick, min(float(p["leg"]), 0.1 * min(size))
    parts = [part(box((-x, x), (-y, y), (under, z)), p["top_colour"])]
    moving: list[Moving] = []
    wide = min(float(p["pedestal_width"]), 0.3 * size[1])
    for side in (-1, 1):
        if p["pedestals"] in ("both", "left" if side < 0 else "right"):
            unit = cabinet((size[0] - 2 * MARGIN, wide, under), pedestal(p))
            unit = moved(unit, (0.0, side * (y - wide / 2 - MARGIN), 0.0), f"_{'l' if side < 0 else 'r'}")
            parts += unit.base
            moving += unit.moving
        elif p["legs"] == "panels":
            low, top = side * (y - 0.5 * leg), side * (y - 1.1 * leg)
            parts.append(part(box((-x + 0.02, x - 0.04), (min(low, top), max(low, top)), (0, under)), p["leg_colour"]))
        else:
            parts += [
                part(beam((a, side * (y - leg), 0), (a, side * (y - leg), under), 0.7 * leg, leg), p["leg_colour"])
                for a in (-x + leg, x - leg)
            ]
    if p["modesty"]:
        rim = y - wide - 2 * MARGIN if p["pedestals"] == "both" else y - 1.2 * leg
        left = -(y - wide - 2 * MARGIN) if p["pedestals"] in ("left", "both") else -rim
        right = y - wide - 2 * MARGIN if p["pedestals"] in ("right", "both") else rim
        parts.append(part(box((-x + 0.03, -x + 0.045), (left, right), (0.45 * under, under)), p["leg_colour"]))
    if z < high:
        boards = [((-x, -x + 0.45 * x), (-y, y), (high - 0.02, high))]
        boards += [
            ((-x, -x + 0.45 * x), span, (z, high - 0.02)) for span in ((-y, -y + 0.02), (-0.01, 0.01), (y - 0.02, y))
        ]
        parts += [part(box(*board), p["top_colour"]) for board in boards]
    return Model(parts, moving)


def draw_desk(rng: Rng, index: int) -> Draw:
    """With one pedestal, with two, without, with a shelf on top."""
    pedestals = ["right", "both", "none", "left"][index % 4]
    top, front = pick(rng, WOODS, PAINTS[:2]), pick(rng, WOODS, PAINTS)
    p = {
        "pedestals": pedestals,
        "pedestal_width": round(float(rng.uniform(0.33, 0.42)), 3),
        "drawers": int(rng.integers(2, 5)),
        "legs": str(rng.choice(["square", "panels"])),
        "top_thickness": round(float(rng.uniform(0.02, 0.04)), 3),
        "leg": round(float(rng.uniform(0.04, 0.06)), 3),
        "modesty": bool(rng.random() < 0.5),
        "raised": round(float(rng.uniform(0.18, 0.3)), 3) if index % 3 == 2 else 0.0,
        "handle": str(rng.choice(HANDLES[:4], p=np.array(HANDLE_SHARES[:4]) / sum(HANDLE_SHARES[:4]))),
        "panel": str(rng.choice(["flat", "frame", "raised"])),
        "top_colour": top,
        "front_colour": front,
        "body_colour": shade(front, 0.85),
        "leg_colour": top if rng.random() < 0.6 else pick(rng, METALS),
        "handle_colour": pick(rng, METALS),
    }
    wide = float(rng.uniform(1.35, 1.7) if pedestals == "both" else rng.uniform(1.0, 1.5))
    high = float(rng.uniform(0.72, 0.77)) + float(str(p["raised"]))
    return Draw("desk", (round(float(rng.uniform(0.55, 0.75)), 3), round(wide, 3), round(high, 3)), p)


def bench(size: Size, p: dict[str, Any]) -> Model:
    """A long seat. Parameters: seat (board, slats, padded), legs (as of a table), leg, thickness, back (height share of
    the seat, 1: none), slats, colours."""
    x, y, high = size[0] / 2, size[1] / 2, size[2]
    z = high * min(float(p["back"]), 1.0)
    thick = min(float(p["thickness"]), 0.25 * z)
    under, leg = z - thick, min(float(p["leg"]), 0.2 * size[0])
    parts: list[Part] = []
    if p["seat"] == "slats":
        pitch, count = size[0] / int(p["slats"]), int(p["slats"])
        parts += [
            part(box((-x + k * pitch + 0.004, -x + (k + 1) * pitch - 0.004), (-y, y), (under, z)), p["seat_colour"])
            for k in range(count)
        ]
        parts += [
            part(box((-x + 0.01, x - 0.01), (b - 0.02, b + 0.02), (under - 0.03, under)), p["leg_colour"])
            for b in (-0.8 * y, 0.8 * y)
        ]
    elif p["seat"] == "padded":
        parts.append(part(box((-x + 0.01, x - 0.01), (-y + 0.01, y - 0.01), (under, under + 0.02)), p["leg_colour"]))
        parts.append(part(cushion((-x, -y, under + 0.02), (x, y, z), 0.02), p["cushion_colour"], FOAM))
    else:
        parts.append(part(box((-x, x), (-y, y), (under, z)), p["seat_colour"]))
    parts += supports(p["legs"], x - 0.9 * leg, y - 0.9 * leg, under, leg, p["leg_colour"])
    if z < high:
        posts = np.linspace(-0.9 * y, 0.9 * y, 3)
        parts += [part(beam((-x + 0.05, b, z), (-x + 0.015, b, high), 0.035, 0.03), p["leg_colour"]) for b in posts]
        rise = high - z
        parts += [
            part(box((-x + 0.035, -x + 0.055), (-y, y), (z + a * rise, z + b * rise)), p["seat_colour"])
            for a, b in ((0.25, 0.5), (0.62, 0.92))
        ]
        return Model(parts)
    return Model(parts, symmetry="half_turn")


def draw_bench(rng: Rng, index: int) -> Draw:
    """A board, slats, padded; some with a back."""
    back = index % 4 == 3
    size = (
        round(float(rng.uniform(0.32, 0.45)), 3),
        round(float(rng.uniform(0.9, 1.5)), 3),
        round(float(rng.uniform(0.78, 0.9) if back else rng.uniform(0.42, 0.48)), 3),
    )
    p = {
        "seat": ["board", "slats", "padded", "slats"][index % 4],
        "legs": ["square", "panels", "splayed", "square", "tapered"][index % 5],
        "leg": round(float(rng.uniform(0.04, 0.07)), 3),
        "thickness": round(float(rng.uniform(0.03, 0.06)), 3),
        "back": round(0.45 / size[2], 3) if back else 1.0,
        "slats": int(rng.integers(3, 6)),
        "seat_colour": pick(rng, WOODS, PAINTS[:3]),
        "leg_colour": pick(rng, WOODS, METALS),
        "cushion_colour": pick(rng, FABRICS),
    }
    if p["seat"] == "padded":
        p["thickness"] = round(float(rng.uniform(0.07, 0.1)), 3)
    return Draw("bench", size, p)


def wall_shelf(size: Size, p: dict[str, Any]) -> Model:
    """Boards on the wall. Parameters: boards, style (brackets, box, ladder), thickness, brackets, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    thick, count = min(float(p["thickness"]), 0.2 * z), int(p["boards"])
    if p["style"] == "box":
        levels = np.linspace(0, z - thick, count + 1)
        parts = [part(box((-x, x), (s * y, s * (y - thick)), (0, z)), p["colour"]) for s in (-1, 1)]
        parts += [part(box((-x, x), (-y + thick, y - thick), (a, a + thick)), p["colour"]) for a in levels]
        parts.append(part(box((-x, -x + 0.005), (-y + thick, y - thick), (thick, z - thick)), p["second_colour"]))
        return Model(parts, placement="wall")
    places = np.linspace(-0.7 * y, 0.7 * y, int(p["brackets"]))
    if p["style"] == "ladder":
        levels = np.linspace(0.04 * z, z - thick - 0.08 * z, count)
        parts = [part(box((-x, -x + 0.012), (b - 0.015, b + 0.015), (0, z)), p["second_colour"], METAL) for b in places]
        arms = [((-x + 0.012, 0.8 * x), (b - 0.008, b + 0.008), (a - 0.012, a)) for a in levels for b in places]
        parts += [part(box(*arm), p["second_colour"], METAL) for arm in arms]
    else:
        drop = min(0.6 * size[0], 0.75 * z / count)
        levels = np.linspace(drop, z - thick, count) if count > 1 else np.array([z - thick])
        parts = []
        for a in levels:
            low = a - drop if count > 1 else 0.0
            parts += [part(box((-x, -x + 0.012), (b - 0.012, b + 0.012), (low, a)), p["second_colour"]) for b in places]
            parts += [
                part(beam((-x + 0.012, b, low + 0.012), (0.7 * x, b, a - 0.006), 0.014), p["second_colour"])
                for b in places
            ]
    parts += [part(box((-x + 0.012, x), (-y, y), (a, a + thick)), p["colour"]) for a in levels]
    return Model(parts, placement="wall")


def draw_wall_shelf(rng: Rng, index: int) -> Draw:
    """One board on brackets to a box of three."""
    style, boards = [("brackets", 1), ("box", 1), ("ladder", 3), ("brackets", 2), ("box", 2)][index % 5]
    tall = {"brackets": 0.22 + 0.28 * (boards - 1), "box": 0.3 * boards, "ladder": 0.85}[style]
    size = (
        round(float(rng.uniform(0.18, 0.28)), 3),
        round(float(rng.uniform(0.5, 1.1)), 3),
        round(tall * float(rng.uniform(0.85, 1.15)), 3),
    )
    p = {
        "style": style,
        "boards": boards,
        "thickness": round(float(rng.uniform(0.016, 0.035)), 3),
        "brackets": int(rng.integers(2, 4)),
        "colour": pick(rng, WOODS, PAINTS),
        "second_colour": pick(rng, METALS, PAINTS),
    }
    return Draw("wall_shelf", size, p)
