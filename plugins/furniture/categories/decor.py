"""Televisions and pictures."""

from typing import Literal

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import GLAZES, METALS, PAINTS, WOODS, pick
from roomkin.plugins.furniture.finishes import change_material
from roomkin.plugins.furniture.model import STEEL, Model, Parts, Size
from roomkin.plugins.furniture.recipe import (
    Coating,
    Generator,
    Rng,
    Sampled,
    between,
    fixed,
    in_turn,
    of,
    round_size,
    sampled_by,
    zero_or,
)
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, rim, rod


class Television(Generator):
    """A flat screen on a stand."""

    stand: Literal["feet", "neck", "bar"] = in_turn("feet", "neck", "bar")
    stand_height: float = between(0.08, 0.16)  # share of the height
    rim: float = between(0.008, 0.035)
    case_colour: Coating = of(METALS[:3])
    screen_colour: Coating = fixed([0.02, 0.03, 0.05])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        stand = self.stand_height * z
        edge, thick = min(self.rim, 0.1 * z), min(0.025, 0.3 * x)
        parts = Parts()
        parts.add(box((-thick, thick), (-y, y), (stand, z)), self.case_colour, 400.0)
        screen = box((thick, thick + 0.002), (-y + edge, y - edge), (stand + edge, z - edge))
        parts.add(screen, self.screen_colour, 400.0, solid=False)
        low, high = stand + 0.1 * (z - stand), stand + 0.6 * (z - stand)
        parts.add(cushion((-2.2 * thick, -0.6 * y, low), (-thick, 0.6 * y, high), 0.02), self.case_colour, 400.0)
        if self.stand == "feet":
            for s in (-0.7 * y, 0.7 * y):
                parts.add(box((-x, x), (s - 0.015, s + 0.015), (0, 0.012)), self.case_colour, STEEL)
                parts.add(beam((0, s, 0.012), (0, s, stand + 0.02), 0.02), self.case_colour, STEEL)
            return Model(parts, placement="object")
        wide = 0.28 * y if self.stand == "neck" else 0.65 * y
        parts.add(cushion((-x, -wide * 1.3, 0), (x, wide * 1.3, 0.016), 0.005), self.case_colour, STEEL)
        neck = box((-0.8 * thick, 0.2 * thick), (-0.5 * wide, 0.5 * wide), (0.01, stand + 0.03))
        parts.add(neck, self.case_colour, STEEL)
        return Model(parts, placement="object")


@category("television", templates=4, count=10, names="tv", like="telly", kin="flat", places="top, wall")
def sample_television(rng: Rng, index: int) -> Sampled:
    """Small to large, wide or old-fashioned 4:3."""
    wide = rng.uniform(0.7, 1.25)
    shape = 0.72 if index % 4 == 3 else rng.uniform(0.58, 0.64)
    recipe = Television.sample_parameters(rng, index)
    return Sampled(round_size(rng.uniform(0.18, 0.26), wide, wide * shape), recipe)


class Picture(Generator):
    """A framed picture for the wall."""

    frame: float = between(0.015, 0.05)
    mat: float = zero_or(0.03, 0.08)
    motif: Literal["bands", "circle", "grid", "diagonal"] = in_turn("bands", "circle", "grid", "diagonal")
    frame_colour: Coating = of(WOODS, METALS)
    colour_1: Coating = sampled_by(lambda rng, _: change_material("card", pick(rng, PAINTS)))
    colour_2: Coating = sampled_by(lambda rng, _: change_material("card", pick(rng, GLAZES)))
    colour_3: Coating = sampled_by(lambda rng, _: change_material("card", pick(rng, GLAZES)))

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        frame, mat = min(self.frame, 0.15 * min(size[1], z)), self.mat
        face = 0.4 * x
        parts = Parts()
        parts.add(box((-x, face - 0.004), (-y + frame, y - frame), (frame, z - frame)), (0.86, 0.85, 0.80))
        for strip in rim((-x, x), (-y, y), (0, z), frame):
            parts.add(strip, self.frame_colour)
        inset = frame + min(mat, 0.2 * min(size[1], z))
        y0, y1, z0, z1 = -y + inset, y - inset, inset, z - inset
        wide, tall, front = y1 - y0, z1 - z0, (face, face + 0.001)
        parts.add(box((face - 0.004, face), (y0, y1), (z0, z1)), self.colour_1, solid=False)
        if self.motif == "bands":
            for low, high, color in ((0.0, 0.3, self.colour_2), (0.3, 0.45, self.colour_3)):
                parts.add(box(front, (y0, y1), (z0 + low * tall, z0 + high * tall)), color, solid=False)
        elif self.motif == "circle":
            disc = rod((front[0], 0, z / 2), (front[1], 0, z / 2), 0.3 * min(wide, tall), segments=32)
            parts.add(disc, self.colour_2, solid=False)
            parts.add(box(front, (y0, y1), (z0, z0 + 0.2 * tall)), self.colour_3, solid=False)
        elif self.motif == "grid":
            for k in range(9):
                a, b = y0 + (0.1 + 0.3 * (k % 3)) * wide, z0 + (0.1 + 0.3 * (k // 3)) * tall
                tile = box(front, (a, a + 0.2 * wide), (b, b + 0.2 * tall))
                parts.add(tile, self.colour_2 if k % 2 else self.colour_3, solid=False)
        else:
            corners = [(face + dx, a, b) for dx in (0, 0.001) for a, b in ((y0, z0), (y1, z0), (y0, z1))]
            parts.add(hull(corners), self.colour_2, solid=False)
        return Model(parts, placement="wall")


@category(
    "picture",
    templates=4,
    count=10,
    names="painting",
    like="poster, artwork, canvas, frame, photo",
    kin="flat",
    places="wall",
)
def sample_picture(rng: Rng, index: int) -> Sampled:
    """Portrait and landscape."""
    wide, tall = sorted(rng.uniform([0.3, 0.5], [0.5, 0.8]))
    y, z = (wide, tall) if index % 2 else (tall, wide)
    return Sampled(round_size(0.035, y, z), Picture.sample_parameters(rng, index))
