"""Telephones and remote controls."""

from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.categories.computers import SHELL, grid, seen
from roomkin.plugins.furniture.category import Category, sized
from roomkin.plugins.furniture.colors import METALS, PAINTS
from roomkin.plugins.furniture.finishes import DARK
from roomkin.plugins.furniture.model import PLASTIC, Model, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, between, in_turn, of, one_of
from roomkin.plugins.furniture.shapes import box, cushion, hull, rod, rotate, translate


class Telephone(Generator):
    """A desk telephone with its handset beside the keys, or a cordless one upright in its cradle."""

    style: Literal["desk", "cordless"] = in_turn("desk", "cordless")
    slope: float = between(0.3, 0.5)  # height of the front edge, as a share of the rear's
    colour: Coating = of(METALS[2:3], PAINTS[:2], METALS[1:2])
    key_colour: Coating = of(PAINTS[:2], METALS[:2])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        parts = Parts()
        if self.style == "cordless":
            parts.add(cushion((-x, -y, 0), (x, y, 0.22 * z), 0.08 * z), self.colour, SHELL)
            handset = cushion((-0.3 * x, -0.62 * y, 0.12 * z), (0.2 * x, 0.62 * y, z), 0.04 * z)
            parts.add(handset, self.colour, SHELL)
            flat = grid((0.28 * z, 0.6 * z), (-0.5 * y, 0.5 * y), 4, 3, (0, 0.003))
            keys = [translate(rotate(key, -np.pi / 2, [0, 1, 0]), (0.2 * x + 0.0025, 0, 0)) for key in flat]
            parts.append(seen(keys, self.key_colour))
            parts.add(
                box((0.2 * x, 0.2 * x + 0.002), (-0.45 * y, 0.45 * y), (0.66 * z, 0.88 * z)), DARK, PLASTIC, solid=False
            )
            return Model(parts, placement="object")
        rear, front_edge = 0.7 * z, 0.7 * z * self.slope
        corners = [(a, b, c) for a, top in ((-x, rear), (x, front_edge)) for b in (-y, y) for c in (0, top)]
        parts.add(hull(corners), self.colour, SHELL)

        def raised(meshes: list[Trimesh]) -> list[Trimesh]:
            for mesh in meshes:
                mesh.vertices[:, 2] += rear + (front_edge - rear) * (mesh.vertices[:, 0] + x) / (2 * x)
            return meshes

        bar = (-0.88 * y, -0.48 * y)
        grip = raised([cushion((-0.85 * x, bar[0], 0.1 * z), (0.85 * x, bar[1], 0.24 * z), 0.04 * z)])
        starts = (-0.95 * x, 0.45 * x)
        ends = [cushion((a, bar[0], -0.02 * z), (a + 0.5 * x, bar[1], 0.3 * z), 0.06 * z) for a in starts]
        for mesh in (*grip, *raised(ends)):
            parts.add(mesh, self.colour, SHELL)
        keys = raised(grid((-0.15 * x, 0.85 * x), (-0.2 * y, 0.75 * y), 4, 3, (-0.01 * z, 0.06 * z)))
        parts.append(seen(keys, self.key_colour))
        display = raised([box((-0.85 * x, -0.35 * x), (-0.2 * y, 0.75 * y), (-0.01 * z, 0.03 * z))])
        parts.append(seen(display, DARK))
        return Model(parts, placement="object")


DESK, CORDLESS = ((0.19, 0.17, 0.08), (0.24, 0.23, 0.12)), ((0.08, 0.075, 0.15), (0.11, 0.1, 0.19))
TELEPHONE = Category(
    name="telephone",
    sample=sized(Telephone, DESK, CORDLESS, digits=4),
    templates=2,
    names="phone, landline, desk phone, telephone set",
    like="intercom, handset",
    kin="device",
    places="top",
)


class CellPhone(Generator):
    """A mobile telephone that lies, its screen up, or face down."""

    up: bool = in_turn(True, True, False)
    edge: float = between(0.2, 0.45)  # chamfer, as a share of its thickness
    colour: Coating = of(METALS[:4], PAINTS[:5])
    screen_colour: Coating = one_of("paint 0.02 0.02 0.03 0", "paint 0.1 0.16 0.26 0")

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        top = 0.94 * z
        parts = Parts()
        parts.add(cushion((-x, -y, 0), (x, y, top), self.edge * z), self.colour, 1800.0)
        if self.up:
            parts.append(seen([box((-0.95 * x, 0.95 * x), (-0.9 * y, 0.9 * y), (0.9 * top, z))], self.screen_colour))
        else:
            lenses = [rod((a * x, -0.6 * y, 0.9 * top), (a * x, -0.6 * y, z), 0.12 * y) for a in (-0.85, -0.68)]
            parts.append(seen(lenses, DARK))
        return Model(parts, placement="object")


CELL_PHONE = Category(
    name="cell_phone",
    sample=sized(CellPhone, ((0.135, 0.066, 0.0075), (0.168, 0.079, 0.012)), digits=4),
    templates=3,
    names="cellphone, mobile phone, smartphone, smart phone, cellular phone, mobile",
    like="ipod, pager",
    kin="device",
    places="top",
)


class Remote(Generator):
    """A remote control that lies, its buttons up; its head towards -x."""

    rows: int = one_of(6, 8, 10, ge=1, le=50)
    columns: int = one_of(2, 3, ge=1, le=20)
    taper: float = between(0.8, 1.0)  # width of its foot, as a share
    colour: Coating = of(METALS[:3], PAINTS[:1])
    key_colour: Coating = of(PAINTS[:3], METALS[1:2])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        top = 0.88 * z
        plan = [(-x, y), (-x, -y), (x, self.taper * y), (x, -self.taper * y)]
        levels = [(0.0, 0.92), (0.3 * top, 1.0), (0.8 * top, 1.0), (top, 0.94)]
        parts = Parts()
        parts.add(hull([(a, b * share, level) for level, share in levels for a, b in plan]), self.colour, SHELL)
        half = 0.6 * y * self.taper
        keys = grid((-0.6 * x, 0.7 * x), (-half, half), self.rows, self.columns, (0.9 * top, z))
        parts.append(seen(keys, self.key_colour))
        power = rod((-0.82 * x, 0.45 * y, 0.9 * top), (-0.82 * x, 0.45 * y, z), 0.18 * y)
        parts.append(seen([power], "paint 0.6 0.08 0.06 0"))
        return Model(parts, placement="object")


REMOTE = Category(
    name="remote",
    sample=sized(Remote, ((0.13, 0.038, 0.016), (0.22, 0.055, 0.026)), digits=4),
    templates=3,
    names="remote control, tv remote, television remote",
    like="controller, joystick, gamepad",
    kin="device",
    places="top",
)
