"""Radiators."""

from dataclasses import replace
from typing import Literal

from roomkin.plugins.furniture.category import Category, sized
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.model import METAL, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, between, in_turn, one_of
from roomkin.plugins.furniture.shapes import box, hull, rod

WATER = 900.0  # kg / m^3: steel with water in it
WHITE = "paint 0.86 0.86 0.84 0"


class Radiator(Generator):
    """A panel with grooves, columns on feet, or a ladder of tubes for towels."""

    style: Literal["panel", "columns", "towels"] = in_turn("panel", "columns", "towels")
    pitch: float = between(0.035, 0.055)  # of grooves, columns and tubes
    colour: Coating = one_of(WHITE, WHITE, "paint 0.74 0.72 0.66 0", "metal 0.36 0.37 0.39 0")

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        build = {"panel": self._panel, "columns": self._columns, "towels": self._towels}[self.style]
        return Model(build(x, y, z), placement="floor" if self.style == "columns" else "wall")

    def _panel(self, x: float, y: float, z: float) -> Parts:
        parts = Parts()
        deep = max(x - 0.035, 0.2 * x)
        parts.add(box((deep, x - 0.01), (-y, y), (0, z - 0.01)), shade(self.colour, 0.8), WATER)
        parts.add(box((-x, deep), (-0.97 * y, 0.97 * y), (0.04 * z, z - 0.02)), shade(self.colour, 0.5), 150.0)
        parts.add(box((-x, x - 0.004), (-y, y), (z - 0.012, z)), shade(self.colour, 0.92), METAL, solid=False)
        count = max(2, round(2 * y / self.pitch))
        step = 2 * y / count
        for k in range(count):
            a = -y + (k + 0.5) * step
            rib = box((x - 0.012, x), (a - 0.36 * step, a + 0.36 * step), (0.05 * z, 0.93 * z))
            parts.add(rib, self.colour, WATER, solid=False)
        return parts

    def _columns(self, x: float, y: float, z: float) -> Parts:
        parts = Parts()
        count = max(3, round(2 * y / (1.3 * self.pitch)))
        step = 2 * y / count
        foot = 0.1 * z
        for k in range(count):
            a = -y + (k + 0.5) * step
            for b in (-0.62 * x, 0.0, 0.62 * x):
                column = rod((b, a, foot + 0.03 * z), (b, a, z - 0.03 * z), 0.19 * x)
                parts.add(column, self.colour, WATER, smooth=True, solid=False)
            fin = [(b, a + side * 0.42 * step, c) for b, c in ((-0.8 * x, foot), (0.8 * x, foot)) for side in (-1, 1)]
            fin += [(b, p, c + 0.07 * z) for b, p, c in fin]
            for lift in (0.0, z - foot - 0.07 * z):
                parts.add(hull([(b * 1.25, p, c + lift) for b, p, c in fin]), self.colour, WATER, solid=False)
            for b in (-0.62 * x, 0.62 * x) if k in (0, count - 1) else ():
                leg = rod((b, a, 0), (b, a, foot + 0.02 * z), 0.2 * x, 0.16 * x)
                parts.add(leg, self.colour, WATER, smooth=True)
        core = box((-0.9 * x, 0.9 * x), (-0.98 * y, 0.98 * y), (foot, z))
        parts[0] = replace(parts[0], collisions=(core,))
        return parts

    def _towels(self, x: float, y: float, z: float) -> Parts:
        parts = Parts()
        for s in (-1, 1):
            parts.add(box((0.0, x), (s * (y - 0.03), s * y), (0, z)), self.colour, WATER)
            for level in (0.15 * z, 0.85 * z):
                arm = rod((-x, s * (y - 0.015), level), (0, s * (y - 0.015), level), 0.01)
                parts.add(arm, self.colour, METAL, smooth=True)
        count = max(3, round(0.8 * z / self.pitch))
        for k in range(count):
            if k % 7 == 5:
                continue  # where a towel is pulled through
            level = 0.03 * z + (k + 0.5) / count * 0.94 * z
            tube = rod((0.5 * x, -y + 0.02, level), (0.5 * x, y - 0.02, level), min(0.011, 0.5 * x))
            parts.add(tube, self.colour, WATER, smooth=True)
        return parts


RADIATOR = Category(
    name="radiator",
    sample=sized(  # panels by EN 442
        Radiator,
        ((0.065, 0.6, 0.4), (0.12, 1.6, 0.62)),
        ((0.11, 0.5, 0.55), (0.17, 1.1, 0.8)),
        ((0.07, 0.45, 0.8), (0.1, 0.6, 1.5)),
    ),
    templates=3,
    names="heater, panel heater, towel radiator, towel warmer",
    like="convector, heating",
    kin="fixture",
    places="wall",
)
