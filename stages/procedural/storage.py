"""Bookshelves, boxes and books."""

import itertools
from typing import Any

import numpy as np

from stages.procedural.colours import CARDBOARD, FABRICS, GLAZES, METALS, PAINTS, WOODS, pick
from stages.procedural.finishes import made_of, shade
from stages.procedural.model import PAPER, Draw, Model, Part, Size, part
from stages.procedural.shapes import box

Rng = np.random.Generator


def bookshelf(size: Size, p: dict[str, Any]) -> Model:
    """Open shelves. Parameters: shelves, columns, back, board, frame (boards, posts), books (share of shelves that have
    some), books_seed, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    board = min(float(p["board"]), 0.06 * min(size))
    colour, count, columns = p["colour"], int(p["shelves"]), int(p["columns"])
    levels = [k * (z - board) / count for k in range(count + 1)]
    if p["frame"] == "posts":
        post = 1.6 * board
        levels = [max(level, 0.06 * z) if k == 0 else level for k, level in enumerate(levels)]
        parts = [
            part(box((a, a + post), (b, b + post), (0, z)), p["frame_colour"])
            for a in (-x, x - post)
            for b in (-y, y - post)
        ]
        inner = (-y, y)
    else:
        parts = [part(box((-x, x), (b, b + board), (0, z)), colour) for b in (-y, y - board)]
        inner = (-y + board, y - board)
    parts += [part(box((-x, x), inner, (level, level + board)), colour) for level in levels]
    if p["back"]:
        parts.append(part(box((-x, -x + 0.006), inner, (levels[0], z)), shade(colour, 0.8)))
    for k in range(1, columns):
        middle = inner[0] + k * (inner[1] - inner[0]) / columns
        parts.append(part(box((-x, x), (middle - board / 2, middle + board / 2), (levels[0], levels[-1])), colour))
    rng = np.random.default_rng(int(p["books_seed"]))
    bay = (inner[1] - inner[0]) / columns
    for low, high in itertools.pairwise(levels):
        for k in range(columns):
            if rng.random() < float(p["books"]):
                start = inner[0] + k * bay + board
                parts += _row(rng, (-x + 0.01, x), (start, start + bay - 2 * board), low + board, high - low - board)
    return Model(parts)


def _row(rng: Rng, x: tuple[float, float], y: tuple[float, float], z: float, height: float) -> list[Part]:
    """Upright books from the left until the row is partly full."""
    parts: list[Part] = []
    at, end = y[0], y[0] + (y[1] - y[0]) * float(rng.uniform(0.4, 1.0))
    while True:
        wide = float(rng.uniform(0.03, 0.07))
        if at + wide > end:
            return parts
        tall, deep = height * float(rng.uniform(0.6, 0.9)), (x[1] - x[0]) * float(rng.uniform(0.6, 0.85))
        parts.append(
            part(
                box((x[0], x[0] + deep), (at, at + wide - 0.001), (z, z + tall)),
                made_of("paint", pick(rng, FABRICS, GLAZES)),
                PAPER,
            )
        )
        at += wide


def draw_bookshelf(rng: Rng, index: int) -> Draw:
    """Narrow or wide, low or tall, with or without books."""
    columns = 1 + index % 2
    size = (
        round(float(rng.uniform(0.26, 0.36)), 3),
        round(float(rng.uniform(0.55, 0.75)) * (1.5 if columns == 2 else 1.0), 3),
        round(float(rng.uniform(0.9, 2.0)), 3),
    )
    colour = pick(rng, WOODS, PAINTS)
    p = {
        "shelves": max(2, round(size[2] / float(rng.uniform(0.3, 0.42)))),
        "columns": columns,
        "back": bool(index % 3),
        "board": round(float(rng.uniform(0.016, 0.03)), 3),
        "frame": "posts" if index % 3 == 0 else "boards",
        "books": round(float(rng.choice([0.0, 0.4, 0.8])), 2),
        "books_seed": int(rng.integers(1 << 30)),
        "colour": colour,
        "frame_colour": pick(rng, METALS, WOODS),
    }
    return Draw("bookshelf", size, p)


def carton(size: Size, p: dict[str, Any]) -> Model:
    """A box. Parameters: style (closed, open, lid, crate), wall, label, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    wall = min(float(p["wall"]), 0.1 * min(size))
    colour, second, style = p["colour"], p["second_colour"], p["style"]
    parts: list[Part] = []
    if style in ("closed", "lid"):
        rim = 0.006 if style == "lid" else 0.0
        parts.append(part(box((-x + rim, x - rim), (-y + rim, y - rim), (0, z - rim)), colour, 150.0))
        if style == "lid":
            parts.append(part(box((-x, x), (-y, y), (0.72 * z, z)), second, 150.0))
        else:
            parts.append(part(box((-x, x), (-0.12 * y, 0.12 * y), (z, z + 0.001)), second, solid=False))
    else:
        slats = [(0.0, 1.0)] if style == "open" else [(0.0, 0.28), (0.36, 0.62), (0.70, 1.0)]
        parts.append(part(box((-x, x), (-y, y), (0, wall)), colour))
        for a, b in slats:
            low, high = wall + a * (z - wall), wall + b * (z - wall)
            parts += [part(box((s * x, s * (x - wall)), (-y, y), (low, high)), colour) for s in (-1, 1)]
            parts += [part(box((-x + wall, x - wall), (s * y, s * (y - wall)), (low, high)), second) for s in (-1, 1)]
        if style == "crate":
            parts += [
                part(box((a, a + 2 * wall), (b, b + 2 * wall), (wall, z)), second)
                for a in (-x + wall, x - 3 * wall)
                for b in (-y + wall, y - 3 * wall)
            ]
    if p["label"]:
        parts.append(
            part(box((x, x + 0.001), (-0.5 * y, 0.3 * y), (0.25 * z, 0.6 * z)), (0.85, 0.84, 0.80), solid=False)
        )
    return Model(parts, symmetry="none" if p["label"] else "half_turn", placement="object")


def draw_box(rng: Rng, index: int) -> Draw:
    """Cartons, boxes with a lid, crates."""
    style = ["closed", "open", "lid", "crate"][index % 4]
    wooden = style == "crate"
    colour = pick(rng, WOODS) if wooden else pick(rng, CARDBOARD, PAINTS)
    x, y, z = (round(float(v), 3) for v in rng.uniform([0.18, 0.22, 0.12], [0.34, 0.45, 0.32]))
    p = {
        "style": style, "wall": 0.012 if wooden else 0.006, "label": bool(index % 2 == 0), "colour": colour,
        "second_colour": shade(colour, 0.75) if wooden else pick(rng, CARDBOARD, PAINTS),
    }  # fmt: skip
    return Draw("carton", (x, y, z), p)


def book(size: Size, p: dict[str, Any]) -> Model:
    """A lying stack of books, spines towards +x.

    Parameters: books (1 or more), shrink (per book), colours (of each).
    """
    count = int(p["books"])
    thick = size[2] / count
    cover = min(0.004, 0.15 * thick)
    parts: list[Part] = []
    for k in range(count):
        share = 1.0 - float(p["shrink"]) * k
        x, y, low = share * size[0] / 2, share * size[1] / 2, k * thick
        colour = p["colours"][k]
        front = size[0] / 2 - 0.01 * (k % 2) * size[0]
        back = front - 2 * x
        parts.append(
            part(
                box((back + cover, front - cover), (-y + 0.003, y - 0.003), (low + cover, low + thick - cover)),
                (0.85, 0.82, 0.72),
                PAPER,
            )
        )
        covers = [
            ((back, front), (low, low + cover)),
            ((back, front), (low + thick - cover, low + thick)),
            ((front - cover, front), (low + cover, low + thick - cover)),
        ]
        parts += [part(box(a, (-y, y), b), colour, PAPER) for a, b in covers]
    return Model(parts, placement="object")


def draw_book(rng: Rng, index: int) -> Draw:
    """One to four books."""
    count = 1 + index % 4
    colours = [made_of("card", pick(rng, GLAZES, FABRICS)) for _ in range(count)]
    thick = count * float(rng.uniform(0.025, 0.045))
    size = (round(float(rng.uniform(0.15, 0.22)), 3), round(float(rng.uniform(0.21, 0.3)), 3), round(thick, 3))
    return Draw("book", size, {"books": count, "shrink": 0.08, "colours": colours})
