"""Random assemblies of solids: shapes that belong to no category, so that the encoder does not rely on categories."""

import numpy as np

from plugins.furniture.model import Model, Part, part
from plugins.furniture.shapes import cushion, lathe, rod, rotate, slab, translate

PALETTE_VALUE = (0.05, 0.9)


def assembly(rng: np.random.Generator) -> Model:
    """Three to nine boxes, rods, cushions and turned solids, some of them mirrored at the middle or in a row."""
    parts: list[Part] = []
    colours = rng.uniform(*PALETTE_VALUE, size=(int(rng.integers(1, 4)), 3)).round(3)
    extent = rng.uniform(0.4, 1.0, 3)
    for _ in range(int(rng.integers(3, 10))):
        colour = colours[int(rng.integers(len(colours)))].tolist()
        centre = rng.uniform(-0.5, 0.5, 3) * extent + [0, 0, 0.5 * extent[2]]
        mesh = _solid(rng, extent)
        offsets = _places(rng, centre)
        parts += [part(translate(mesh, offset), colour) for offset in offsets]
    return Model(parts)


def _solid(rng: np.random.Generator, extent: np.ndarray):  # type: ignore[no-untyped-def,type-arg]
    """A convex solid about the origin."""
    size = extent * rng.uniform(0.04, 0.8, 3) * rng.choice([0.3, 1.0], 3)
    kind = int(rng.integers(4))
    if kind == 0:
        mesh = slab([0, 0, 0], size)
    elif kind == 1:
        mesh = cushion(-size / 2, size / 2, 0.2 * float(size.min()))
    elif kind == 2:
        radius, tip = rng.uniform(0.02, 0.12, 2)
        half = rng.uniform(-0.4, 0.4, 3) * extent + [0, 0, 0.05]
        mesh = rod(-half, half, float(radius), float(tip))
    else:
        low, high, height = *rng.uniform(0.05, 0.35, 2), rng.uniform(0.1, 0.8) * extent[2]
        mesh = lathe([(0, -height / 2), (low, -height / 2), (high, height / 2), (0, height / 2)])
    axis = np.eye(3)[int(rng.integers(3))]
    return rotate(mesh, float(rng.uniform(-0.6, 0.6)), axis) if rng.random() < 0.25 else mesh


def _places(rng: np.random.Generator, centre: np.ndarray) -> list[list[float]]:  # type: ignore[type-arg]
    """Where a solid stands: once, mirrored at the middle, or in a row."""
    kind = rng.random()
    if kind < 0.5:
        return [centre.tolist()]
    if kind < 0.75:
        return [centre.tolist(), (centre * [1, -1, 1]).tolist()]
    step = np.eye(3)[int(rng.integers(1, 3))] * rng.uniform(0.08, 0.3)
    return [(centre + k * step).tolist() for k in range(int(rng.integers(2, 5)))]
