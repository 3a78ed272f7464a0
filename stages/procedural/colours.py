"""Palettes of finishes, and how models draw from them."""

import numpy as np

from stages.procedural.finishes import MATERIALS, RGB, Finish

Palette = list[Finish]


def _of(material: str, *colours: RGB) -> Palette:
    return [Finish(material, colour) for colour in colours]


WOODS = _of(
    "wood",
    (0.55, 0.36, 0.20),
    (0.40, 0.22, 0.11),
    (0.70, 0.52, 0.33),
    (0.26, 0.13, 0.07),
    (0.62, 0.45, 0.28),
    (0.48, 0.27, 0.13),
)
PAINTS = _of(
    "paint",
    (0.84, 0.83, 0.80),
    (0.74, 0.72, 0.66),
    (0.32, 0.42, 0.50),
    (0.30, 0.40, 0.32),
    (0.16, 0.20, 0.26),
    (0.55, 0.60, 0.58),
    (0.78, 0.70, 0.55),
    (0.45, 0.18, 0.15),
)
METALS = _of(
    "metal", (0.60, 0.61, 0.63), (0.36, 0.37, 0.39), (0.12, 0.12, 0.13), (0.62, 0.48, 0.22), (0.42, 0.28, 0.16)
)
FABRICS = _of(
    "fabric",
    (0.36, 0.36, 0.38),
    (0.22, 0.30, 0.40),
    (0.58, 0.52, 0.44),
    (0.40, 0.16, 0.14),
    (0.24, 0.34, 0.22),
    (0.62, 0.50, 0.24),
)
GLAZES = _of(
    "glaze",
    (0.86, 0.85, 0.82),
    (0.14, 0.26, 0.46),
    (0.62, 0.20, 0.12),
    (0.24, 0.42, 0.36),
    (0.82, 0.62, 0.20),
    (0.10, 0.10, 0.12),
    (0.48, 0.60, 0.66),
)
GREENS = _of("leaf", (0.12, 0.32, 0.10), (0.20, 0.42, 0.14), (0.26, 0.40, 0.20))
CARDBOARD = _of("card", (0.58, 0.42, 0.26), (0.66, 0.52, 0.34), (0.50, 0.36, 0.22))

APPLIANCE = [
    *_of("steel", (0.80, 0.81, 0.82), (0.52, 0.53, 0.55)),
    *_of("enamel", (0.10, 0.10, 0.11), (0.62, 0.20, 0.16)),
]
SHADES = _of("linen", (0.86, 0.80, 0.66), (0.80, 0.80, 0.78), (0.25, 0.28, 0.32), (0.62, 0.30, 0.20))
STONES = _of("stone", (0.80, 0.79, 0.76), (0.22, 0.22, 0.24), (0.55, 0.50, 0.44), (0.30, 0.36, 0.33))
TILES = _of("tiles", (0.82, 0.82, 0.80), (0.20, 0.34, 0.46), (0.55, 0.28, 0.18), (0.26, 0.40, 0.34))
WICKER = _of("wicker", (0.55, 0.38, 0.20), (0.68, 0.54, 0.34), (0.30, 0.18, 0.09), (0.60, 0.58, 0.54))

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
    pattern = int(1e6 * factor) % MATERIALS[finish.material]  # no draw of its own: what is drawn next stays what it was
    return str(finish.tinted([factor * channel for channel in finish.colour])._replace(pattern=pattern))
