"""Kettles, toasters, frying pans, jars."""

import itertools
from typing import Literal

import numpy as np

from roomkin.plugins.furniture.categories.containers import DARK_LID, LIGHT
from roomkin.plugins.furniture.categories.vessels import ear, hollow
from roomkin.plugins.furniture.category import Category, category, sized
from roomkin.plugins.furniture.colors import APPLIANCE, GLAZES, METALS, PAINTS, WOODS
from roomkin.plugins.furniture.fields import between, in_turn, of
from roomkin.plugins.furniture.model import FILLED, METAL, PLASTIC, Model, Part, Parts, Size, move_model
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import box, cushion, lathe, rod


class Kettle(Generator):
    """A kettle, its spout towards +x: a jug has its handle behind, one for the stove above."""

    style: Literal["jug", "stove"] = in_turn("jug", "stove")
    taper: float = between(0.6, 0.95)  # top / foot
    angular: bool = in_turn(True, False, False, False)
    colour: Coating = of(APPLIANCE, GLAZES)
    grip_colour: Coating = of(METALS[2:], WOODS)

    def build(self, size: Size) -> Model:
        z = size[2]
        body = z * (0.93 if self.style == "jug" else 0.62)
        radius = min(0.39 * size[0], 0.5 * size[1])
        top = radius * self.taper
        shape = [(0, 0), (radius, 0), (radius, 0.12 * body), (top, 0.9 * body), (0.5 * top, body), (0, body)]
        if self.style == "stove":
            angles = np.linspace(0, 2.6, 8)
            bulge = [(radius * (0.8 + 0.2 * np.sin(a)), body * (0.45 - 0.45 * np.cos(a))) for a in angles]
            shape = [(0, 0), *bulge, (0.3 * radius, body), (0, body)]
        parts = Parts()
        parts.add(lathe(shape), self.colour, LIGHT, smooth=True)
        parts.add(rod((0, 0, body), (0, 0, body + 0.05 * z), 0.012, 0.016), self.grip_colour, PLASTIC, smooth=True)
        low, high = (0.66, 0.88) if self.style == "jug" else (0.45, 0.9)
        reach = size[0] * 0.5 if self.style == "stove" else radius * 1.25
        spout = rod((0.7 * top, 0, low * body), (reach, 0, high * body), 0.16 * radius + 0.006, 0.1 * radius)
        parts.add(spout, self.colour, LIGHT, smooth=True)
        if self.style == "jug":
            grip = ear(radius, size[0] - radius * 2.25, 0.75 * body, 0.52 * body, self.grip_colour, self.angular)
            parts += move_model(Model(grip), (0.0, 0.0, 0.0), turn=np.pi / 2).base
        else:
            parts += _bail(ear(0.0, 0.75 * radius, 2 * 0.9 * radius, 0.0, self.grip_colour, False), z, body)
        return Model(parts, placement="object")


def _bail(grip: list[Part], z: float, body: float) -> Parts:
    """A handle that was made upright beside the y axis, as an arch over the top from front to back."""
    points = np.concatenate([piece.mesh.vertices for piece in grip])
    span, rise = float(np.ptp(points[:, 2])), float(points[:, 1].max())
    factor = (z - 0.8 * body) / rise
    turned = Parts()
    for piece in grip:
        mesh = piece.mesh.copy()
        v = mesh.vertices
        mesh.vertices = np.column_stack([v[:, 2] * min(1.0, 0.12 / span + 0.6), v[:, 0], 0.8 * body + factor * v[:, 1]])
        mesh.invert()
        turned.add(mesh, str(piece.finish), piece.density, piece.smooth)
    return turned


@category("kettle", templates=4, names="teapot", like="teakettle", kin="dish", places="top")
def sample_kettle(rng: Rng, index: int) -> Sampled:
    """Electric jugs, and kettles for the stove."""
    deep = rng.uniform(0.2, 0.25)
    size = round_size(deep, deep * [0.68, 0.76][index % 2], rng.uniform(0.19, 0.26))
    return Sampled(size, Kettle.sample_parameters(rng, index))


class Toaster(Generator):
    """Slots along y, the lever at +x."""

    slots: int = in_turn(4, 2, 2)
    edge: float = between(0.012, 0.035)  # chamfer
    colour: Coating = of(APPLIANCE, GLAZES)
    trim_colour: Coating = of(METALS[1:3])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        foot = 0.05 * z
        parts = Parts()
        for a, b in itertools.product((-0.8 * x, 0.6 * x), (-0.8 * y, 0.6 * y)):
            parts.add(box((a, a + 0.03), (b, b + 0.02), (0, foot)), DARK_LID)
        parts.add(cushion((-x, -y, foot), (x - 0.02, y, z), self.edge), self.colour, LIGHT)
        skirt = box((-0.97 * x, x - 0.022), (-y - 0.001, y + 0.001), (foot, 0.2 * z))
        parts.add(skirt, self.trim_colour, LIGHT, solid=False)
        count = self.slots
        for b in (np.arange(count) - (count - 1) / 2) * 0.9 * size[1] / (count + 0.5):
            parts.add(box((-0.72 * x, 0.66 * x), (b - 0.012, b + 0.012), (z - 0.001, z + 0.001)), DARK_LID, solid=False)
        parts.add(box((x - 0.024, x), (-0.12 * y, 0.12 * y), (0.66 * z, 0.74 * z)), self.trim_colour, PLASTIC)
        parts.add(box((x - 0.024, x - 0.019), (-0.03 * y, 0.03 * y), (0.25 * z, 0.8 * z)), DARK_LID, solid=False)
        dial = rod((x - 0.022, 0.4 * y, 0.35 * z), (x - 0.006, 0.4 * y, 0.35 * z), 0.014)
        parts.add(dial, self.trim_colour, PLASTIC, smooth=True)
        return Model(parts, placement="object")


TWO, FOUR = ((0.27, 0.16, 0.17), (0.36, 0.2, 0.21)), ((0.27, 0.26, 0.17), (0.36, 0.3, 0.21))  # slices
TOASTER = Category(name="toaster", sample=sized(Toaster, FOUR, TWO, TWO), templates=3, kin="appliance", places="top")


class Pan(Generator):
    """A frying pan, its handle towards +y."""

    flare: float = between(0.75, 0.95)  # foot / rim
    rise: float = between(0.1, 0.45)  # of the handle
    lid: bool
    colour: Coating = of(METALS[:3], GLAZES[1:4])
    inside: Coating = of(METALS[:3])
    lid_colour: Coating = of(METALS[:2])
    grip_colour: Coating = of(METALS[2:3], WOODS[1:4])

    def build(self, size: Size) -> Model:
        radius, z = size[0] / 2, size[2]
        reach = max(size[1] - size[0], 0.3 * radius)
        body = z * (0.62 if self.lid else 0.8)
        flare = self.flare
        outer = [(flare * radius, 0.0), (0.5 * (1 + flare) * radius, 0.4 * body), (radius, body)]
        parts = hollow(outer, min(0.004, 0.1 * body), self.colour, self.inside, METAL)
        start, end = 0.75 * body, body * (0.8 + self.rise)
        grip = rod((0, 0.94 * radius, start), (0, radius + reach, end), 0.008, 0.011)
        parts.add(grip, self.grip_colour, PLASTIC, smooth=True)
        if self.lid:
            lid = lathe([(0, body), (radius, body), (0.5 * radius, 0.85 * z), (0, 0.87 * z)])
            parts.add(lid, self.lid_colour, METAL, smooth=True)
            parts.add(rod((0, 0, 0.82 * z), (0, 0, z), 0.012, 0.02), self.grip_colour, PLASTIC, smooth=True)
        return Model(move_model(Model(parts), (0.0, -reach / 2, 0.0)).base, placement="object")


@category(
    "pan", templates=3, names="frying pan, frypan, skillet", like="saucepan", kin="dish", carries="inside", places="top"
)
def sample_pan(rng: Rng, index: int) -> Sampled:
    """Flat frying pans to sauce pans with a lid."""
    diameter, lid = rng.uniform(0.2, 0.3), index % 3 == 2
    tall = (0.11, 0.17) if lid else (0.05, 0.08)
    size = round_size(diameter, diameter + rng.uniform(0.15, 0.2), rng.uniform(*tall), digits=4)
    return Sampled(size, Pan.sample_parameters(rng, index, lid=lid))


class Jar(Generator):
    """A jar with a lid."""

    neck: float = between(0.7, 0.95)  # share of the radius
    lid: float = between(0.12, 0.24)  # share of the height
    knob: bool = in_turn(False, True)
    label: bool = in_turn(True, False, False)
    colour: Coating = of(GLAZES)
    lid_colour: Coating = of(WOODS, METALS, GLAZES)
    label_colour: Coating = of(PAINTS[:2])

    def build(self, size: Size) -> Model:
        radius, z = size[0] / 2, size[2]
        top = z * (1 - self.lid)
        neck = self.neck * radius
        side = [(0.94 * radius, 0), (radius, 0.06 * top), (radius, 0.82 * top), (neck, 0.97 * top), (neck, top)]
        parts = Parts()
        parts.add(lathe([(0, 0), *side, (0, top)]), self.colour, FILLED, smooth=True)
        cap = z if not self.knob else top + 0.6 * (z - top)
        lid = lathe([(0, top), (1.08 * neck, top), (1.08 * neck, cap), (0, cap)])
        parts.add(lid, self.lid_colour, 700.0, smooth=True)
        if self.knob:
            parts.add(rod((0, 0, cap), (0, 0, z), 0.16 * radius, 0.24 * radius), self.lid_colour, 700.0, smooth=True)
        if self.label:
            band = lathe([(0, 0.25 * top), (1.004 * radius, 0.25 * top), (1.004 * radius, 0.6 * top), (0, 0.6 * top)])
            parts.add(band, self.label_colour, smooth=True, solid=False)
        return Model(parts, symmetry="full", placement="object")


@category("jar", templates=4, like="canister", kin="dish", places="top")
def sample_jar(rng: Rng, index: int) -> Sampled:
    """Preserving jars, storage jars with a knob."""
    diameter = uniform(rng, 0.075, 0.13, 4)
    recipe = Jar.sample_parameters(rng, index)
    return Sampled(round_size(diameter, diameter, diameter * rng.uniform(1.1, 1.9), digits=4), recipe)
