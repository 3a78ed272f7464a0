"""Sofas and armchairs; the back is at -x."""

import itertools

from pydantic import Field

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, METALS, WOODS, pick
from roomkin.plugins.furniture.model import FOAM, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, fixed, of, round_size
from roomkin.plugins.furniture.shapes import box, cushion, rod


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
        rng,
        index,
        seats=seats,
        pillows=lambda: seats > 1 and rng.random() < 0.6,
        colour=color,
        cushion_colour=lambda: color if rng.random() < 0.6 else pick(rng, FABRICS),
    )
    return Sampled(size, recipe)
