"""Small tileable pictures of materials, made of filtered noise: grain, weave, tiles, veins, glaze.

The renderer has no mipmaps: a pattern is smooth at the scale of its texels, so that it does not flicker from afar.
"""

import io
from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.plugins.furniture.finishes import MATERIALS, Finish
from roomkin.stages.articulated.model import Texture

Array = NDArray[np.float64]
Rng = np.random.Generator

SIDE = 128  # texels


@lru_cache(maxsize=1024)
def texture_of(finish: Finish) -> Texture | None:
    """The picture that a finish is drawn with; None: its color alone."""
    repeat = MATERIALS[finish.material].repeat
    shades = pattern_of(finish.material, finish.pattern) if repeat else None
    if repeat is None or shades is None:
        return None
    linear = np.clip(shades[..., None] * np.array(finish.color), 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    file = io.BytesIO()
    Image.fromarray((255 * encoded).round().astype(np.uint8)).save(file, "JPEG", quality=88)
    red, green, blue = (round(255 * channel) for channel in finish.color)
    name = f"{finish.material}_{finish.pattern}_{red:02x}{green:02x}{blue:02x}"
    return Texture(name, file.getvalue(), repeat)


@cache
def pattern_of(material: str, pattern: int) -> Array | None:
    """Factors (SIDE, SIDE) on the color, mean 1; rows run across, columns along the grain. None: a plain variant."""
    shades = PATTERNS[material](np.random.default_rng([len(material), pattern]), pattern)
    return None if shades is None else np.clip(shades / shades.mean(), 0.3, 1.7)


def noise(rng: Rng, along: float, across: float) -> Array:
    """Smooth periodic noise of mean 0 and deviation 1; correlated over that many texels."""
    frequency = np.fft.fftfreq(SIDE)
    keep = np.exp(-2 * (np.pi * frequency * along) ** 2)[None] * np.exp(-2 * (np.pi * frequency * across) ** 2)[:, None]
    keep[0, 0] = 0.0
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal((SIDE, SIDE))) * keep).real
    return np.asarray(field / field.std())


def _grid() -> tuple[Array, Array]:
    """Shares of the side, across and along, (SIDE, 1) and (1, SIDE)."""
    steps = np.arange(SIDE) / SIDE
    return steps[:, None], steps[None]


def _wood(rng: Rng, pattern: int) -> Array:
    """Fine straight grain, flames, boards, or grain with flecks."""
    across, along = _grid()
    grain = 1 + 0.08 * noise(rng, 60, 2.5) + 0.05 * noise(rng, 25, 1.5)
    if pattern == 1:
        bent = across + 0.06 * noise(rng, 22, 14)
        grain = grain + 0.13 * np.sin(2 * np.pi * 7 * bent) * (1 + 0.3 * np.sin(2 * np.pi * along))
    elif pattern == 2:
        board = (4 * across).astype(int)[:, 0]
        rows = np.stack([np.roll(row, 37 * k) for row, k in zip(grain, board, strict=True)])
        joint = np.minimum(4 * across % 1, 1 - 4 * across % 1) < 0.03
        grain = rows * np.array([1.0, 0.89, 1.07, 0.95])[board][:, None] * np.where(joint, 0.55, 1.0)
    elif pattern == 3:
        grain = grain - 0.22 * (noise(rng, 7, 1.2) > 1.6)
    return np.asarray(grain)


def _steel(rng: Rng, pattern: int) -> Array:
    """Brushed along."""
    return 1 + 0.035 * noise(rng, 40, 1.2)


def _weave(threads: int) -> Array:
    """Threads that pass over and under each other: light where one is on top, dark between."""
    across, along = _grid()
    over = (np.floor(threads * across) + np.floor(threads * along)) % 2
    warp, weft = np.abs(np.sin(np.pi * threads * across)), np.abs(np.sin(np.pi * threads * along))
    return np.asarray(np.where(over == 0, warp, weft))


def _fabric(rng: Rng, pattern: int) -> Array:
    """Melange, coarse weave, stripes, or checks."""
    across, along = _grid()
    cloth = 1 + 0.07 * noise(rng, 1.8, 1.8)
    if pattern == 1:
        return np.asarray(cloth + 0.3 * _weave(16))
    if pattern == 2:
        return np.asarray(cloth * np.where((6 * across) % 1 < 0.4, 0.62, 1.1))
    if pattern == 3:
        bands = [np.where((3 * share) % 1 < 0.35, 0.7, 1.1) for share in (across, along)]
        return np.asarray(cloth * bands[0] * bands[1])
    return cloth


def _glaze(rng: Rng, pattern: int) -> Array | None:
    """Even (two of four), speckled, or mottled."""
    if pattern == 1:
        return np.asarray(1 - 0.45 * (noise(rng, 1.6, 1.6) > 2.0) + 0.03 * noise(rng, 12, 12))
    return np.asarray(1 + 0.13 * noise(rng, 10, 10)) if pattern == 2 else None


def _stone(rng: Rng, pattern: int) -> Array:
    """Marble with veins, granite, or terrazzo."""
    if pattern == 0:
        veins = np.exp(-((noise(rng, 18, 9) / 0.09) ** 2)) * (0.6 + 0.4 * np.tanh(noise(rng, 14, 14)))
        return np.asarray(1 + 0.05 * noise(rng, 12, 12) - 0.35 * veins)
    if pattern == 1:
        return np.asarray(1 + 0.14 * noise(rng, 1.5, 1.5))
    chips = [(noise(rng, 3, 3) > 1.1) * factor for factor in (0.35, -0.3, -0.55)]
    return np.asarray(1 + sum(chips))


def _tiles(rng: Rng, pattern: int) -> Array:
    """Four by four square tiles, two by six staggered ones, or a chequerboard."""
    rows, columns = (6, 2) if pattern == 1 else (4, 4)
    across, along = _grid()
    row = np.floor(rows * across).astype(int)
    shifted = (along + (row % 2) * (0.5 / columns if pattern == 1 else 0.0)) % 1
    column = np.floor(columns * shifted).astype(int)
    edge = [np.minimum(x % 1, 1 - x % 1) / count for x, count in ((rows * across, rows), (columns * shifted, columns))]
    joint = np.minimum(*edge) < 1.6 / SIDE
    tone = (
        np.where((row + column) % 2, 1.25, 0.75)
        if pattern == 2
        else 1 + 0.08 * rng.standard_normal((6, 4))[row, column]
    )
    return np.where(joint, 0.5, tone)


def _card(rng: Rng, pattern: int) -> Array:
    """Smooth, or with the waves of its core showing."""
    paper = 1 + 0.04 * noise(rng, 2, 2)
    return np.asarray(paper + pattern * 0.05 * np.sin(2 * np.pi * 20 * _grid()[1]))


def _leaf(rng: Rng, pattern: int) -> Array:
    """Foliage, or large leaves."""
    return np.asarray(1 + 0.25 * noise(rng, 5, 5)) if pattern else np.asarray(1 + 0.3 * noise(rng, 2.5, 2.5))


def _linen(rng: Rng, pattern: int) -> Array:
    """Thin uneven threads both ways."""
    return 1 + 0.05 * noise(rng, 20, 1.2) + 0.05 * noise(rng, 1.2, 20)


def _wicker(rng: Rng, pattern: int) -> Array:
    """Cane, fine or coarse."""
    return 0.45 + _weave(16 if pattern else 10) + 0.05 * noise(rng, 3, 3)


PATTERNS: dict[str, Callable[[Rng, int], Array | None]] = {
    "wood": _wood, "steel": _steel, "fabric": _fabric, "glaze": _glaze, "stone": _stone, "tiles": _tiles,
    "card": _card, "leaf": _leaf, "linen": _linen, "wicker": _wicker,
}  # fmt: skip
