"""Tables, coffee tables and beds."""

from typing import Any

import numpy as np

from stages.procedural.colours import FABRICS, METALS, PAINTS, STONES, TILES, WOODS, pick
from stages.procedural.finishes import finish_of
from stages.procedural.model import FOAM, METAL, Draw, Model, Part, Size, part
from stages.procedural.shapes import beam, box, cushion, lathe, rod

Rng = np.random.Generator
SLATTED = 180.0  # kg / m^3: a bed frame is not solid


def table(size: Size, p: dict[str, Any]) -> Model:
    """A top on legs. Parameters: top (rectangle, round), legs (square, round, tapered, splayed, panels, pedestal,
    trestle), top_thickness, leg (thickness), apron (height, 0: none), shelf (height share, 0: none), colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    thick = min(float(p["top_thickness"]), 0.2 * z)
    under = z - thick
    leg = min(float(p["leg"]), 0.2 * min(size))
    round_top = p["top"] == "round"
    if round_top:
        mesh = lathe([(0, under), (x, under), (x, z), (0, z)], 32)
        mesh.vertices *= [1.0, y / x, 1.0]
        parts = [part(mesh, p["top_colour"], smooth=True)]
    else:
        parts = [part(box((-x, x), (-y, y), (under, z)), p["top_colour"])]
    reach = 0.62 if round_top else 1.0
    ax, ay = reach * x - leg * 0.9, reach * y - leg * 0.9
    parts += supports(p["legs"], ax, ay, under, leg, p["leg_colour"])
    legged = p["legs"] in ("square", "round", "tapered", "splayed")
    apron = min(float(p["apron"]), 0.3 * z)
    if apron and legged and not round_top:
        spans = [((-ax, ax), (s * ay - 0.01, s * ay + 0.01)) for s in (-1, 1)]
        spans += [((s * ax - 0.01, s * ax + 0.01), (-ay, ay)) for s in (-1, 1)]
        parts += [part(box(a, b, (under - apron, under)), p["leg_colour"]) for a, b in spans]
    if float(p["shelf"]) and legged:
        level = float(p["shelf"]) * z
        parts.append(part(box((-ax, ax), (-ay, ay), (level, level + 0.6 * thick)), p["top_colour"]))
    square = abs(size[0] - size[1]) < 1e-6
    if round_top and p["legs"] == "pedestal" and square:
        return Model(parts, symmetry="full")
    plain = p["legs"] not in ("panels", "trestle")
    return Model(parts, symmetry="quarter_turn" if square and plain else "half_turn")


def supports(style: str, ax: float, ay: float, top: float, leg: float, colour: str) -> list[Part]:
    """Legs at (+-ax, +-ay) up to `top`; panels, trestle and pedestal where those styles have them."""
    corners = [(sx, sy) for sx in (-1, 1) for sy in (-1, 1)]
    if style == "round":
        return [part(rod((a * ax, b * ay, 0), (a * ax, b * ay, top), leg / 2), colour, smooth=True) for a, b in corners]
    if style in ("square", "tapered"):
        tip = leg if style == "square" else 0.55 * leg
        return [part(beam((a * ax, b * ay, 0), (a * ax, b * ay, top), tip, leg), colour) for a, b in corners]
    if style == "splayed":
        lean = 0.7
        return [
            part(
                rod((a * ax, b * ay, 0), (lean * a * ax, lean * b * ay, top), 0.3 * leg, 0.5 * leg), colour, smooth=True
            )
            for a, b in corners
        ]
    if style == "panels":
        return [part(box((-ax, ax), (s * ay - leg / 3, s * ay + leg / 3), (0, top)), colour) for s in (-1, 1)]
    if style == "trestle":
        feet = [box((-ax, ax), (s * 0.75 * ay - leg / 2, s * 0.75 * ay + leg / 2), (0, 0.06 * top)) for s in (-1, 1)]
        posts = [
            box((-leg, leg), (s * 0.75 * ay - leg / 2, s * 0.75 * ay + leg / 2), (0.06 * top, top)) for s in (-1, 1)
        ]
        bar = box((-leg / 3, leg / 3), (-0.75 * ay, 0.75 * ay), (0.3 * top, 0.3 * top + 1.2 * leg))
        return [part(mesh, colour) for mesh in (*feet, *posts, bar)]
    wide = min(ax, ay)
    foot = lathe([(0, 0), (0.8 * wide, 0), (0.75 * wide, 0.03 * top), (leg * 0.8, 0.10 * top), (0, 0.10 * top)])
    return [
        part(foot, colour, METAL, smooth=True),
        part(rod((0, 0, 0.08 * top), (0, 0, top), 0.7 * leg), colour, smooth=True),
    ]


def _draw(rng: Rng, size: Size, legs: str, top: str, shelf: float) -> Draw:
    colour = pick(rng, WOODS, WOODS, PAINTS[:2], STONES[:2], TILES[:1])
    p = {
        "top": top,
        "legs": legs,
        "top_thickness": round(float(rng.uniform(0.02, 0.05)), 3),
        "leg": round(float(rng.uniform(0.04, 0.08)), 3),
        "apron": round(float(rng.choice([0.0, rng.uniform(0.05, 0.1)])), 3),
        "shelf": round(shelf, 3),
        "top_colour": colour,
        "leg_colour": colour
        if rng.random() < 0.5 and finish_of(colour).material in ("wood", "paint")
        else pick(rng, WOODS, METALS),
    }
    return Draw("table", size, p)


def draw_table(rng: Rng, index: int) -> Draw:
    """Dining tables and desks."""
    legs = ["square", "tapered", "trestle", "pedestal", "splayed", "panels", "round"][index % 7]
    is_round = legs == "pedestal"
    x = float(rng.uniform(0.75, 0.95))
    y = x if is_round else float(rng.uniform(1.0, 1.8))
    size = (round(x, 3), round(y, 3), round(float(rng.uniform(0.70, 0.78)), 3))
    return _draw(rng, size, legs, "round" if is_round else "rectangle", 0.0)


def draw_coffee_table(rng: Rng, index: int) -> Draw:
    """Low tables, some with a shelf, some round."""
    legs = ["square", "splayed", "panels", "round"][index % 4]
    is_round = index % 4 == 1
    x = float(rng.uniform(0.5, 0.7))
    y = x if is_round else float(rng.uniform(0.8, 1.2))
    size = (round(x, 3), round(y, 3), round(float(rng.uniform(0.35, 0.5)), 3))
    return _draw(rng, size, legs, "round" if is_round else "rectangle", 0.25 if index % 4 in (0, 3) else 0.0)


def bed(size: Size, p: dict[str, Any]) -> Model:
    """A bed, headboard at the back (-x). Parameters: frame and mattress heights (shares), headboard (panel, slats,
    cushion), pillows, blanket (share of the length), colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    frame, lying = float(p["frame"]) * z, float(p["mattress"]) * z
    clear = 0.5 * frame
    board = 0.05
    parts = [part(box((-x + board, x), (-y, y), (clear, frame)), p["frame_colour"], SLATTED)]
    parts += [
        part(box((a, a + 0.06), (b, b + 0.06), (0, clear)), p["frame_colour"], SLATTED)
        for a in (-x + board, x - 0.06)
        for b in (-y, y - 0.06)
    ]
    if p["headboard"] == "slats":
        parts += [
            part(box((-x, -x + board), (b - 0.03, b + 0.03), (0, z)), p["frame_colour"], SLATTED)
            for b in np.linspace(-y + 0.03, y - 0.03, 7)
        ]
        parts.append(part(box((-x, -x + board), (-y, y), (0.85 * z, 0.93 * z)), p["frame_colour"], SLATTED))
    elif p["headboard"] == "cushion":
        parts.append(part(cushion((-x, -y, 0), (-x + board, y, z), 0.02), p["blanket_colour"], 300.0))
    else:
        parts.append(part(box((-x, -x + board), (-y, y), (0, z)), p["frame_colour"], SLATTED))
    inset = 0.03
    parts.append(
        part(cushion((-x + board, -y + inset, frame), (x - inset, y - inset, lying), 0.03), (0.85, 0.85, 0.83), FOAM)
    )
    start = x - inset - float(p["blanket"]) * 2 * x
    parts.append(
        part(
            cushion((start, -y + 0.01, frame + 0.3 * (lying - frame)), (x - 0.02, y - 0.01, lying + 0.03), 0.03),
            p["blanket_colour"],
            FOAM,
        )
    )
    count = int(p["pillows"])
    width = 2 * (y - inset) / count
    for k in range(count):
        low = -y + inset + k * width + 0.05
        parts.append(
            part(
                cushion((-x + board + 0.03, low, lying), (-x + board + 0.4, low + width - 0.1, lying + 0.1), 0.045),
                (0.8, 0.8, 0.82),
                FOAM,
            )
        )
    return Model(parts)


def draw_bed(rng: Rng, index: int) -> Draw:
    """Single and double."""
    double = index % 2 == 1
    size = (
        round(float(rng.uniform(1.95, 2.1)), 3),
        round(float(rng.uniform(1.4, 1.7) if double else rng.uniform(0.9, 1.1)), 3),
        round(float(rng.uniform(0.75, 1.1)), 3),
    )
    p = {
        "frame": 0.3,
        "mattress": round(float(rng.uniform(0.5, 0.58)), 3),
        "headboard": ["panel", "slats", "cushion"][index % 3],
        "pillows": 2 if double else 1,
        "blanket": round(float(rng.uniform(0.4, 0.7)), 3),
        "frame_colour": pick(rng, WOODS, PAINTS),
        "blanket_colour": pick(rng, FABRICS),
    }
    return Draw("bed", size, p)
