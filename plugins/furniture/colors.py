"""Palettes of finishes, and how models sample from them."""

import numpy as np

from roomkin.plugins.furniture.finishes import MATERIALS, Finish

Palette = list[Finish]


def _of(material: str) -> Palette:
    return [Finish(material, color) for color in MATERIALS[material].colors]


WOODS, PAINTS, METALS, FABRICS, GLAZES = map(_of, ("wood", "paint", "metal", "fabric", "glaze"))
GREENS, CARDBOARD, SHADES, WICKER = map(_of, ("leaf", "card", "linen", "wicker"))
STONES, TILES = map(_of, ("stone", "tiles"))
APPLIANCE = _of("steel") + _of("enamel")

# What else a thing may be finished in that is finished in a material: the same thing in another shop window.
ALTERNATIVES: dict[str, Palette] = {
    "wood": WOODS + PAINTS, "paint": WOODS + PAINTS, "metal": METALS, "steel": APPLIANCE, "enamel": APPLIANCE,
    "fabric": FABRICS, "glaze": GLAZES, "leaf": GREENS, "card": CARDBOARD, "linen": SHADES, "stone": STONES + TILES,
    "tiles": STONES + TILES, "wicker": WICKER,
}  # fmt: skip


def pick(rng: np.random.Generator, *palettes: Palette, spread: float = 0.08) -> str:
    """A finish of the palettes, brightened or darkened by up to `spread`, in any of its material's patterns."""
    choices = [finish for palette in palettes for finish in palette]
    finish = choices[rng.integers(len(choices))]
    factor = rng.uniform(1 - spread, 1 + spread)
    # Derived from the factor, so that the random numbers after it stay the same.
    pattern = int(1e6 * factor) % MATERIALS[finish.material].patterns
    return str(finish.change_color([factor * channel for channel in finish.color])._replace(pattern=pattern))
