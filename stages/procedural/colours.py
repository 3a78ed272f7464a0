"""Palettes of linear RGB, and how models draw from them."""

import numpy as np

Palette = list[tuple[float, float, float]]

WOODS: Palette = [
    (0.55, 0.36, 0.20),
    (0.40, 0.22, 0.11),
    (0.70, 0.52, 0.33),
    (0.26, 0.13, 0.07),
    (0.62, 0.45, 0.28),
    (0.48, 0.27, 0.13),
]
PAINTS: Palette = [
    (0.84, 0.83, 0.80),
    (0.74, 0.72, 0.66),
    (0.32, 0.42, 0.50),
    (0.30, 0.40, 0.32),
    (0.16, 0.20, 0.26),
    (0.55, 0.60, 0.58),
    (0.78, 0.70, 0.55),
    (0.45, 0.18, 0.15),
]
METALS: Palette = [(0.60, 0.61, 0.63), (0.36, 0.37, 0.39), (0.12, 0.12, 0.13), (0.62, 0.48, 0.22), (0.42, 0.28, 0.16)]
FABRICS: Palette = [
    (0.36, 0.36, 0.38),
    (0.22, 0.30, 0.40),
    (0.58, 0.52, 0.44),
    (0.40, 0.16, 0.14),
    (0.24, 0.34, 0.22),
    (0.62, 0.50, 0.24),
]
GLAZES: Palette = [
    (0.86, 0.85, 0.82),
    (0.14, 0.26, 0.46),
    (0.62, 0.20, 0.12),
    (0.24, 0.42, 0.36),
    (0.82, 0.62, 0.20),
    (0.10, 0.10, 0.12),
    (0.48, 0.60, 0.66),
]
GREENS: Palette = [(0.12, 0.32, 0.10), (0.20, 0.42, 0.14), (0.26, 0.40, 0.20)]
CARDBOARD: Palette = [(0.58, 0.42, 0.26), (0.66, 0.52, 0.34), (0.50, 0.36, 0.22)]


def pick(rng: np.random.Generator, *palettes: Palette, spread: float = 0.08) -> list[float]:
    """A colour of the palettes, brightened or darkened by up to `spread`."""
    choices = [colour for palette in palettes for colour in palette]
    colour = np.array(choices[rng.integers(len(choices))]) * rng.uniform(1 - spread, 1 + spread)
    return [round(float(c), 3) for c in np.clip(colour, 0.0, 1.0)]


def shade(colour: list[float], factor: float) -> list[float]:
    """A darker or lighter version."""
    return [round(float(min(1.0, c * factor)), 3) for c in colour]
