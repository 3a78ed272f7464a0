"""Chairs and stools; the back is at -x."""

from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, METALS, PAINTS, WOODS, pick
from roomkin.plugins.furniture.fields import between, chance, in_turn, of, one_of, zero_or
from roomkin.plugins.furniture.model import Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, round_size, uniform
from roomkin.plugins.furniture.shapes import beam, box, cushion, hull, lathe, rod, widen

Point = tuple[float, float, float]


class Chair(Generator):
    """A seat on four legs with a leaning back."""

    seat: float  # height, as a share of the whole
    back: Literal["slats", "ladder", "panel", "spindles"] = in_turn("slats", "ladder", "panel", "spindles")
    lean: float = between(0.02, 0.1)
    leg: float = between(0.028, 0.045)
    legs: Literal["square", "round", "tapered"] = one_of("square", "round", "tapered")
    arms: bool
    padded: bool = chance()
    frame_colour: Coating
    seat_colour: Coating

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        seat, lean, leg = self.seat * z, self.lean, min(self.leg, 0.12 * min(size))
        back = -x + lean  # the back leans over from here to -x
        thick = 0.035
        side = y - (leg if self.arms else 0.0)
        frame, cloth = self.frame_colour, self.seat_colour
        parts = Parts()
        if self.padded:
            parts.add(cushion((back, -side, seat - thick), (x, side, seat + 0.03), 0.02), cloth, 200.0)
        else:
            parts.add(box((back, x), (-side, side), (seat - thick, seat)), cloth)
        inset = 0.6 * leg
        for a in (back + inset, x - inset):
            for b in (-side + inset, side - inset):
                if self.legs == "round":
                    parts.add(rod((a, b, 0), (a, b, seat - thick), leg / 2), frame, smooth=True)
                else:
                    tip = 0.6 * leg if self.legs == "tapered" else leg
                    parts.add(beam((a, b, 0), (a, b, seat - thick), tip, leg), frame)
        parts += _back(self, (back + leg / 2, -x + leg / 2), side, seat, z, leg)
        if self.arms:
            level = seat + 0.45 * (z - seat)
            for s in (-1, 1):
                parts.add(box((back, 0.75 * x), (s * y, s * (y - leg)), (level, level + 0.03)), frame)
                at = (0.6 * x, s * (y - leg / 2))
                parts.add(beam((*at, seat - thick), (*at, level), 0.8 * leg), frame)
                parts.add(box((back, 0.7 * x), (s * y, s * (y - leg)), (seat - thick, seat)), frame)
        return Model(parts)


def _back(p: Chair, lean: tuple[float, float], side: float, seat: float, top: float, leg: float) -> list[Part]:
    """Two posts and what is between them, from the seat to the top, leaning from lean[0] to lean[1] in x."""
    frame, cloth = p.frame_colour, p.seat_colour
    edge = side - leg / 2

    def place_at(share: float, y: float) -> Point:
        return (lean[0] + share * (lean[1] - lean[0]), y, seat - 0.03 + share * (top - seat + 0.03))

    parts = Parts()
    for s in (-1, 1):
        parts.add(beam(place_at(0, s * edge), place_at(1, s * edge), leg), frame)
    if p.back == "panel":
        pairs = [(place_at(share, -edge), place_at(share, edge)) for share in (0.3, 0.97)]
        board = [(a + d, b, c) for pair in pairs for d in (-0.4 * leg, 0.4 * leg) for a, b, c in pair]
        parts.add(hull(board), cloth, 300.0)
        return parts
    rail = 0.8 * leg
    parts.add(_rail(place_at(0.93, -edge), place_at(0.93, edge), rail, 0.12 * (top - seat)), frame)
    if p.back == "ladder":
        for share in (0.4, 0.58, 0.76):
            parts.add(_rail(place_at(share, -edge), place_at(share, edge), 0.5 * rail, 0.1 * (top - seat)), frame)
        return parts
    count = 3 if p.back == "slats" else 6
    for y in np.linspace(-edge, edge, count + 2)[1:-1]:
        if p.back == "slats":
            parts.add(_slat(place_at(0.05, 0), place_at(0.9, 0), float(y), edge / count, 0.5 * rail), frame)
        else:
            parts.add(rod(place_at(0.05, float(y)), place_at(0.9, float(y)), 0.008), frame, smooth=True)
    return parts


def _rail(start: Point, end: Point, depth: float, height: float) -> Trimesh:
    """A rail along y between two points, `depth` in x and `height` in z."""
    x, z = start[0], start[2]
    return box((x - depth / 2, x + depth / 2), (start[1], end[1]), (z - height / 2, z + height / 2))


def _slat(low: Point, high: Point, y: float, width: float, depth: float) -> Trimesh:
    """A board that leans from one point to another, `width` in y and `depth` in x."""
    corners = [(dx, y + dy) for dx in (-depth / 2, depth / 2) for dy in (-width / 2, width / 2)]
    return hull([(x + dx, b, z) for x, _, z in (low, high) for dx, b in corners])


@category("chair", templates=6, count=10, names="folding chair, rocking chair, chair desk", kin="seat", carries="seat")
def sample_chair(rng: Rng, index: int) -> Sampled:
    """Dining chairs, some with arms, some padded."""
    arms = index % 4 == 3
    size = round_size(rng.uniform(0.44, 0.56), rng.uniform(0.42, 0.5) + 0.08 * arms, rng.uniform(0.78, 1.05))
    frame = pick(rng, WOODS, PAINTS, METALS)
    recipe = Chair.sample_parameters(
        rng, index, seat=round(0.45 / size[2], 3), arms=arms, frame_colour=frame,
        seat_colour=lambda: pick(rng, FABRICS) if rng.random() < 0.6 else frame,
    )  # fmt: skip
    return Sampled(size, recipe)


class Stool(Generator):
    """A seat on three or four splayed legs, or on a pedestal."""

    seat: Literal["round", "square"] = in_turn("round", "square")
    legs: int = in_turn(4, 4, 0, 3)  # 0: a pedestal
    splay: float = between(0.1, 0.5)  # share
    ring: float = zero_or(0.25, 0.45)  # height, as a share; 0: none
    thickness: float = between(0.03, 0.07)
    seat_colour: Coating = of(WOODS, FABRICS)
    leg_colour: Coating = of(WOODS, METALS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        thick = min(self.thickness, 0.2 * z)
        under, wide, count = z - thick, min(x, y), self.legs
        parts = Parts()
        if self.seat == "round":
            mesh = lathe([(0, under), (0.96 * wide, under), (wide, z - 0.3 * thick), (0.94 * wide, z), (0, z)])
            parts.add(widen(mesh, x / wide, y / wide), self.seat_colour, smooth=True)
        else:
            parts.add(cushion((-x, -y, under), (x, y, z), 0.015), self.seat_colour)
        if count == 0:
            foot = lathe([(0, 0), (0.85 * wide, 0), (0.8 * wide, 0.02), (0.03, 0.05), (0, 0.05)])
            parts.add(foot, self.leg_colour, 7800.0, smooth=True)
            parts.add(rod((0, 0, 0.04), (0, 0, under), 0.025), self.leg_colour, smooth=True)
            return Model(parts, symmetry="full" if self.seat == "round" else "quarter_turn")
        angles = 2 * np.pi * (np.arange(count) + 0.5) / count
        top, spread = 0.6 * wide, min(0.6 * wide * (1 + self.splay), (1.2 if self.seat == "square" else 0.95) * wide)
        for t in angles:
            c, s = np.cos(t), np.sin(t)
            leg = rod((spread * c, spread * s, 0), (top * c, top * s, under), 0.014, 0.018)
            parts.add(leg, self.leg_colour, smooth=True)
        if self.ring:
            radius = spread + self.ring * (top - spread)
            feet = [(radius * np.cos(t), radius * np.sin(t), self.ring * under) for t in angles]
            for a, b in zip(feet, [*feet[1:], feet[0]], strict=True):
                parts.add(rod(a, b, 0.009), self.leg_colour, smooth=True)
        if self.seat == "round":
            return Model(parts, symmetry="third_turn" if count == 3 else "quarter_turn" if count == 4 else "full")
        return Model(parts, symmetry="quarter_turn" if count == 4 else "none")


@category("stool", templates=3, count=10, kin="seat", carries="seat")
def sample_stool(rng: Rng, index: int) -> Sampled:
    """Low stools and bar stools."""
    wide = uniform(rng, 0.32, 0.42)
    recipe = Stool.sample_parameters(rng, index)
    return Sampled((wide, wide, uniform(rng, 0.42, 0.75)), recipe)
