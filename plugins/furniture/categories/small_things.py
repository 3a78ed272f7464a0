"""Clocks, mirrors, laptops, candlesticks."""

import itertools
from typing import Any, Literal

import numpy as np

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import METALS, PAINTS, WOODS
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of
from roomkin.plugins.furniture.finishes import DARK, shade
from roomkin.plugins.furniture.model import CERAMIC, FILLED, METAL, PLASTIC, Model, Parts, Size, move_model, part
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import box, cushion, hull, lathe, rim, rod, rotate

SILVER = (0.62, 0.68, 0.72)


class Clock(Generator):
    """A clock for the wall."""

    shape: Literal["round", "square"] = in_turn("round", "round", "square")
    rim: float = between(0.01, 0.03)
    marks: Literal[4, 12] = in_turn(12, 4, 12)
    hour: float = between(0, 1)  # turns, as the minute
    minute: float = between(0, 1)
    rim_colour: Coating = of(WOODS, METALS)
    face_colour: Coating = of(PAINTS[:2], PAINTS[4:5])
    hand_colour: Coating = fixed(list(DARK))

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        edge, radius = min(self.rim, 0.2 * min(y, z)), min(y, z / 2)
        parts = Parts()
        if self.shape == "round":
            case = rod((-x, 0, 0), (x, 0, 0), radius, segments=40)
            face = rod((0.5 * x, 0, 0), (x + 0.0005, 0, 0), radius - edge, segments=40)
        else:
            case = box((-x, x), (-y, y), (-z / 2, z / 2))
            face = box((0.5 * x, x + 0.0005), (-y + edge, y - edge), (-z / 2 + edge, z / 2 - edge))
        parts.add(case, self.rim_colour, smooth=self.shape == "round")
        parts.add(face, self.face_colour, smooth=self.shape == "round", solid=False)
        inner, count, thin = radius - edge, self.marks, 0.0015

        def hand(level: int, turn: float, start: float, end: float, half: float) -> None:
            """A mark or hand before the face, turned clockwise from noon as seen from the front; shares of it."""
            front = x + level * thin
            bar = box((front, front + thin), (-half * inner, half * inner), (start * inner, end * inner))
            parts.add(rotate(bar, turn, [1, 0, 0]), self.hand_colour, solid=False)

        for k in range(count):
            hand(0, 2 * np.pi * k / count, 0.88 - (0.12 if k % (count // 4) == 0 else 0.07), 0.9, 0.022)
        hand(1, 2 * np.pi * self.hour, -0.1, 0.5, 0.035)
        hand(2, 2 * np.pi * self.minute, -0.1, 0.78, 0.022)
        return Model(move_model(Model(parts), (0, 0, z / 2)).base, placement="wall")


@category("clock", templates=4, kin="flat", places="wall, top")
def sample_clock(rng: Rng, index: int) -> Sampled:
    """Round and square."""
    wide = uniform(rng, 0.22, 0.42)
    recipe = Clock.sample_parameters(rng, index)
    if "paint 0.1" in str(recipe.face_colour):
        recipe = recipe.change_parameters(hand_colour=[0.8, 0.8, 0.78])
    return Sampled((uniform(rng, 0.03, 0.05), wide, wide), recipe)


class Mirror(Generator):
    """A mirror in a frame, on the wall."""

    shape: Literal["rectangle", "oval", "arch"] = in_turn("rectangle", "oval", "arch")
    frame: float = between(0.015, 0.06)
    frame_colour: Coating = of(WOODS, METALS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        frame = min(self.frame, 0.15 * min(size[1], z))
        face = 0.6 * x
        parts = Parts()
        if self.shape == "rectangle":
            for strip in rim((-x, x), (-y, y), (0.0, z), frame):
                parts.add(strip, self.frame_colour)
            parts.add(box((-x, face), (-y + frame, y - frame), (frame, z - frame)), SILVER, 2400.0)
            return Model(parts, placement="wall")

        def outline(inset: float) -> list[tuple[float, float]]:
            if self.shape == "oval":
                angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
                return [((y - inset) * np.cos(a), z / 2 + (z / 2 - inset) * np.sin(a)) for a in angles]
            angles = np.linspace(0, np.pi, 20)
            crown = [((y - inset) * np.cos(a), z - y + (y - inset) * np.sin(a)) for a in angles]
            return [*crown, (-(y - inset), inset), (y - inset, inset)]

        parts.add(hull([(a, b, c) for b, c in outline(0.0) for a in (-x, x - 0.002)]), self.frame_colour)
        glass = hull([(a, b, c) for b, c in outline(frame) for a in (face, x)])
        return Model([*parts, part(glass, SILVER, 2400.0, solid=False)], placement="wall")


@category("mirror", templates=3, kin="flat", places="wall, floor")
def sample_mirror(rng: Rng, index: int) -> Sampled:
    """Rectangular, oval, arched."""
    wide, tall = rng.uniform(0.35, 0.65), rng.uniform(0.75, 1.3)
    recipe = Mirror.sample_parameters(rng, index)
    return Sampled(round_size(rng.uniform(0.025, 0.045), wide, tall), recipe)


class Laptop(Generator):
    """An open laptop, its screen facing +x."""

    lean: float  # share of the depth behind the hinge
    rim: float = between(0.006, 0.014)
    colour: Coating = of(METALS[:3])
    screen_colour: Coating = in_turn([0.03, 0.04, 0.06], [0.10, 0.16, 0.26])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        thick = min(0.014, 0.1 * z)
        hinge = -x + self.lean * size[0]
        parts = Parts()
        parts.add(cushion((hinge, -y, 0), (x, y, thick), 0.004), self.colour, 1500.0)
        deep = x - hinge
        keys = box((hinge + 0.12 * deep, hinge + 0.56 * deep), (-0.88 * y, 0.88 * y), (thick, thick + 0.001))
        pad = box((hinge + 0.64 * deep, hinge + 0.94 * deep), (-0.25 * y, 0.25 * y), (thick, thick + 0.0007))
        parts.add(keys, DARK, solid=False)
        parts.add(pad, shade(self.colour, 0.8), solid=False)
        lid = 0.007

        def plane(low: float, high: float, side: float, front: float, back: float) -> Any:
            ends = [(hinge + (-x + lid - hinge) * s, thick + (z - thick) * s) for s in (low, high)]
            return hull([(a + d, b, c) for a, c in ends for d in (back, front) for b in (-side, side)])

        parts.add(plane(0.0, 1.0, y, 0.0, -lid), self.colour, 1200.0)
        parts.add(plane(0.06, 1 - self.rim / z, y - self.rim, 0.0012, 0.0), self.screen_colour, solid=False)
        return Model(parts, placement="object")


@category("laptop", templates=3, like="computer", kin="flat", places="top")
def sample_laptop(rng: Rng, index: int) -> Sampled:
    """Small to large, more or less open."""
    wide, lean = rng.uniform(0.29, 0.38), rng.uniform(0.12, 0.3)
    size = round_size(wide * 0.68 / (1 - lean), wide, wide * rng.uniform(0.58, 0.66))
    return Sampled(size, Laptop.sample_parameters(rng, index, lean=round(lean, 3)))


class Candlestick(Generator):
    """A candle in a holder."""

    radii: list[float]  # shares, foot to cup
    candle: float = between(0.3, 0.55)  # share of the height
    metal: bool = in_turn(True, False)
    colour: Coating = of(METALS, WOODS)
    candle_colour: Coating = of(PAINTS[:2], PAINTS[7:])

    def build(self, size: Size) -> Model:
        radius, z = size[0] / 2, size[2]
        top = z * (1 - self.candle)
        shape = np.array(self.radii, dtype=float)
        levels = np.linspace(0.03, 1, len(shape)) * top
        outline = [(radius * float(r), float(a)) for r, a in zip(shape / shape.max(), levels, strict=True)]
        parts = Parts()
        parts.add(lathe([(0, 0), (outline[0][0], 0), outline[0], (0, outline[0][1])]), self.colour, METAL, smooth=True)
        for a, b in itertools.pairwise(outline):
            parts.add(lathe([(0, a[1]), a, b, (0, b[1])]), self.colour, METAL if self.metal else CERAMIC, smooth=True)
        wide = 0.8 * outline[-1][0]
        parts.add(rod((0, 0, top), (0, 0, 0.97 * z), wide, 0.94 * wide), self.candle_colour, FILLED, smooth=True)
        parts.add(rod((0, 0, 0.97 * z), (0, 0, z), 0.0015), DARK, PLASTIC, solid=False)
        return Model(parts, symmetry="full", placement="object")


@category("candlestick", templates=4, names="candle holder", like="candle, candlestand", kin="lamp", places="top")
def sample_candlestick(rng: Rng, index: int) -> Sampled:
    """Turned holders, low and tall."""
    wide, tall = rng.uniform(0.07, 0.12), rng.uniform(0.14, 0.34)
    radii = [1.0, *rng.uniform(0.14, 0.42, 3).round(3).tolist(), uniform(rng, 0.28, 0.42)]
    return Sampled(round_size(wide, wide, tall), Candlestick.sample_parameters(rng, index, radii=radii))
