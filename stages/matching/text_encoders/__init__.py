"""How labels are compared with categories (paper 2.1); the implementations lie beside this file."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.matching import CandidateOptions
from roomkin.stages.plugins import load


class TextEncoder(Protocol):
    """Made from the options of `matching`, as far as they say what is compared."""

    def distance(self, label: str, categories: Sequence[str]) -> NDArray[np.float64]:
        """Distance (C,) of the label to each category; inf: they have nothing in common."""
        ...


def make_text_encoder(options: CandidateOptions) -> TextEncoder:
    """The text encoder that the options name."""
    encoder: TextEncoder = load("text_encoders", options.text_encoder)(options)
    return encoder


def find_nearest_categories(
    label: str, categories: Sequence[str], count: int, text: TextEncoder
) -> list[tuple[str, float]]:
    """The `count` nearest categories with their distances, nearest first; ties by name.

    Fewer, or none, if the others have nothing in common with the label.
    """
    names = sorted(set(categories))
    if not names:
        return []
    distances = np.round(text.distance(label, names), 6)
    order = np.argsort(distances, kind="stable")[:count]
    return [(names[index], float(distances[index])) for index in order if np.isfinite(distances[index])]


def find_doubt(label: str, categories: Sequence[str], text: TextEncoder) -> str:
    """What an encoder does not understand of a label, if it can tell (a method `doubt`); empty: nothing."""
    tells = getattr(text, "doubt", None)
    return str(tells(label, categories)) if tells else ""
