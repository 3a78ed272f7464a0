"""Fields of a recipe, each with the range that new models sample it from."""

from collections.abc import Callable
from typing import Any

from pydantic import Field

from roomkin.plugins.furniture.colors import Palette, pick
from roomkin.plugins.furniture.recipe import Rng, uniform


def sampled_by(sample: Callable[[Rng, int], Any], **bounds: Any) -> Any:
    """A field that is sampled by a function of a random generator and the number of the model."""
    return Field(json_schema_extra={"sample": sample}, **bounds)  # type: ignore[dict-item]


def between(low: float, high: float, **bounds: Any) -> Any:
    """A number between the limits, in thousandths."""
    return sampled_by(lambda rng, _: uniform(rng, low, high), **bounds)


def zero_or(low: float, high: float, **bounds: Any) -> Any:
    """Zero, or as often a number between the limits."""
    return sampled_by(lambda rng, _: round(float(rng.choice([0.0, rng.uniform(low, high)])), 3), **bounds)


def whole(low: int, high: int, **bounds: Any) -> Any:
    """A whole number from `low` to `high` - 1."""
    return sampled_by(lambda rng, _: int(rng.integers(low, high)), **bounds)


def chance(share: float = 0.5, **bounds: Any) -> Any:
    """True for this share of the models."""
    return sampled_by(lambda rng, _: bool(rng.random() < share), **bounds)


def one_of(*choices: Any, shares: list[float] | None = None, **bounds: Any) -> Any:
    """One of the choices at random."""
    return sampled_by(lambda rng, _: type(choices[0])(rng.choice(list(choices), p=shares)), **bounds)


def in_turn(*choices: Any, **bounds: Any) -> Any:
    """The choices in turn, by the number of the model."""
    return sampled_by(lambda _, index: choices[index % len(choices)], **bounds)


def fixed(value: Any) -> Any:
    """The same for every sampled model, and what counts where a recipe does not say."""
    return sampled_by(lambda *_: value, default=value)


def of(*palettes: Palette) -> Any:
    """A finish of the palettes."""
    return sampled_by(lambda rng, _: pick(rng, *palettes))
