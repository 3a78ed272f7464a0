"""Typed recipes: the parameters of a generator, each with the range that new models sample it from."""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from roomkin.plugins.furniture.colors import Palette, pick
from roomkin.plugins.furniture.finishes import finish_of
from roomkin.plugins.furniture.model import Model, Size

Rng = np.random.Generator


def _check_surface(surface: str | list[float]) -> str | list[float]:
    finish_of(surface)
    return surface


Coating = Annotated[str | list[float], AfterValidator(_check_surface)]  # a material in a color: see `finishes`


class Generator(BaseModel):
    """The parameters of a parametric model, and how it is built from them. Lengths in metres.

    A field declared by `between(...)`, `of(...)` and so on is sampled; the others are given when a model is sampled.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @abstractmethod
    def build(self, size: Size) -> Model:
        """The model, about as large as asked: z up, front towards +x."""

    @property
    def fronts(self) -> tuple[int, int]:
        """Doors (and flaps) and drawers of the model."""
        return 0, 0

    @classmethod
    def sample_parameters(cls, rng: Rng, index: int, **given: Any) -> Self:
        """Parameters of the `index`-th model, sampled in the order of the fields; `given` may hold functions."""
        values = {}
        for name, field in cls.model_fields.items():
            extra: Any = field.json_schema_extra or {}
            if name in given:
                value = given[name]
                values[name] = value() if callable(value) else value
            elif "sample" in extra:
                values[name] = extra["sample"](rng, index)
        return cls.model_validate(values)

    def change_parameters(self, **changes: Any) -> Self:
        """The recipe with some parameters changed, checked again."""
        return self.model_validate(self.parameters() | changes)

    def parameters(self) -> dict[str, Any]:
        """The parameters, given or sampled, as the recipe of an asset records them."""
        return self.model_dump(exclude_unset=True)


@dataclass(frozen=True)
class Sampled:
    """A sampled member of a category: the size of its closed box, and the generator that builds it."""

    size: Size
    recipe: Generator


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


def uniform(rng: Rng, low: float, high: float, digits: int = 3) -> float:
    """A rounded random number."""
    return round(float(rng.uniform(low, high)), digits)


def round_size(x: float, y: float, z: float, digits: int = 3) -> Size:
    """A size, rounded."""
    return (round(float(x), digits), round(float(y), digits), round(float(z), digits))
