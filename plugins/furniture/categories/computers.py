"""Monitors, keyboards and mice."""

from collections.abc import Sequence
from typing import cast

import numpy as np
import trimesh
from trimesh import Trimesh

from roomkin.plugins.furniture.categories.decor import Television
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import METALS, PAINTS
from roomkin.plugins.furniture.finishes import Surface, finish_of, shade
from roomkin.plugins.furniture.model import PLASTIC, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, in_turn, of, round_size, uniform
from roomkin.plugins.furniture.shapes import box, hull, rod

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
    "monitor",
    templates=3,
    names="computer monitor, computer screen, screen, desktop computer",
    like="display, computer",
    kin="flat",
    places="top",
)
def sample_monitor(rng: Rng, index: int) -> Sampled:
    """A screen on a neck or a bar, higher above the desk than a television above its stand."""
    wide = rng.uniform(0.42, 0.64) if index % 3 else rng.uniform(0.6, 0.82)
    recipe = Television.sample_parameters(
        rng,
        index,
        stand="bar" if index % 3 == 1 else "neck",
        stand_height=uniform(rng, 0.22, 0.34),
        rim=uniform(rng, 0.006, 0.02),
    )
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
    name="mouse",
    sample=sized(Mouse, ((0.095, 0.056, 0.03), (0.125, 0.07, 0.042)), digits=4),
    templates=3,
    names="computer mouse",
    like="trackball",
    kin="device",
    places="top",
)
