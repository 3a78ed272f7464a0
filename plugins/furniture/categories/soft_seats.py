"""Armchairs, sofas, ottomans, cushions; backs are at -x."""

import itertools
from typing import Any, Literal

import numpy as np
from pydantic import Field
from trimesh import Trimesh

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, METALS, SHADES, WOODS, pick
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of
from roomkin.plugins.furniture.finishes import finish_of
from roomkin.plugins.furniture.model import FOAM, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, lathe, rod, widen

UPHOLSTERY = 100.0  # kg / m^3


class Armchair(Generator):
    """Cushions in a wooden frame (open), a high back with ears (wing), or a low round back (tub)."""

    style: Literal["open", "wing", "tub"]
    seat: float  # height, as a share of the whole
    lean: float = between(0.12, 0.25)  # of the back, as a share of the depth
    arm_height: float  # as a share of the height
    legs: float = between(0.1, 0.2)
    leg: float = between(0.035, 0.05)
    colour: Coating
    cushion_colour: Coating
    frame_colour: Coating = of(WOODS, METALS[:3])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        seat, arm = self.seat * z, self.arm_height * z
        lean = self.lean * size[0]
        if self.style == "open":
            return Model(_open(self, x, y, z, seat, arm, lean))
        legs = min(self.legs, 0.6 * seat)
        parts = Parts()
        for a, b in itertools.product((-0.82 * x, 0.82 * x), (-0.8 * y, 0.8 * y)):
            parts.add(rod((a, b, 0), (0.9 * a, 0.9 * b, legs + 0.02), 0.014, 0.022), self.frame_colour, smooth=True)
        cloth, wall = self.colour, min(0.14, 0.2 * size[1])
        low = legs + 0.45 * (seat - legs)
        parts.add(cushion((-0.95 * x, -0.95 * y, legs), (0.95 * x, 0.95 * y, low), 0.02), cloth, UPHOLSTERY)
        parts.add(cushion((-x + wall, -y + wall, low), (x - 0.01, y - wall, seat), 0.04), self.cushion_colour, FOAM)
        if self.style == "wing":
            parts.add(_lean_board(-x + lean, -x, wall, (-y + 0.4 * wall, y - 0.4 * wall), low, z), cloth, UPHOLSTERY)
            for s in (-1, 1):
                outer, inner = s * y, s * (y - wall)
                parts.add(cushion((-x + wall, outer, legs), (0.9 * x, inner, arm), 0.03), cloth, UPHOLSTERY)
                ear = [(-x + lean * (1 - arm / z), arm), (-x, z)]
                ear += [(-x + 0.3 * size[0], arm), (-x + 0.16 * size[0], 0.97 * z)]
                corners = [(a, b, c) for b in (outer, s * (y - 0.5 * wall)) for a, c in ear]
                parts.add(hull(corners), cloth, UPHOLSTERY)
            return Model(parts)
        for t in np.linspace(np.pi / 2, 3 * np.pi / 2, 8)[:-1]:  # a low wall of staves around the back, higher behind
            ends = []
            for angle in (t, t + np.pi / 7):
                rise = arm + (z - arm) * max(0.0, -np.cos(angle)) ** 0.7
                for share in (1.0, 1.0 - wall / y):
                    at = (max(x * share * 0.98 * np.cos(angle), -x), y * share * np.sin(angle))
                    ends += [(*at, legs), (*at, rise)]
            parts.add(hull(ends), cloth, UPHOLSTERY)
        for s in (-1, 1):
            parts.add(cushion((0.0, s * y, legs), (0.8 * x, s * (y - wall), arm), 0.02), cloth, UPHOLSTERY)
        return Model(parts)


def _open(p: Armchair, x: float, y: float, z: float, seat: float, arm: float, lean: float) -> list[Part]:
    """Two frames of beams, a seat and a back cushion on boards between them."""
    frame, leg = p.frame_colour, p.leg
    parts = Parts()
    for s in (-1, 1):
        b = s * (y - leg / 2)
        parts.add(beam((x - leg, b, 0), (x - 1.6 * leg, b, arm), leg), frame)
        parts.add(beam((-x + leg, b, 0), (-x + 1.6 * leg, b, arm), leg), frame)
        parts.add(box((-x, x), (b - 0.7 * leg, b + 0.7 * leg), (arm, arm + 0.6 * leg)), frame)
        parts.add(box((-x + leg, x - leg), (b - leg / 3, b + leg / 3), (seat - 0.13, seat - 0.09)), frame)
    inner = y - 1.1 * leg
    parts.add(box((-x + lean, x - 0.02), (-y + leg / 2, y - leg / 2), (seat - 0.12, seat - 0.10)), frame)
    parts.add(cushion((-x + lean, -inner, seat - 0.10), (x, inner, seat + 0.02), 0.03), p.colour, FOAM)
    parts.add(_lean_board(-x + lean + 0.06, -x, 0.1, (-inner, inner), seat, z), p.colour, FOAM)
    parts.add(_lean_board(-x + lean - 0.02, -x, 0.02, (-inner, inner), seat - 0.11, 0.9 * z), frame)
    return parts


def _lean_board(low_x: float, high_x: float, thick: float, y: tuple[float, float], low: float, high: float) -> Any:
    """A board or cushion that leans back from low_x (its rear, at the height low) to high_x."""
    return hull([(a + d, b, c) for a, c in ((low_x, low), (high_x, high)) for d in (0, thick) for b in y])


@category("armchair", templates=4, names="easychair, recliner", kin="seat", carries="seat")
def sample_armchair(rng: Rng, index: int) -> Sampled:
    """Cushions in a wooden frame, with wings, or a tub."""
    style = ["open", "wing", "tub", "open"][index % 4]
    tall = {"open": (0.74, 0.88), "wing": (0.95, 1.12), "tub": (0.68, 0.8)}[style]
    size = round_size(rng.uniform(0.68, 0.82), rng.uniform(0.62, 0.8), rng.uniform(*tall))
    color = pick(rng, FABRICS)
    recipe = Armchair.sample_parameters(
        rng, index, style=style, seat=round(rng.uniform(0.4, 0.45) / size[2], 3),
        arm_height=lambda: round(rng.uniform(0.56, 0.63) / size[2], 3), colour=color,
        cushion_colour=lambda: color if rng.random() < 0.6 else pick(rng, FABRICS),
    )  # fmt: skip
    return Sampled(size, recipe)


class Sofa(Generator):
    """Cushions between two arms."""

    seats: int = Field(ge=1, le=50)
    seat: float = fixed(0.52)  # height, as a share of the whole
    arm: float = between(0.1, 0.24)  # width
    arm_height: float = between(0.62, 0.85)  # share
    back: float = between(0.25, 0.34)  # depth
    legs: float = between(0.04, 0.14)  # height
    edge: float = between(0.015, 0.05)  # chamfer
    pillows: bool
    colour: Coating
    cushion_colour: Coating
    pillow_colour: Coating = of(FABRICS)
    leg_colour: Coating = of(WOODS, METALS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        arm, back, legs, edge = (self.arm, min(self.back, 0.4 * size[0]), min(self.legs, 0.3 * z), self.edge)
        seat, arm_top = max(self.seat * z, legs + 0.15 * z), self.arm_height * z
        cloth = self.colour
        parts = Parts()
        for a, b in itertools.product((-x + 0.06, x - 0.06), (-y + 0.06, y - 0.06)):
            parts.add(rod((a, b, 0), (a, b, legs + 0.02), 0.02, 0.028), self.leg_colour, smooth=True)
        inner = y - arm
        low = legs + 0.45 * (seat - legs)
        parts.add(box((-x + 0.02, x - 0.02), (-inner - 0.01, inner + 0.01), (legs, low)), cloth, 120.0)
        parts.add(cushion((-x, -inner, legs), (-x + 0.55 * back, inner, 0.94 * z), edge), cloth, 100.0)
        if arm > 0.03:
            for s in (-1, 1):
                parts.add(cushion((-x, s * y, legs), (x, s * inner, arm_top), edge), cloth, 100.0)
        count = self.seats
        for k in range(count):
            a, b = -inner + 2 * inner * k / count, -inner + 2 * inner * (k + 1) / count
            below = cushion((-x + 0.5 * back, a + 0.004, low), (x, b - 0.004, seat), 1.2 * edge)
            behind = cushion((-x + 0.45 * back, a + 0.006, seat), (-x + back, b - 0.006, z), 1.4 * edge)
            for mesh in (below, behind):
                parts.add(mesh, self.cushion_colour, FOAM)
        for s in (-1, 1) if self.pillows else ():
            mid = s * (inner - 0.2)
            pillow = cushion((-x + back, mid - 0.16, seat), (-x + back + 0.1, mid + 0.16, seat + 0.3), 0.04)
            parts.add(pillow, self.pillow_colour, FOAM)
        return Model(parts)


@category("sofa", templates=4, count=10, names="couch", like="settee, loveseat", kin="seat, bed", carries="seat")
def sample_sofa(rng: Rng, index: int) -> Sampled:
    """Armchair to three-seater."""
    seats = [2, 3, 1, 3][index % 4]
    size = round_size(rng.uniform(0.8, 0.98), 0.45 + 0.55 * seats + rng.uniform(-0.05, 0.15), rng.uniform(0.7, 0.9))
    color = pick(rng, FABRICS)
    recipe = Sofa.sample_parameters(
        rng, index, seats=seats, pillows=lambda: seats > 1 and rng.random() < 0.6, colour=color,
        cushion_colour=lambda: color if rng.random() < 0.6 else pick(rng, FABRICS),
    )  # fmt: skip
    return Sampled(size, recipe)


PADDED = 120.0  # kg / m^3: a padded frame
GRID = 12  # of a cushion's surface, per side


class Ottoman(Generator):
    """A padded seat without a back: a cube, a drum, a cushion on legs."""

    style: Literal["cube", "drum", "legs"] = in_turn("cube", "drum", "legs")
    lid: float = between(0.2, 0.4)  # height of the upper part, as a share
    foot: float = between(0.02, 0.05)
    colour: Coating = of(FABRICS)
    foot_colour: Coating = of(WOODS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        seam, edge = z * (1 - self.lid), 0.06 * z
        parts = Parts()
        if self.style == "drum":
            body = lathe([(0, 0), (0.94, 0), (1, 0.1 * z), (1, seam - 0.03 * z), (0.97, seam), (0, seam)], 32)
            top = lathe([(0, seam), (0.97, seam), (1, seam + 0.03 * z), (1, 0.9 * z), (0.9, z), (0, z)], 32)
            for mesh in (body, top):
                parts.add(widen(mesh, x, y), self.colour, PADDED, smooth=True)
            return Model(parts, symmetry="full" if size[0] == size[1] else "half_turn")
        low = self.foot if self.style == "cube" else seam
        parts.add(cushion((-x, -y, max(seam, low)), (x, y, z), edge), self.colour, PADDED)
        if self.style == "cube":
            parts.add(cushion((-0.98 * x, -0.98 * y, low), (0.98 * x, 0.98 * y, seam), edge), self.colour, PADDED)
        else:
            parts.add(box((-0.93 * x, 0.93 * x), (-0.93 * y, 0.93 * y), (0.8 * seam, seam)), self.foot_colour)
        for a in (-0.86 * x, 0.86 * x):
            for b in (-0.86 * y, 0.86 * y):
                reach = low if self.style == "cube" else 0.8 * seam
                parts.add(rod((a, b, 0), (a, b, reach), 0.016, 0.022), self.foot_colour)
        return Model(parts, symmetry="half_turn")


@category(
    "ottoman", templates=3, names="pouf, pouffe, footstool, foot stool, hassock", like="bean bag, beanbag", kin="seat",
    carries="seat",
)  # fmt: skip
def sample_ottoman(rng: Rng, index: int) -> Sampled:
    """Cubes with a lid, poufs, footstools."""
    wide = rng.uniform(0.42, 0.7)
    deep = wide * [rng.uniform(0.7, 1.0), 1.0, rng.uniform(0.65, 0.9)][index % 3]
    return Sampled(round_size(deep, wide, rng.uniform(0.36, 0.47)), Ottoman.sample_parameters(rng, index))


class Pillow(Generator):
    """A cushion that lies: its corners drawn out, or round."""

    style: Literal["square", "round"] = in_turn("square", "square", "round", "square")
    pinch: float = between(0.06, 0.14)  # by which the sides are drawn in
    flat: float = between(1.1, 1.4)  # how soon it is as thick as in its middle
    colour: Coating = of(FABRICS, SHADES)
    piping_colour: Coating = of(FABRICS, SHADES)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        if self.style == "round":
            angles = np.linspace(-np.pi / 2, np.pi / 2, 9)
            side = [(0.8 + 0.2 * np.cos(a), 0.5 * z * (1 + np.sin(a))) for a in angles]
            seam = lathe([(0, 0.48 * z), (1.01, 0.48 * z), (1.01, 0.52 * z), (0, 0.52 * z)], 32)
            parts = Parts()
            parts.add(widen(lathe([(0, 0), *side, (0, z)], 32), x, y), self.colour, FOAM, smooth=True)
            parts.add(widen(seam, x, y), self.piping_colour, FOAM, smooth=True, solid=False)
            return Model(parts, symmetry="full", placement="object")
        mesh = _pillow(x, y, z, self.pinch, self.flat)
        cloth = Part(mesh, finish_of(self.colour), FOAM, (hull(mesh.vertices),), True)
        return Model([cloth], symmetry="half_turn", placement="object")


def _pillow(x: float, y: float, z: float, pinch: float, flat: float) -> Trimesh:
    """Two sheets sewn together at their edges, flat in the middle of either."""
    u, v = np.meshgrid(np.linspace(-1, 1, GRID + 1), np.linspace(-1, 1, GRID + 1), indexing="ij")
    thick = np.minimum(1, flat * ((1 - u**2) * (1 - v**2)) ** 0.4)
    across = np.stack([x * u * (1 - pinch * (1 - v**2)), y * v * (1 - pinch * (1 - u**2))], axis=-1).reshape(-1, 2)
    sheets = [np.column_stack([across, z / 2 * (1 + side * thick.ravel())]) for side in (1, -1)]
    corner = np.arange((GRID + 1) ** 2).reshape(GRID + 1, GRID + 1)
    a, b, c, d = (corner[i : i + GRID, j : j + GRID].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    up = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Trimesh(np.concatenate(sheets), np.concatenate([up, up[:, ::-1] + corner.size]), process=True)


@category(
    "cushion", templates=4, names="pillow, throw pillow, couch cushion, sofa cushion, seat cushion",
    like="bolster, headrest", kin="cloth", places="top",
)  # fmt: skip
def sample_cushion(rng: Rng, index: int) -> Sampled:
    """Square ones of sofas, long ones of beds, round ones of chairs."""
    wide = rng.uniform(0.38, 0.5)
    deep = [wide, rng.uniform(0.38, 0.5), wide, wide][index % 4]
    wide = [wide, deep * rng.uniform(1.3, 1.6), wide, wide][index % 4]
    tall = rng.uniform(0.06, 0.1) if index % 4 == 2 else rng.uniform(0.11, 0.17)
    return Sampled(round_size(deep, wide, tall), Pillow.sample_parameters(rng, index))
