"""Ottomans and cushions."""

from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.category import category
from roomkin.plugins.furniture.colors import FABRICS, SHADES, WOODS
from roomkin.plugins.furniture.finishes import finish_of
from roomkin.plugins.furniture.model import FOAM, Model, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, Rng, Sampled, between, in_turn, of, round_size
from roomkin.plugins.furniture.shapes import box, cushion, hull, lathe, rod, widen

PADDED = 120.0  # kg / m^3: a padded frame
GRID = 12  # of a cushion's surface, per side


class Ottoman(Generator):
    """A padded seat without a back: a cube, a drum, a cushion on legs."""

    style: Literal["cube", "drum", "legs"] = in_turn("cube", "drum", "legs")
    lid: float = between(0.2, 0.4)  # height of the upper part, as a share
    foot: float = between(0.02, 0.05)
    colour: Coating = of(FABRICS)
    foot_colour: Coating = of(WOODS)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        seam, edge = z * (1 - self.lid), 0.06 * z
        parts = Parts()
        if self.style == "drum":
            body = lathe([(0, 0), (0.94, 0), (1, 0.1 * z), (1, seam - 0.03 * z), (0.97, seam), (0, seam)], 32)
            top = lathe([(0, seam), (0.97, seam), (1, seam + 0.03 * z), (1, 0.9 * z), (0.9, z), (0, z)], 32)
            for mesh in (body, top):
                parts.add(widen(mesh, x, y), self.colour, PADDED, smooth=True)
            return Model(parts, symmetry="full" if size[0] == size[1] else "half_turn")
        low = self.foot if self.style == "cube" else seam
        parts.add(cushion((-x, -y, max(seam, low)), (x, y, z), edge), self.colour, PADDED)
        if self.style == "cube":
            parts.add(cushion((-0.98 * x, -0.98 * y, low), (0.98 * x, 0.98 * y, seam), edge), self.colour, PADDED)
        else:
            rail = box((-0.93 * x, 0.93 * x), (-0.93 * y, 0.93 * y), (0.8 * seam, seam))
            parts.add(rail, self.foot_colour)
        for a in (-0.86 * x, 0.86 * x):
            for b in (-0.86 * y, 0.86 * y):
                reach = low if self.style == "cube" else 0.8 * seam
                parts.add(rod((a, b, 0), (a, b, reach), 0.016, 0.022), self.foot_colour)
        return Model(parts, symmetry="half_turn")


@category(
    "ottoman",
    templates=3,
    names="pouf, pouffe, footstool, foot stool, hassock",
    like="bean bag, beanbag",
    kin="seat",
    carries="seat",
)
def sample_ottoman(rng: Rng, index: int) -> Sampled:
    """Cubes with a lid, poufs, footstools."""
    wide = rng.uniform(0.42, 0.7)
    deep = wide * [rng.uniform(0.7, 1.0), 1.0, rng.uniform(0.65, 0.9)][index % 3]
    size = round_size(deep, wide, rng.uniform(0.36, 0.47))
    return Sampled(size, Ottoman.sample_parameters(rng, index))


class Pillow(Generator):
    """A cushion that lies: its corners drawn out, or round."""

    style: Literal["square", "round"] = in_turn("square", "square", "round", "square")
    pinch: float = between(0.06, 0.14)  # by which the sides are drawn in
    flat: float = between(1.1, 1.4)  # how soon it is as thick as in its middle
    colour: Coating = of(FABRICS, SHADES)
    piping_colour: Coating = of(FABRICS, SHADES)

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        if self.style == "round":
            angles = np.linspace(-np.pi / 2, np.pi / 2, 9)
            side = [(0.8 + 0.2 * np.cos(a), 0.5 * z * (1 + np.sin(a))) for a in angles]
            seam = lathe([(0, 0.48 * z), (1.01, 0.48 * z), (1.01, 0.52 * z), (0, 0.52 * z)], 32)
            parts = Parts()
            parts.add(widen(lathe([(0, 0), *side, (0, z)], 32), x, y), self.colour, FOAM, smooth=True)
            parts.add(widen(seam, x, y), self.piping_colour, FOAM, smooth=True, solid=False)
            return Model(parts, symmetry="full", placement="object")
        mesh = _pillow(x, y, z, self.pinch, self.flat)
        cloth = Part(mesh, finish_of(self.colour), FOAM, (hull(mesh.vertices),), True)
        return Model([cloth], symmetry="half_turn", placement="object")


def _pillow(x: float, y: float, z: float, pinch: float, flat: float) -> Trimesh:
    """Two sheets sewn together at their edges, flat in the middle of either."""
    u, v = np.meshgrid(np.linspace(-1, 1, GRID + 1), np.linspace(-1, 1, GRID + 1), indexing="ij")
    thick = np.minimum(1, flat * ((1 - u**2) * (1 - v**2)) ** 0.4)
    across = np.stack([x * u * (1 - pinch * (1 - v**2)), y * v * (1 - pinch * (1 - u**2))], axis=-1).reshape(-1, 2)
    sheets = [np.column_stack([across, z / 2 * (1 + side * thick.ravel())]) for side in (1, -1)]
    corner = np.arange((GRID + 1) ** 2).reshape(GRID + 1, GRID + 1)
    a, b, c, d = (corner[i : i + GRID, j : j + GRID].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    up = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    down = up[:, ::-1] + corner.size
    return Trimesh(np.concatenate(sheets), np.concatenate([up, down]), process=True)


@category(
    "cushion",
    templates=4,
    names="pillow, throw pillow, couch cushion, sofa cushion, seat cushion",
    like="bolster, headrest",
    kin="cloth",
    places="top",
)
def sample_cushion(rng: Rng, index: int) -> Sampled:
    """Square ones of sofas, long ones of beds, round ones of chairs."""
    wide = rng.uniform(0.38, 0.5)
    deep = [wide, rng.uniform(0.38, 0.5), wide, wide][index % 4]
    wide = [wide, deep * rng.uniform(1.3, 1.6), wide, wide][index % 4]
    tall = rng.uniform(0.06, 0.1) if index % 4 == 2 else rng.uniform(0.11, 0.17)
    return Sampled(round_size(deep, wide, tall), Pillow.sample_parameters(rng, index))
