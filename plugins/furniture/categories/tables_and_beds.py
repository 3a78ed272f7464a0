"""Tables, coffee tables and beds."""

import itertools
from typing import Literal

import numpy as np

from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import FABRICS, METALS, PAINTS, STONES, TILES, WOODS, pick
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of, zero_or
from roomkin.plugins.furniture.finishes import Surface, finish_of
from roomkin.plugins.furniture.model import FOAM, METAL, Model, Part, Parts, Size, part
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import beam, box, cushion, lathe, rod, widen

SLATTED = 180.0  # kg / m^3: a bed frame is not solid

Legs = Literal["square", "round", "tapered", "splayed", "panels", "pedestal", "trestle"]


class Table(Generator):
    """A top on legs."""

    top: Literal["rectangle", "round"]
    legs: Legs
    top_thickness: float = between(0.02, 0.05)
    leg: float = between(0.04, 0.08)
    apron: float = zero_or(0.05, 0.1)  # height; 0: none
    shelf: float  # height, as a share; 0: none
    top_colour: Coating
    leg_colour: Coating

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        thick = min(self.top_thickness, 0.2 * z)
        under = z - thick
        leg = min(self.leg, 0.2 * min(size))
        round_top = self.top == "round"
        parts = Parts()
        if round_top:
            mesh = lathe([(0, under), (x, under), (x, z), (0, z)], 32)
            parts.add(widen(mesh, 1.0, y / x), self.top_colour, smooth=True)
        else:
            parts.add(box((-x, x), (-y, y), (under, z)), self.top_colour)
        reach = 0.62 if round_top else 1.0
        ax, ay = reach * x - leg * 0.9, reach * y - leg * 0.9
        parts += supports(self.legs, ax, ay, under, leg, self.leg_colour)
        legged = self.legs in ("square", "round", "tapered", "splayed")
        apron = min(self.apron, 0.3 * z)
        if apron and legged and not round_top:
            for s in (-1, 1):
                parts.add(box((-ax, ax), (s * ay - 0.01, s * ay + 0.01), (under - apron, under)), self.leg_colour)
            for s in (-1, 1):
                parts.add(box((s * ax - 0.01, s * ax + 0.01), (-ay, ay), (under - apron, under)), self.leg_colour)
        if self.shelf and legged:
            level = self.shelf * z
            parts.add(box((-ax, ax), (-ay, ay), (level, level + 0.6 * thick)), self.top_colour)
        square = abs(size[0] - size[1]) < 1e-6
        if round_top and self.legs == "pedestal" and square:
            return Model(parts, symmetry="full")
        plain = self.legs not in ("panels", "trestle")
        return Model(parts, symmetry="quarter_turn" if square and plain else "half_turn")


def supports(style: Legs, ax: float, ay: float, top: float, leg: float, color: Surface) -> list[Part]:
    """Legs at (+-ax, +-ay) up to `top`; panels, trestle and pedestal where those styles have them."""
    corners = [(sx, sy) for sx in (-1, 1) for sy in (-1, 1)]
    if style == "round":
        return [part(rod((a * ax, b * ay, 0), (a * ax, b * ay, top), leg / 2), color, smooth=True) for a, b in corners]
    if style in ("square", "tapered"):
        tip = leg if style == "square" else 0.55 * leg
        return [part(beam((a * ax, b * ay, 0), (a * ax, b * ay, top), tip, leg), color) for a, b in corners]
    if style == "splayed":
        lean, thin, wide = 0.7, 0.3 * leg, 0.5 * leg
        rods = [rod((a * ax, b * ay, 0), (lean * a * ax, lean * b * ay, top), thin, wide) for a, b in corners]
        return [part(mesh, color, smooth=True) for mesh in rods]
    if style == "panels":
        return [part(box((-ax, ax), (s * ay - leg / 3, s * ay + leg / 3), (0, top)), color) for s in (-1, 1)]
    if style == "trestle":
        sides = [(s * 0.75 * ay - leg / 2, s * 0.75 * ay + leg / 2) for s in (-1, 1)]
        feet = [box((-ax, ax), side, (0, 0.06 * top)) for side in sides]
        posts = [box((-leg, leg), side, (0.06 * top, top)) for side in sides]
        bar = box((-leg / 3, leg / 3), (-0.75 * ay, 0.75 * ay), (0.3 * top, 0.3 * top + 1.2 * leg))
        return [part(mesh, color) for mesh in (*feet, *posts, bar)]
    wide = min(ax, ay)
    foot = lathe([(0, 0), (0.8 * wide, 0), (0.75 * wide, 0.03 * top), (leg * 0.8, 0.10 * top), (0, 0.10 * top)])
    post = rod((0, 0, 0.08 * top), (0, 0, top), 0.7 * leg)
    return [part(foot, color, METAL, smooth=True), part(post, color, smooth=True)]


def _sample_table(rng: Rng, index: int, legs: str, top: str, shelf: float) -> Table:
    color = pick(rng, WOODS, WOODS, PAINTS[:2], STONES[:2], TILES[:1])

    def pick_leg_color() -> str:
        same = rng.random() < 0.5 and finish_of(color).material in ("wood", "paint")
        return color if same else pick(rng, WOODS, METALS)

    given = {"top": top, "legs": legs, "shelf": shelf, "top_colour": color, "leg_colour": pick_leg_color}
    return Table.sample_parameters(rng, index, **given)


@category("table", templates=5, count=10, like="counter, countertop, worktop, island", kin="table", carries="top")
def sample_table(rng: Rng, index: int) -> Sampled:
    """Dining tables and desks."""
    legs = ["square", "tapered", "trestle", "pedestal", "splayed", "panels", "round"][index % 7]
    is_round = legs == "pedestal"
    x = rng.uniform(0.75, 0.95)
    size = round_size(x, x if is_round else rng.uniform(1.0, 1.8), rng.uniform(0.70, 0.78))
    return Sampled(size, _sample_table(rng, index, legs, "round" if is_round else "rectangle", 0.0))


@category(
    "coffee_table", templates=4, count=10,
    names="table coffee, low table, tea table, cocktail table, center table, centre table", kin="table", carries="top",
)  # fmt: skip
def sample_coffee_table(rng: Rng, index: int) -> Sampled:
    """Low tables, some with a shelf, some round."""
    legs = ["square", "splayed", "panels", "round"][index % 4]
    is_round = index % 4 == 1
    x = rng.uniform(0.5, 0.7)
    size = round_size(x, x if is_round else rng.uniform(0.8, 1.2), rng.uniform(0.35, 0.5))
    shelf = [0.25, 0.0, 0.0, 0.25][index % 4]
    return Sampled(size, _sample_table(rng, index, legs, "round" if is_round else "rectangle", shelf))


class Bed(Generator):
    """A bed, headboard at the back (-x)."""

    frame: float = fixed(0.3)  # height, as a share
    mattress: float = between(0.5, 0.58)  # height, as a share
    headboard: Literal["panel", "slats", "cushion"] = in_turn("panel", "slats", "cushion")
    pillows: int = in_turn(1, 2)
    blanket: float = between(0.4, 0.7)  # share of the length
    frame_colour: Coating = of(WOODS, PAINTS)
    blanket_colour: Coating = of(FABRICS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        frame, lying = self.frame * z, self.mattress * z
        clear = 0.5 * frame
        board = 0.05
        parts = Parts()
        parts.add(box((-x + board, x), (-y, y), (clear, frame)), self.frame_colour, SLATTED)
        for a, b in itertools.product((-x + board, x - 0.06), (-y, y - 0.06)):
            parts.add(box((a, a + 0.06), (b, b + 0.06), (0, clear)), self.frame_colour, SLATTED)
        if self.headboard == "slats":
            for b in np.linspace(-y + 0.03, y - 0.03, 7):
                parts.add(box((-x, -x + board), (b - 0.03, b + 0.03), (0, z)), self.frame_colour, SLATTED)
            parts.add(box((-x, -x + board), (-y, y), (0.85 * z, 0.93 * z)), self.frame_colour, SLATTED)
        elif self.headboard == "cushion":
            parts.add(cushion((-x, -y, 0), (-x + board, y, z), 0.02), self.blanket_colour, 300.0)
        else:
            parts.add(box((-x, -x + board), (-y, y), (0, z)), self.frame_colour, SLATTED)
        inset = 0.03
        mattress = cushion((-x + board, -y + inset, frame), (x - inset, y - inset, lying), 0.03)
        parts.add(mattress, (0.85, 0.85, 0.83), FOAM)
        start, low = x - inset - self.blanket * 2 * x, frame + 0.3 * (lying - frame)
        blanket = cushion((start, -y + 0.01, low), (x - 0.02, y - 0.01, lying + 0.03), 0.03)
        parts.add(blanket, self.blanket_colour, FOAM)
        width = 2 * (y - inset) / self.pillows
        for k in range(self.pillows):
            left = -y + inset + k * width + 0.05
            right = left + width - 0.1
            pillow = cushion((-x + board + 0.03, left, lying), (-x + board + 0.4, right, lying + 0.1), 0.045)
            parts.add(pillow, (0.8, 0.8, 0.82), FOAM)
        return Model(parts)


BED = Category(
    name="bed", sample=sized(Bed, ((1.95, 0.9, 0.75), (2.1, 1.1, 1.1)), ((1.95, 1.4, 0.75), (2.1, 1.7, 1.1))),
    templates=3, count=10, kin="bed", carries="seat",
)  # fmt: skip
