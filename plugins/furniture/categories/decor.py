"""Televisions and pictures, rugs and curtains."""

from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, GLAZES, METALS, PAINTS, SHADES, WOODS, pick
from roomkin.plugins.furniture.fields import between, fixed, in_turn, of, sampled_by, whole, zero_or
from roomkin.plugins.furniture.finishes import change_material, finish_of, shade
from roomkin.plugins.furniture.model import METAL, STEEL, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, lathe, rim, rod, widen


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
    "picture", templates=4, count=10, names="painting", like="poster, artwork, canvas, frame, photo", kin="flat",
    places="wall",
)  # fmt: skip
def sample_picture(rng: Rng, index: int) -> Sampled:
    """Portrait and landscape."""
    wide, tall = sorted(rng.uniform([0.3, 0.5], [0.5, 0.8]))
    y, z = (wide, tall) if index % 2 else (tall, wide)
    return Sampled(round_size(0.035, y, z), Picture.sample_parameters(rng, index))


WOOL = 250.0  # kg / m^3: a pile on its backing


class Rug(Generator):
    """A rug that lies: its field in a border, stripes across, fringes, or round."""

    style: Literal["border", "stripes", "round", "fringe"] = in_turn("border", "stripes", "round", "fringe")
    border: float = between(0.06, 0.14)  # share of the depth
    stripes: int = whole(3, 8, ge=1, le=50)
    colour: Coating = of(SHADES, FABRICS[1:2])
    second_colour: Coating = of([FABRICS[0], *FABRICS[2:]])

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        parts = Parts()
        pile = 0.9 * z  # what is shown on it is as flat as a print
        if self.style == "round":
            for radius, top, color in ((1.0, pile, self.colour), (0.8, z, self.second_colour)):
                disc = lathe([(0, 0), (radius, 0), (radius, top), (0, top)], 48)
                parts.add(widen(disc, x, y), color, WOOL, solid=top == pile)
            return Model(parts, symmetry="full" if size[0] == size[1] else "half_turn")
        fringe = 0.04 * y if self.style == "fringe" else 0.0
        parts.add(box((-x, x), (-y + fringe, y - fringe), (0, pile)), self.colour, WOOL)
        if self.style == "stripes":
            for k in range(self.stripes):
                middle = y * ((2 * k + 1) / self.stripes - 1)
                half = 0.5 * y / self.stripes
                stripe = box((-x, x), (middle - half, middle + half), (pile, z))
                parts.add(stripe, self.second_colour, WOOL, solid=False)
            return Model(parts, symmetry="half_turn")
        inset = 2 * self.border * x
        field = box((-x + inset, x - inset), (-y + fringe + inset, y - fringe - inset), (pile, z))
        parts.add(field, self.second_colour, WOOL, solid=False)
        if fringe:
            for side in (-1, 1):
                for a in np.linspace(-0.97 * x, 0.97 * x, 25):
                    strand = box((a - 0.012 * x, a + 0.012 * x), (side * (y - fringe), side * y), (0, 0.5 * z))
                    parts.add(strand, shade(self.second_colour, 1.15), WOOL, solid=False)
        return Model(parts, symmetry="half_turn")


@category(
    "rug", templates=4, names="carpet, mat, area rug, doormat, door mat, bath mat, floor mat",
    like="runner, kilim, tapestry", kin="cloth", carries="floor",
)  # fmt: skip
def sample_rug(rng: Rng, index: int) -> Sampled:
    """From a mat before a door to a carpet beneath a table."""
    deep = [rng.uniform(1.2, 2.0), rng.uniform(0.6, 0.9), rng.uniform(1.0, 1.8), rng.uniform(1.0, 1.7)][index % 4]
    wide = deep if index % 4 == 2 else deep * rng.uniform(1.4, 1.7)
    return Sampled(round_size(deep, wide, rng.uniform(0.008, 0.014)), Rug.sample_parameters(rng, index))


class Curtain(Generator):
    """Folds that hang from a rod: a pair drawn aside, or drawn before the window, or one panel."""

    style: Literal["aside", "drawn", "panel"] = in_turn("aside", "drawn", "panel")
    fold: float = between(0.09, 0.14)  # from crest to crest
    gathered: float = between(0.22, 0.32)  # share of the width that either of a pair covers when drawn aside
    thickness: float = between(0.012, 0.018)
    colour: Coating = of(FABRICS, SHADES)
    rod_colour: Coating = of(METALS, WOODS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        level, thick = z - 0.025, 0.016
        top = level - thick
        parts = Parts()
        parts.add(rod((0, -0.97 * y, level), (0, 0.97 * y, level), 0.012), self.rod_colour, METAL, smooth=True)
        for side in (-1, 1):
            end = rod((0, side * 0.96 * y, level), (0, side * y, level), 0.024, 0.016)
            parts.add(end, self.rod_colour, METAL, smooth=True)
            bracket = box((-x, 0), (side * 0.9 * y - 0.008, side * 0.9 * y + 0.008), (level - 0.01, level + 0.01))
            parts.add(bracket, self.rod_colour, METAL, solid=False)
        edge = 0.93 * y
        spans = {
            "aside": [(-edge, -edge + 2 * self.gathered * y), (edge - 2 * self.gathered * y, edge)],
            "drawn": [(-edge, -0.004), (0.004, edge)],
            "panel": [(-edge, edge)],
        }[self.style]
        for a, b in spans:
            folds = max(2, round((b - a) / (self.fold if self.style != "aside" else 0.6 * self.fold)))
            mesh = _folds(x - self.thickness / 2, (a, b), (0.0, top + thick), self.thickness, folds)
            parts.append(Part(mesh, finish_of(self.colour), WOOL, (box((-x, x), (a, b), (0, top)),), True))
        return Model(parts, placement="wall")


def _folds(deep: float, y: tuple[float, float], z: tuple[float, float], thick: float, folds: int) -> Trimesh:
    """A cloth whose plan is a wave along y of so many folds, `deep` metres to either side."""
    phase = np.linspace(0, 2 * np.pi * folds, 12 * folds + 1)
    plan = np.column_stack([deep * np.sin(phase), np.linspace(*y, len(phase))])
    half_thick = np.array([thick / 2, 0])
    ring = np.concatenate([plan + half_thick, plan[::-1] - half_thick])
    count = len(ring)
    vertices = np.concatenate([np.column_stack([ring, np.full(count, level)]) for level in z])
    around, half = np.arange(count), len(plan)
    after = (around + 1) % count
    sides = np.concatenate(
        [np.column_stack([around, after, after + count]), np.column_stack([around, after + count, around + count])]
    )
    left = np.arange(half - 1)
    right = count - 1 - left
    caps = np.concatenate([np.column_stack([left, right, right - 1]), np.column_stack([left, right - 1, left + 1])])
    return Trimesh(vertices, np.concatenate([sides, caps, caps[:, ::-1] + count]), process=False)


@category(
    "curtain", templates=3, names="drape, drapery, window curtain, shower curtain, curtain panel",
    like="blind, shutter, valance", kin="cloth", places="wall",
)  # fmt: skip
def sample_curtain(rng: Rng, index: int) -> Sampled:
    """To the window sill or to the floor."""
    wide = rng.uniform(0.7, 1.1) if index % 3 == 2 else rng.uniform(1.3, 2.4)
    tall = rng.uniform(2.0, 2.5) if index % 2 == 0 else rng.uniform(1.2, 1.7)
    return Sampled(round_size(rng.uniform(0.08, 0.13), wide, tall), Curtain.sample_parameters(rng, index))
