"""Radiators, sinks and toilets."""

from dataclasses import replace
from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.categories.vessels import Profile, hollow
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import METALS, WOODS
from roomkin.plugins.furniture.fields import between, chance, in_turn, of, one_of
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.model import METAL, PLASTIC, Model, Parts, Size, move_model
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import box, cushion, hull, lathe, rod, rotate, widen
from roomkin.stages.contracts.library import Placement

WATER = 900.0  # kg / m^3: steel with water in it
RADIATOR_WHITE = "paint 0.86 0.86 0.84 0"


class Radiator(Generator):
    """A panel with grooves, columns on feet, or a ladder of tubes for towels."""

    style: Literal["panel", "columns", "towels"] = in_turn("panel", "columns", "towels")
    pitch: float = between(0.035, 0.055)  # of grooves, columns and tubes
    colour: Coating = one_of(RADIATOR_WHITE, RADIATOR_WHITE, "paint 0.74 0.72 0.66 0", "metal 0.36 0.37 0.39 0")

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
        parts[0] = replace(parts[0], collisions=(box((-0.9 * x, 0.9 * x), (-0.98 * y, 0.98 * y), (foot, z)),))
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


CHROME = "metal 0.6 0.61 0.63 0"
WHITE = "paint 0.86 0.86 0.84 0"
SHELL = 900.0  # kg / m^3: hollow porcelain


def lift(parts: Parts, by: float, forward: float = 0.0) -> Parts:
    """The parts, higher and further to the front."""
    return Parts(move_model(Model(parts), (forward, 0.0, by)).base)


def oval(outer: Profile, wall: float, x: float, y: float, color: str | list[float]) -> Parts:
    """An open vessel whose profile of (share of half its extents, z) reaches from -x to x and from -y to y."""
    radius = min(x, y)
    made = hollow([(radius * share, z) for share, z in outer], wall, color, color, SHELL)

    def stretch(mesh: Trimesh) -> Trimesh:
        return Trimesh(mesh.vertices * [x / radius, y / radius, 1.0], mesh.faces, process=False)

    return Parts(replace(one, mesh=stretch(one.mesh), collisions=tuple(map(stretch, one.pieces))) for one in made)


def tap(x: float, z: float, height: float, color: str | list[float]) -> Parts:
    """A mixer tap that stands at (x, 0, z), its spout towards +x."""
    reach = 0.75 * height
    parts = Parts()
    parts.add(rod((x, 0, z), (x, 0, z + height), 0.014), color, METAL, smooth=True)
    spout = rod((x, 0, z + 0.75 * height), (x + reach, 0, z + 0.65 * height), 0.011)
    parts.add(spout, color, METAL, smooth=True, solid=False)
    lever = box((x - 0.01, x + 0.05), (-0.008, 0.008), (z + height - 0.012, z + height))
    parts.add(lever, color, METAL, solid=False)
    return parts


class Sink(Generator):
    """A basin with its tap: on a pedestal, hung from the wall, or for the top of a cabinet."""

    style: Literal["pedestal", "bowl", "hung", "trough"]
    square: bool = chance()  # its plan: a box, or oval
    basin: float = between(0.16, 0.2)  # metres from its underside to its rim
    tap_height: float = between(0.13, 0.18)
    colour: Coating = one_of(WHITE, WHITE, WHITE, "paint 0.74 0.72 0.66 0")
    tap_colour: Coating = of(METALS[:1], METALS[2:4])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        rise = min(self.tap_height, 0.45 * z) if self.style != "bowl" else 0.0
        rim = z - rise
        deep = rim if self.style in ("bowl", "trough") else min(self.basin, 0.6 * rim)
        low = rim - deep
        shelf = 0.2 * x if rise else 0.0  # behind the basin, where the tap stands
        parts = lift(self._basin(x - shelf / 2, y, deep), low, shelf / 2)
        if rise:
            parts.add(box((-x, -x + 2.2 * shelf), (-0.8 * y, 0.8 * y), (rim - 0.25 * deep, rim)), self.colour, SHELL)
            parts += tap(-x + 0.7 * shelf, rim, rise, self.tap_colour)
        placement: Placement = "object"
        if self.style == "pedestal":
            foot = [(1.0, 0), (1.0, 0.03 * low), (0.7, 0.12 * low), (0.62, 0.7 * low), (0.95, 1.02 * low)]
            mesh = widen(lathe([(0, 0), *foot, (0, 1.02 * low)]), 0.5 * x, 0.34 * y)
            mesh.vertices -= [0.2 * x, 0, 0]
            parts.add(mesh, self.colour, SHELL, smooth=True)
            placement = "floor"
        elif self.style == "hung":
            parts.add(rod((0, 0, 0.4 * low), (0, 0, low + 0.02), 0.018), CHROME, METAL, smooth=True)
            parts.add(rod((0, 0, 0), (0, 0, 0.45 * low), 0.032), CHROME, METAL, smooth=True)
            parts.add(rod((-x, 0, 0.55 * low), (0, 0, 0.55 * low), 0.014), CHROME, METAL, smooth=True)
            placement = "wall"
        return Model(parts, placement=placement)

    def _basin(self, x: float, y: float, z: float) -> Parts:
        floor = 0.25 * z
        if self.square:
            wall = min(0.022, 0.15 * min(x, y))
            parts = Parts()
            parts.add(box((-0.9 * x, 0.9 * x), (-0.9 * y, 0.9 * y), (0, floor)), self.colour, SHELL)
            for s in (-1, 1):
                outer = [(s * a, b, c) for a, c in ((0.9 * x, 0), (x, z), (x - wall, z), (0.9 * x - wall, 0))
                         for b in (-y, y)]  # fmt: skip
                parts.add(hull([(a, b * (1 if c else 0.9), c) for a, b, c in outer]), self.colour, SHELL)
                outer = [(a, s * b, c) for b, c in ((0.9 * y, 0), (y, z), (y - wall, z), (0.9 * y - wall, 0))
                         for a in (-x, x)]  # fmt: skip
                parts.add(hull([(a * (1 if c else 0.9), b, c) for a, b, c in outer]), self.colour, SHELL)
        else:
            profile = [(0.5, 0.0), (0.8, 0.3 * z), (0.95, 0.7 * z), (1.0, z)]
            parts = oval(profile, min(0.02, 0.15 * min(x, y)), x, y, self.colour)
            floor = min(0.02, 0.15 * min(x, y))
        parts.add(rod((0, 0, floor), (0, 0, floor + 0.004), 0.022), CHROME, METAL, solid=False)
        return parts


@category(
    "sink", templates=4, names="basin, washbasin, wash basin, bathroom sink, kitchen sink, hand basin, lavabo",
    like="washstand, faucet, tap", kin="fixture", carries="inside", places="floor, top",
)  # fmt: skip
def sample_sink(rng: Rng, index: int) -> Sampled:
    """On a pedestal, on a cabinet, at the wall, of a kitchen."""
    style = ["pedestal", "bowl", "hung", "trough"][index % 4]
    low, high = {
        "pedestal": ((0.42, 0.5, 0.95), (0.52, 0.62, 1.02)), "bowl": ((0.34, 0.4, 0.12), (0.42, 0.56, 0.16)),
        "hung": ((0.34, 0.42, 0.5), (0.46, 0.6, 0.6)), "trough": ((0.42, 0.5, 0.34), (0.5, 0.8, 0.4)),
    }[style]  # fmt: skip
    recipe = Sink.sample_parameters(rng, index, style=style)
    if style == "trough":
        recipe = recipe.change_parameters(square=True, colour=str(rng.choice([CHROME, WHITE])))
    return Sampled(round_size(*rng.uniform(low, high)), recipe)


class Toilet(Generator):
    """A bowl with its seat, the lid closed or open; a tank behind it, or all of it hung from the wall."""

    style: Literal["tank", "back", "hung"] = in_turn("tank", "back", "tank", "hung")
    open: bool = in_turn(False, False, True, False)
    lid: float = between(0.025, 0.04)  # thickness of seat and lid together
    colour: Coating = one_of(WHITE, WHITE, WHITE, "paint 0.74 0.72 0.66 0")
    lid_colour: Coating = one_of(WHITE, WHITE, str(WOODS[2]))

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        behind = 0.3 * size[0] if self.style == "tank" else 0.12 * size[0]
        seat = 0.5 * z if self.open or self.style == "tank" else z
        thick = min(self.lid, 0.15 * seat)
        rim = seat - thick
        middle, half = behind / 2, x - behind / 2
        low = 0.35 * rim if self.style == "hung" else 0.0
        profile = [(0.45, 0.0), (0.55, 0.25 * (rim - low)), (0.86, 0.7 * (rim - low)), (0.97, rim - low)]
        parts = lift(oval(profile, min(0.04, 0.2 * y), half, 0.97 * y, self.colour), low, middle)
        narrow = 0.6 * y
        parts.add(box((-x, middle - 0.35 * half), (-narrow, narrow), (low, rim)), self.colour, SHELL)
        parts += lift(self._seat(half, y, thick), rim, middle)
        hinge = -x + behind
        if self.open:
            lid = lathe([(0, 0), (1, 0), (1, 0.5 * thick), (0, 0.5 * thick)], 32)
            lid = rotate(widen(lid, 0.45 * (z - seat), 0.95 * y), np.pi / 2, [0, 1, 0])
            lid.vertices += [hinge - lid.bounds[0][0], 0, seat - lid.bounds[0][2] - 0.01]
            parts.add(lid, self.lid_colour, PLASTIC, smooth=True)
        if self.style == "tank":
            tank = cushion((-x, -0.95 * y, rim - 0.05 * z), (hinge - 0.01, 0.95 * y, 0.95 * z), 0.02)
            parts.add(tank, self.colour, SHELL)
            parts.add(cushion((-x, -y, 0.94 * z), (hinge, y, z - 0.006), 0.01), self.colour, SHELL)
            button = rod((-x + 0.5 * behind, 0, z - 0.01), (-x + 0.5 * behind, 0, z), 0.025)
            parts.add(button, CHROME, METAL, solid=False)
        return Model(parts, placement="wall" if self.style == "hung" else "floor")

    def _seat(self, x: float, y: float, thick: float) -> Parts:
        parts = Parts()
        if self.open:
            ring = lathe([(0.66, 0), (1, 0), (1, 0.5 * thick), (0.66, 0.5 * thick), (0.66, 0)], 32)
            parts.add(widen(ring, x, y), self.lid_colour, PLASTIC, smooth=True, solid=False)
            return parts
        for low, high, share in ((0.0, 0.45 * thick, 1.0), (0.5 * thick, thick, 0.98)):
            disc = lathe([(0, low), (share, low), (share, high), (0, high)], 32)
            parts.add(widen(disc, x, y), self.lid_colour, PLASTIC, smooth=True)
        return parts


TANK = ((0.62, 0.36, 0.74), (0.7, 0.42, 0.84))
TOILET = Category(
    name="toilet",
    sample=sized(Toilet, TANK, ((0.52, 0.35, 0.4), (0.58, 0.4, 0.44)), TANK, ((0.5, 0.35, 0.36), (0.56, 0.39, 0.42))),
    templates=4, names="wc, lavatory, loo, water closet, toilet bowl", like="latrine, bidet, urinal", kin="fixture",
)  # fmt: skip
