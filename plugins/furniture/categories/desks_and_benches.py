"""Desks with drawers, benches, shelves on the wall."""

from typing import Literal

import numpy as np

from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.categories.tables_and_beds import Legs, supports
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import FABRICS, METALS, PAINTS, WOODS, pick
from roomkin.plugins.furniture.fields import between, chance, in_turn, of, one_of, sampled_by, whole
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.fronts import HANDLE_SHARES, HANDLES, STYLES, PanelStyle, Style
from roomkin.plugins.furniture.model import FOAM, METAL, Model, Moving, Parts, Size, move_model
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import beam, box, cushion

RIM = 0.012  # between the top's rim and a pedestal's handles


class Desk(Generator):
    """A top, legs, and pedestals of drawers beside the knees; drawers open towards +x."""

    pedestals: Literal["none", "left", "right", "both"] = in_turn("right", "both", "none", "left")
    pedestal_width: float = between(0.33, 0.42)
    drawers: int = whole(2, 5, ge=1, le=50)  # of each pedestal
    legs: Literal["square", "panels"] = one_of("square", "panels")
    top_thickness: float = between(0.02, 0.04)
    leg: float = between(0.04, 0.06)
    modesty: bool = chance()  # a board at the back
    raised: float = sampled_by(lambda rng, index: uniform(rng, 0.18, 0.3) if index % 3 == 2 else 0.0)  # shelf on top
    handle: Style = one_of(*HANDLES[:4], shares=list(np.array(HANDLE_SHARES[:4]) / sum(HANDLE_SHARES[:4])))
    panel: PanelStyle = one_of("flat", "frame", "raised")
    top_colour: Coating
    front_colour: Coating
    body_colour: Coating
    leg_colour: Coating
    handle_colour: Coating = of(METALS)

    @property
    def fronts(self) -> tuple[int, int]:
        return 0, {"none": 0, "both": 2}.get(self.pedestals, 1) * self.drawers

    def build(self, size: Size) -> Model:
        x, y, high = size[0] / 2, size[1] / 2, size[2]
        z = high - min(self.raised, 0.3 * high)
        thick = min(self.top_thickness, 0.1 * z)
        under, leg = z - thick, min(self.leg, 0.1 * min(size))
        parts = Parts()
        parts.add(box((-x, x), (-y, y), (under, z)), self.top_colour)
        moving: list[Moving] = []
        wide = min(self.pedestal_width, 0.3 * size[1])
        for side in (-1, 1):
            if self.pedestals in ("both", "left" if side < 0 else "right"):
                unit = _pedestal(self).build((size[0] - 2 * RIM, wide, under))
                unit = move_model(unit, (0.0, side * (y - wide / 2 - RIM), 0.0), f"_{'l' if side < 0 else 'r'}")
                parts += unit.base
                moving += unit.moving
            elif self.legs == "panels":
                span = (side * (y - 0.5 * leg), side * (y - 1.1 * leg))
                parts.add(box((-x + 0.02, x - 0.04), span, (0, under)), self.leg_colour)
            else:
                b = side * (y - leg)
                for a in (-x + leg, x - leg):
                    parts.add(beam((a, b, 0), (a, b, under), 0.7 * leg, leg), self.leg_colour)
        if self.modesty:
            rim = y - wide - 2 * RIM if self.pedestals == "both" else y - 1.2 * leg
            left = -(y - wide - 2 * RIM) if self.pedestals in ("left", "both") else -rim
            right = y - wide - 2 * RIM if self.pedestals in ("right", "both") else rim
            parts.add(box((-x + 0.03, -x + 0.045), (left, right), (0.45 * under, under)), self.leg_colour)
        if z < high:
            parts.add(box((-x, -x + 0.45 * x), (-y, y), (high - 0.02, high)), self.top_colour)
            for span in ((-y, -y + 0.02), (-0.01, 0.01), (y - 0.02, y)):
                parts.add(box((-x, -x + 0.45 * x), span, (z, high - 0.02)), self.top_colour)
        return Model(parts, moving)


@category("desk", templates=4, like="workbench, workstation", kin="table", carries="top")
def sample_desk(rng: Rng, index: int) -> Sampled:
    """With one pedestal, with two, without, with a shelf on top."""
    top, front = pick(rng, WOODS, PAINTS[:2]), pick(rng, WOODS, PAINTS)
    recipe = Desk.sample_parameters(
        rng, index, top_colour=top, front_colour=front, body_colour=shade(front, 0.85),
        leg_colour=lambda: top if rng.random() < 0.6 else pick(rng, METALS),
    )  # fmt: skip
    wide = rng.uniform(1.35, 1.7) if recipe.pedestals == "both" else rng.uniform(1.0, 1.5)
    high = rng.uniform(0.72, 0.77) + recipe.raised
    return Sampled(round_size(rng.uniform(0.55, 0.75), wide, high), recipe)


def _pedestal(desk: Desk) -> Cabinet:
    """The drawer unit of a desk."""
    front, body = desk.front_colour, desk.body_colour
    return Cabinet(
        layout=[["drawer"] * desk.drawers], drawer_weight=1.0, open_weight=1.0, hinge=1, panel=desk.panel,
        handle=desk.handle, handle_length=0.4, handle_at=0.0, handle_inset=0.04, board=0.016, front_thickness=0.018,
        base="plinth", base_height=0.04, top=0.0, top_thickness=0.02, shelves=0, front_colour=front, body_colour=body,
        handle_colour=desk.handle_colour, field_colour=shade(front, 0.85), top_colour=front, base_colour=body,
        protrusion=STYLES[desk.handle].protrusion,
    )  # fmt: skip


class Bench(Generator):
    """A long seat."""

    seat: Literal["board", "slats", "padded"] = in_turn("board", "slats", "padded", "slats")
    legs: Legs = in_turn("square", "panels", "splayed", "square", "tapered")
    leg: float = between(0.04, 0.07)
    thickness: float = between(0.03, 0.06)
    back: float  # height of the seat as a share of the whole; 1: no back
    slats: int = whole(3, 6, ge=1, le=50)
    seat_colour: Coating = of(WOODS, PAINTS[:3])
    leg_colour: Coating = of(WOODS, METALS)
    cushion_colour: Coating = of(FABRICS)

    def build(self, size: Size) -> Model:
        x, y, high = size[0] / 2, size[1] / 2, size[2]
        z = high * min(self.back, 1.0)
        thick = min(self.thickness, 0.25 * z)
        under, leg = z - thick, min(self.leg, 0.2 * size[0])
        parts = Parts()
        if self.seat == "slats":
            pitch = size[0] / self.slats
            for k in range(self.slats):
                across = (-x + k * pitch + 0.004, -x + (k + 1) * pitch - 0.004)
                parts.add(box(across, (-y, y), (under, z)), self.seat_colour)
            for b in (-0.8 * y, 0.8 * y):
                parts.add(box((-x + 0.01, x - 0.01), (b - 0.02, b + 0.02), (under - 0.03, under)), self.leg_colour)
        elif self.seat == "padded":
            parts.add(box((-x + 0.01, x - 0.01), (-y + 0.01, y - 0.01), (under, under + 0.02)), self.leg_colour)
            parts.add(cushion((-x, -y, under + 0.02), (x, y, z), 0.02), self.cushion_colour, FOAM)
        else:
            parts.add(box((-x, x), (-y, y), (under, z)), self.seat_colour)
        parts += supports(self.legs, x - 0.9 * leg, y - 0.9 * leg, under, leg, self.leg_colour)
        if z < high:
            posts = np.linspace(-0.9 * y, 0.9 * y, 3)
            for b in posts:
                parts.add(beam((-x + 0.05, b, z), (-x + 0.015, b, high), 0.035, 0.03), self.leg_colour)
            rise = high - z
            for a, b in ((0.25, 0.5), (0.62, 0.92)):
                parts.add(box((-x + 0.035, -x + 0.055), (-y, y), (z + a * rise, z + b * rise)), self.seat_colour)
            return Model(parts)
        return Model(parts, symmetry="half_turn")


@category("bench", templates=4, kin="seat", carries="seat")
def sample_bench(rng: Rng, index: int) -> Sampled:
    """A board, slats, padded; some with a back."""
    back = index % 4 == 3
    tall = (0.78, 0.9) if back else (0.42, 0.48)
    size = round_size(rng.uniform(0.32, 0.45), rng.uniform(0.9, 1.5), rng.uniform(*tall))
    recipe = Bench.sample_parameters(rng, index, back=round(0.45 / size[2], 3) if back else 1.0)
    if recipe.seat == "padded":
        recipe = recipe.change_parameters(thickness=uniform(rng, 0.07, 0.1))
    return Sampled(size, recipe)


class WallShelf(Generator):
    """Boards on the wall."""

    style: Literal["brackets", "box", "ladder"] = in_turn("brackets", "box", "ladder", "brackets", "box")
    boards: int = in_turn(1, 1, 3, 2, 2, ge=1, le=50)
    thickness: float = between(0.016, 0.035)
    brackets: int = whole(2, 4, ge=1, le=50)
    colour: Coating = of(WOODS, PAINTS)
    second_colour: Coating = of(METALS, PAINTS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        thick, count, parts = min(self.thickness, 0.2 * z), self.boards, Parts()
        if self.style == "box":
            levels = np.linspace(0, z - thick, count + 1)
            for s in (-1, 1):
                parts.add(box((-x, x), (s * y, s * (y - thick)), (0, z)), self.colour)
            for a in levels:
                parts.add(box((-x, x), (-y + thick, y - thick), (a, a + thick)), self.colour)
            parts.add(box((-x, -x + 0.005), (-y + thick, y - thick), (thick, z - thick)), self.second_colour)
            return Model(parts, placement="wall")
        places = np.linspace(-0.7 * y, 0.7 * y, self.brackets)
        if self.style == "ladder":
            levels = np.linspace(0.04 * z, z - thick - 0.08 * z, count)
            for b in places:
                parts.add(box((-x, -x + 0.012), (b - 0.015, b + 0.015), (0, z)), self.second_colour, METAL)
            arms = [((-x + 0.012, 0.8 * x), (b - 0.008, b + 0.008), (a - 0.012, a)) for a in levels for b in places]
            for arm in arms:
                parts.add(box(*arm), self.second_colour, METAL)
        else:
            drop = min(0.6 * size[0], 0.75 * z / count)
            levels = np.linspace(drop, z - thick, count) if count > 1 else np.array([z - thick])
            for a in levels:
                low = a - drop if count > 1 else 0.0
                for b in places:
                    parts.add(box((-x, -x + 0.012), (b - 0.012, b + 0.012), (low, a)), self.second_colour)
                for b in places:
                    parts.add(beam((-x + 0.012, b, low + 0.012), (0.7 * x, b, a - 0.006), 0.014), self.second_colour)
        for a in levels:
            parts.add(box((-x + 0.012, x), (-y, y), (a, a + thick)), self.colour)
        return Model(parts, placement="wall")


HEIGHTS = (0.22, 0.3, 0.85, 0.5, 0.6)  # about, of the styles in turn
WALL_SHELF = Category(
    name="wall_shelf",
    sample=sized(WallShelf, *(((0.18, 0.5, 0.85 * high), (0.28, 1.1, 1.15 * high)) for high in HEIGHTS)), templates=5,
    like="wallshelf, wallrack, shelfboard", kin="storage", carries="boards", places="wall",
)  # fmt: skip
