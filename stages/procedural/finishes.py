"""What a surface is of: a material in a colour, as recipes write it and as models show it."""

from collections.abc import Sequence
from typing import NamedTuple

RGB = tuple[float, float, float]  # linear
Surface = str | Sequence[float]  # as a recipe writes it: 'wood 0.55 0.36 0.2 1', or the rgb of plain paint
PLAIN = {"paint": 1, "metal": 1, "enamel": 1}  # material -> number of its patterns; these show their colour alone
PATTERNED = {
    "wood": 4, "steel": 1, "fabric": 4, "glaze": 4, "stone": 3, "tiles": 3, "card": 2, "leaf": 2, "linen": 1,
    "wicker": 2,
}  # fmt: skip
MATERIALS = PLAIN | PATTERNED


class Finish(NamedTuple):
    """A material in a colour; `pattern` tells apart the grains, weaves... of a material (`textures.py`)."""

    material: str
    colour: RGB
    pattern: int = 0

    def __str__(self) -> str:
        """As a recipe writes it."""
        r, g, b = self.colour
        return f"{self.material} {r:g} {g:g} {b:g} {self.pattern}"

    def tinted(self, colour: Sequence[float]) -> "Finish":
        """The same in another colour."""
        r, g, b = (round(min(max(float(channel), 0.0), 1.0), 3) for channel in colour)
        return self._replace(colour=(r, g, b))


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
    if not 0 <= int(pattern) < MATERIALS.get(material, 0):
        raise ValueError(f"'{surface}': no such material ({', '.join(sorted(MATERIALS))}) or pattern")
    if not all(0 <= channel <= 1 for channel in (r, g, b)):
        raise ValueError(f"'{surface}': colours go from 0 to 1")
    return Finish(material, (r, g, b), int(pattern))


def shade(surface: Surface, factor: float) -> str:
    """A darker or lighter version."""
    finish = finish_of(surface)
    return str(finish.tinted([factor * channel for channel in finish.colour]))


def made_of(material: str, surface: Surface) -> str:
    """The same colour on another material."""
    finish = finish_of(surface)
    return str(Finish(material, finish.colour, finish.pattern % MATERIALS[material]))


def brightness(surface: Surface) -> float:
    """Mean of the colour's channels."""
    return sum(finish_of(surface).colour) / 3
