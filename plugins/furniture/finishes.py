"""The finish of a surface: a material in a color, as recipes write it and as models show it."""

from collections.abc import Sequence
from typing import NamedTuple

RGB = tuple[float, float, float]  # linear
Surface = str | Sequence[float]  # as a recipe writes it: 'wood 0.55 0.36 0.2 1', or the rgb of plain paint


class Material(NamedTuple):
    """A material of things.

    colors: that it is sold in. repeat: metres that the picture of its texture covers, along and across; None: it shows
    its color alone. patterns: number of its grains, weaves... (`textures.py`).
    """

    colors: tuple[RGB, ...]
    repeat: tuple[float, float] | None = None
    patterns: int = 1


MATERIALS = {
    "wood": Material(
        ((0.55, 0.36, 0.20), (0.40, 0.22, 0.11), (0.70, 0.52, 0.33), (0.26, 0.13, 0.07), (0.62, 0.45, 0.28),
         (0.48, 0.27, 0.13)), (1.0, 0.36), 4,
    ),
    "paint": Material(
        ((0.84, 0.83, 0.80), (0.74, 0.72, 0.66), (0.32, 0.42, 0.50), (0.30, 0.40, 0.32), (0.16, 0.20, 0.26),
         (0.55, 0.60, 0.58), (0.78, 0.70, 0.55), (0.45, 0.18, 0.15)),
    ),
    "metal": Material(
        ((0.60, 0.61, 0.63), (0.36, 0.37, 0.39), (0.12, 0.12, 0.13), (0.62, 0.48, 0.22), (0.42, 0.28, 0.16)),
    ),
    "steel": Material(((0.80, 0.81, 0.82), (0.52, 0.53, 0.55)), (0.6, 0.3)),
    "enamel": Material(((0.10, 0.10, 0.11), (0.62, 0.20, 0.16))),
    "fabric": Material(
        ((0.36, 0.36, 0.38), (0.22, 0.30, 0.40), (0.58, 0.52, 0.44), (0.40, 0.16, 0.14), (0.24, 0.34, 0.22),
         (0.62, 0.50, 0.24)), (0.36, 0.36), 4,
    ),
    "glaze": Material(
        ((0.86, 0.85, 0.82), (0.14, 0.26, 0.46), (0.62, 0.20, 0.12), (0.24, 0.42, 0.36), (0.82, 0.62, 0.20),
         (0.10, 0.10, 0.12), (0.48, 0.60, 0.66)), (0.24, 0.24), 4,
    ),
    "stone": Material(
        ((0.80, 0.79, 0.76), (0.22, 0.22, 0.24), (0.55, 0.50, 0.44), (0.30, 0.36, 0.33)), (0.7, 0.7), 3
    ),
    "tiles": Material(
        ((0.82, 0.82, 0.80), (0.20, 0.34, 0.46), (0.55, 0.28, 0.18), (0.26, 0.40, 0.34)), (0.4, 0.4), 3
    ),
    "card": Material(((0.58, 0.42, 0.26), (0.66, 0.52, 0.34), (0.50, 0.36, 0.22)), (0.3, 0.3), 2),
    "leaf": Material(((0.12, 0.32, 0.10), (0.20, 0.42, 0.14), (0.26, 0.40, 0.20)), (0.2, 0.2), 2),
    "linen": Material(((0.86, 0.80, 0.66), (0.80, 0.80, 0.78), (0.25, 0.28, 0.32), (0.62, 0.30, 0.20)), (0.2, 0.2)),
    "wicker": Material(
        ((0.55, 0.38, 0.20), (0.68, 0.54, 0.34), (0.30, 0.18, 0.09), (0.60, 0.58, 0.54)), (0.16, 0.16), 2
    ),
}  # fmt: skip
DARK = (0.05, 0.05, 0.06)  # paint of screens, openings and hands of clocks


class Finish(NamedTuple):
    """A material in a color; `pattern` tells apart the grains, weaves... of a material (`textures.py`)."""

    material: str
    color: RGB
    pattern: int = 0

    def __str__(self) -> str:
        """As a recipe writes it."""
        r, g, b = self.color
        return f"{self.material} {r:g} {g:g} {b:g} {self.pattern}"

    def change_color(self, color: Sequence[float]) -> "Finish":
        """The same in another color."""
        r, g, b = (round(min(max(float(channel), 0.0), 1.0), 3) for channel in color)
        return self._replace(color=(r, g, b))


def finish_of(surface: Surface) -> Finish:
    """A surface as a recipe writes it.

    Raises:
        ValueError: no such material or pattern, or not three channels between 0 and 1.
    """
    if isinstance(surface, str):
        material, *channels, pattern = surface.split()
    else:
        material, channels, pattern = "paint", [str(channel) for channel in surface], "0"
    r, g, b = (float(channel) for channel in channels)
    if material not in MATERIALS or not 0 <= int(pattern) < MATERIALS[material].patterns:
        raise ValueError(f"'{surface}': no such material ({', '.join(sorted(MATERIALS))}) or pattern")
    if not all(0 <= channel <= 1 for channel in (r, g, b)):
        raise ValueError(f"'{surface}': colors go from 0 to 1")
    return Finish(material, (r, g, b), int(pattern))


def shade(surface: Surface, factor: float) -> str:
    """A darker or lighter version."""
    finish = finish_of(surface)
    return str(finish.change_color([factor * channel for channel in finish.color]))


def change_material(material: str, surface: Surface) -> str:
    """The same color on another material."""
    finish = finish_of(surface)
    return str(Finish(material, finish.color, finish.pattern % MATERIALS[material].patterns))
