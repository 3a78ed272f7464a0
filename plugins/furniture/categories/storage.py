"""Bookshelves, boxes and books."""

import itertools
from typing import Literal

import numpy as np
from pydantic import Field

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import CARDBOARD, FABRICS, GLAZES, METALS, PAINTS, WOODS, pick
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of, one_of, whole
from roomkin.plugins.furniture.finishes import change_material, shade
from roomkin.plugins.furniture.model import PAPER, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import box, make_sides


class Bookshelf(Generator):
    """Open shelves, some with books."""

    shelves: int = Field(ge=1, le=50)
    columns: int = Field(ge=1, le=50)
    back: bool = in_turn(False, True, True)
    board: float = between(0.016, 0.03)
    frame: Literal["posts", "boards"] = in_turn("posts", "boards", "boards")
    books: float = one_of(0.0, 0.4, 0.8)  # share of the shelves that have some
    books_seed: int = whole(0, 1 << 30, ge=0)
    colour: Coating
    frame_colour: Coating = of(METALS, WOODS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        board = min(self.board, 0.06 * min(size))
        color, count, columns = self.colour, self.shelves, self.columns
        levels, parts = [k * (z - board) / count for k in range(count + 1)], Parts()
        if self.frame == "posts":
            post = 1.6 * board
            levels = [max(level, 0.06 * z) if k == 0 else level for k, level in enumerate(levels)]
            for a, b in itertools.product((-x, x - post), (-y, y - post)):
                parts.add(box((a, a + post), (b, b + post), (0, z)), self.frame_colour)
            inner = (-y, y)
        else:
            for b in (-y, y - board):
                parts.add(box((-x, x), (b, b + board), (0, z)), color)
            inner = (-y + board, y - board)
        for level in levels:
            parts.add(box((-x, x), inner, (level, level + board)), color)
        if self.back:
            parts.add(box((-x, -x + 0.006), inner, (levels[0], z)), shade(color, 0.8))
        for k in range(1, columns):
            middle = inner[0] + k * (inner[1] - inner[0]) / columns
            parts.add(box((-x, x), (middle - board / 2, middle + board / 2), (levels[0], levels[-1])), color)
        rng = np.random.default_rng(self.books_seed)
        bay = (inner[1] - inner[0]) / columns
        for low, high in itertools.pairwise(levels):
            for k in range(columns):
                if rng.random() < self.books:
                    start = inner[0] + k * bay + board
                    across = (start, start + bay - 2 * board)
                    parts += _row(rng, (-x + 0.01, x), across, low + board, high - low - board)
        return Model(parts)


def _row(rng: Rng, x: tuple[float, float], y: tuple[float, float], z: float, height: float) -> list[Part]:
    """Upright books from the left until the row is partly full."""
    parts = Parts()
    at, end = y[0], y[0] + (y[1] - y[0]) * float(rng.uniform(0.4, 1.0))
    while True:
        wide = float(rng.uniform(0.03, 0.07))
        if at + wide > end:
            return parts
        tall, deep = height * float(rng.uniform(0.6, 0.9)), (x[1] - x[0]) * float(rng.uniform(0.6, 0.85))
        book = box((x[0], x[0] + deep), (at, at + wide - 0.001), (z, z + tall))
        parts.add(book, change_material("paint", pick(rng, FABRICS, GLAZES)), PAPER)
        at += wide


@category(
    "bookshelf", templates=5, count=10, names="bookcase", like="shelf, rack, shelving", kin="storage", carries="boards"
)
def sample_bookshelf(rng: Rng, index: int) -> Sampled:
    """Narrow or wide, low or tall, with or without books."""
    columns = 1 + index % 2
    wider = [1.0, 1.5][index % 2]
    size = round_size(rng.uniform(0.26, 0.36), rng.uniform(0.55, 0.75) * wider, rng.uniform(0.9, 2.0))
    color = pick(rng, WOODS, PAINTS)
    shelves = max(2, round(size[2] / rng.uniform(0.3, 0.42)))
    return Sampled(size, Bookshelf.sample_parameters(rng, index, shelves=shelves, columns=columns, colour=color))


class Carton(Generator):
    """A box."""

    style: Literal["closed", "open", "lid", "crate"]
    wall: float
    label: bool = in_turn(True, False)
    colour: Coating
    second_colour: Coating

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        wall = min(self.wall, 0.1 * min(size))
        color, second, style = self.colour, self.second_colour, self.style
        parts = Parts()
        if style in ("closed", "lid"):
            rim = 0.006 if style == "lid" else 0.0
            parts.add(box((-x + rim, x - rim), (-y + rim, y - rim), (0, z - rim)), color, 150.0)
            if style == "lid":
                parts.add(box((-x, x), (-y, y), (0.72 * z, z)), second, 150.0)
            else:
                parts.add(box((-x, x), (-0.12 * y, 0.12 * y), (z, z + 0.001)), second, solid=False)
        else:
            slats = [(0.0, 1.0)] if style == "open" else [(0.0, 0.28), (0.36, 0.62), (0.70, 1.0)]
            parts.add(box((-x, x), (-y, y), (0, wall)), color)
            for a, b in slats:
                low, high = wall + a * (z - wall), wall + b * (z - wall)
                sides = make_sides(x, y, (low, high), wall)
                for side, shown in zip(sides, (color, color, second, second), strict=True):
                    parts.add(side, shown)
            if style == "crate":
                for a, b in itertools.product((-x + wall, x - 3 * wall), (-y + wall, y - 3 * wall)):
                    parts.add(box((a, a + 2 * wall), (b, b + 2 * wall), (wall, z)), second)
        if self.label:
            parts.add(box((x, x + 0.001), (-0.5 * y, 0.3 * y), (0.25 * z, 0.6 * z)), (0.85, 0.84, 0.80), solid=False)
        return Model(parts, symmetry="none" if self.label else "half_turn", placement="object")


@category("box", templates=4, count=10, like="carton, crate, package", kin="box", carries="top", places="floor, top")
def sample_box(rng: Rng, index: int) -> Sampled:
    """Cartons, boxes with a lid, crates."""
    style = ["closed", "open", "lid", "crate"][index % 4]
    wooden = style == "crate"
    color = pick(rng, WOODS) if wooden else pick(rng, CARDBOARD, PAINTS)
    size = round_size(*rng.uniform([0.18, 0.22, 0.12], [0.34, 0.45, 0.32]))
    second = shade(color, 0.75) if wooden else pick(rng, CARDBOARD, PAINTS)
    wall = 0.012 if wooden else 0.006
    colors = {"colour": color, "second_colour": second}
    return Sampled(size, Carton.sample_parameters(rng, index, style=style, wall=wall, **colors))


class Book(Generator):
    """A lying stack of books, spines towards +x."""

    books: int = Field(ge=1, le=50)
    shrink: float = fixed(0.08)  # of each book above another
    colours: list[Coating]

    def build(self, size: Size) -> Model:
        count = self.books
        thick = size[2] / count
        cover = min(0.004, 0.15 * thick)
        parts = Parts()
        for k in range(count):
            share = 1.0 - self.shrink * k
            x, y, low = share * size[0] / 2, share * size[1] / 2, k * thick
            color = self.colours[k]
            front = size[0] / 2 - 0.01 * (k % 2) * size[0]
            back = front - 2 * x
            pages = box((back + cover, front - cover), (-y + 0.003, y - 0.003), (low + cover, low + thick - cover))
            parts.add(pages, (0.85, 0.82, 0.72), PAPER)
            parts.add(box((back, front), (-y, y), (low, low + cover)), color, PAPER)
            parts.add(box((back, front), (-y, y), (low + thick - cover, low + thick)), color, PAPER)
            parts.add(box((front - cover, front), (-y, y), (low + cover, low + thick - cover)), color, PAPER)
        return Model(parts, placement="object")


@category("book", templates=3, count=10, like="novel", kin="box", carries="top", places="top")
def sample_book(rng: Rng, index: int) -> Sampled:
    """One to four books."""
    count = 1 + index % 4
    colors = [change_material("card", pick(rng, GLAZES, FABRICS)) for _ in range(count)]
    thick = count * rng.uniform(0.025, 0.045)
    size = round_size(rng.uniform(0.15, 0.22), rng.uniform(0.21, 0.3), thick)
    return Sampled(size, Book.sample_parameters(rng, index, books=count, colours=colors))
