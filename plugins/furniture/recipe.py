"""Typed recipes: the parameters of a generator, each with the range that new models sample it from."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict

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


def uniform(rng: Rng, low: float, high: float, digits: int = 3) -> float:
    """A rounded random number."""
    return round(float(rng.uniform(low, high)), digits)


def round_size(x: float, y: float, z: float, digits: int = 3) -> Size:
    """A size, rounded."""
    return (round(float(x), digits), round(float(y), digits), round(float(z), digits))
