"""Monitors, keyboards and mice; telephones and remote controls."""

from collections.abc import Sequence
from typing import Literal, cast

import numpy as np
import trimesh
from trimesh import Trimesh

from roomkin.plugins.furniture.categories.decor import Television
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import METALS, PAINTS
from roomkin.plugins.furniture.fields import between, in_turn, of, one_of
from roomkin.plugins.furniture.finishes import DARK, Surface, finish_of, shade
from roomkin.plugins.furniture.model import PLASTIC, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import box, cushion, hull, rod, rotate, translate

SHELL = 700.0  # kg / m^3: a case with air and electronics in it
CASES = METALS[:3] + PAINTS[:1]


def seen(meshes: Sequence[Trimesh], surface: Surface) -> Part:
    """Many small solids as one part that is seen, but not touched: keys, buttons."""
    return Part(cast(Trimesh, trimesh.util.concatenate(list(meshes))), finish_of(surface), PLASTIC, ())


def grid(
    x: tuple[float, float], y: tuple[float, float], rows: int, columns: int, z: tuple[float, float]
) -> list[Trimesh]:
    """Keys side by side in a rectangle, a sixth of each left free."""
    a, b = np.linspace(*x, rows + 1), np.linspace(*y, columns + 1)
    gap = min(a[1] - a[0], b[1] - b[0]) / 12
    cells = [(i, j) for i in range(rows) for j in range(columns)]
    return [box((a[i] + gap, a[i + 1] - gap), (b[j] + gap, b[j + 1] - gap), z) for i, j in cells]


@category(
    "monitor", templates=3, names="computer monitor, computer screen, screen, desktop computer",
    like="display, computer", kin="flat", places="top",
)  # fmt: skip
def sample_monitor(rng: Rng, index: int) -> Sampled:
    """A screen on a neck or a bar, higher above the desk than a television above its stand."""
    wide = rng.uniform(0.42, 0.64) if index % 3 else rng.uniform(0.6, 0.82)
    recipe = Television.sample_parameters(
        rng, index, stand="bar" if index % 3 == 1 else "neck", stand_height=uniform(rng, 0.22, 0.34),
        rim=uniform(rng, 0.006, 0.02),
    )  # fmt: skip
    shape = rng.uniform(0.72, 0.84) if index % 3 else rng.uniform(0.62, 0.7)
    return Sampled(round_size(rng.uniform(0.17, 0.24), wide, wide * shape), recipe)


class Keyboard(Generator):
    """Rows of keys on a slab that is a little higher at its rear."""

    numbers: bool = in_turn(True, False, True)  # a block of digits at the right
    slope: float = between(0.3, 0.6)  # height of the front edge, as a share of the rear's
    colour: Coating = of(CASES)
    key_colour: Coating = of(METALS[2:3], PAINTS[:2], METALS[1:2])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        rear, front = 0.8 * z, 0.8 * z * self.slope
        edge = 0.05 * size[0]
        corners = [(a, b, c) for a, top in ((-x, rear), (x, front)) for b in (-y, y) for c in (0, top)]
        parts = Parts()
        parts.add(hull(corners), self.colour, SHELL)
        inner = (-x + 1.5 * edge, x - edge)
        right = y - (0.24 * size[1] if self.numbers else edge)
        keys = [*grid(inner, (-y + edge, right), 5, 14, (0, 1))]
        if self.numbers:
            keys += grid(inner, (right + edge / 2, y - edge), 5, 4, (0, 1))
        for key in keys:  # on the slope
            level = rear + (front - rear) * (key.vertices[:, 0] + x) / (2 * x)
            key.vertices[:, 2] = level + (z - rear) * (key.vertices[:, 2] > 0)
        return Model([*parts, seen(keys, self.key_colour)], placement="object")


@category("keyboard", templates=3, names="computer keyboard, typewriter", kin="device", places="top")
def sample_keyboard(rng: Rng, index: int) -> Sampled:
    """With a block of digits or without."""
    wide = rng.uniform(0.28, 0.36) if index % 3 == 1 else rng.uniform(0.4, 0.46)
    size = round_size(rng.uniform(0.12, 0.165), wide, rng.uniform(0.02, 0.034), digits=4)
    return Sampled(size, Keyboard.sample_parameters(rng, index))


class Mouse(Generator):
    """A mouse: an arched back, two buttons, a wheel; its buttons towards -x."""

    arch: float = between(1.6, 2.6)  # exponent of its back
    waist: float = between(0.0, 0.12)
    colour: Coating = of(CASES)
    wheel_colour: Coating = of(METALS[1:3])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        t, s = np.meshgrid(np.linspace(-1, 1, 15), np.linspace(-1, 1, 11), indexing="ij")
        half = (1 - np.abs(t) ** 3.5) ** (1 / 2.2)
        top = z * (0.25 + 0.75 * (1 - np.abs(t - 0.15) ** self.arch / 1.15**self.arch)) * (1 - 0.55 * np.abs(s) ** 3)
        plan = np.stack([x * t, y * s * half * (1 - self.waist * (1 - t**2))], axis=-1).reshape(-1, 2)
        points = [np.column_stack([plan, level]) for level in (np.zeros(t.size), top.ravel())]
        parts = Parts()
        parts.add(hull(np.concatenate(points)), self.colour, SHELL, smooth=True)
        level = z * (0.88 - 0.75 * (0.65 / 1.15) ** self.arch)  # in its back
        wheel = rod((-0.5 * x, -0.05 * size[1], level), (-0.5 * x, 0.05 * size[1], level), 0.22 * z)
        parts.append(seen([wheel], self.wheel_colour))
        line = box((-0.97 * x, -0.1 * x), (-0.012 * size[1], 0.012 * size[1]), (0.3 * z, 0.84 * z))
        parts.append(seen([line], shade(self.colour, 0.5)))
        return Model(parts, placement="object")


MOUSE = Category(
    name="mouse", sample=sized(Mouse, ((0.095, 0.056, 0.03), (0.125, 0.07, 0.042)), digits=4), templates=3,
    names="computer mouse", like="trackball", kin="device", places="top",
)  # fmt: skip


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
            screen = box((0.2 * x, 0.2 * x + 0.002), (-0.45 * y, 0.45 * y), (0.66 * z, 0.88 * z))
            parts.add(screen, DARK, PLASTIC, solid=False)
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
    name="telephone", sample=sized(Telephone, DESK, CORDLESS, digits=4), templates=2,
    names="phone, landline, desk phone, telephone set", like="intercom, handset", kin="device", places="top",
)  # fmt: skip


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
    name="cell_phone", sample=sized(CellPhone, ((0.135, 0.066, 0.0075), (0.168, 0.079, 0.012)), digits=4), templates=3,
    names="cellphone, mobile phone, smartphone, smart phone, cellular phone, mobile", like="ipod, pager", kin="device",
    places="top",
)  # fmt: skip


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
    name="remote", sample=sized(Remote, ((0.13, 0.038, 0.016), (0.22, 0.055, 0.026)), digits=4), templates=3,
    names="remote control, tv remote, television remote", like="controller, joystick, gamepad", kin="device",
    places="top",
)  # fmt: skip
