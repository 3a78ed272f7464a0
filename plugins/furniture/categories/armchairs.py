"""Armchairs; the back is at -x."""

import itertools
from typing import Any, Literal

import numpy as np

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, METALS, WOODS, pick
from roomkin.plugins.furniture.model import FOAM, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, of, round_size
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, rod

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
        rng,
        index,
        style=style,
        seat=round(rng.uniform(0.4, 0.45) / size[2], 3),
        arm_height=lambda: round(rng.uniform(0.56, 0.63) / size[2], 3),
        colour=color,
        cushion_colour=lambda: color if rng.random() < 0.6 else pick(rng, FABRICS),
    )
    return Sampled(size, recipe)
