"""One record per category of the library: what people call it, how many there are, how new models are sampled."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from roomkin.plugins.furniture.model import Size
from roomkin.plugins.furniture.recipe import Generator, Rng, Sampled, round_size

Sampler = Callable[[Rng, int], Sampled]
Fronts = tuple[str, list[list[str]]]  # columns or rows of cells, as in a cabinet's recipe


@dataclass(frozen=True, kw_only=True)
class Category:
    """A category of models. Words are separated by commas.

    Attributes:
        name: lower-case words joined by underscores.
        sample: the size and recipe of its `index`-th model, by a random generator.
        templates: models that are sampled freely, and that rooms are furnished with; later ones are their variations.
        count: models in the default library; 0: it is made where `assets.counts` asks for it alone.
        names: what else it is called: file names and labels that say so mean it.
        like: words for similar things: a label that says so is nearest to it.
        kin: kinds of things that it is one of: a label of no category is nearest to its kin.
        places: where its things are: floor, top (of what carries things), wall.
        carries: where its things carry others (`roomkin.stages.contracts.category.Carries`).
        further: numbers of later models that are sampled freely as well, in styles that templates lack: those before
            them stay as they were drawn, and rooms are not furnished with them.
        varied: later models vary a template's recipe (cabinets) in place of being sampled anew in its style.
        fronts: layouts that a variation may have; none: one cell more or less than its template.
        growth: exponents of the ratios of cells side by side and one above the other, by which a variation with other
            fronts is wider and higher.
        appliance: of steel or enamel, its fronts flat.
    """

    name: str
    sample: Sampler
    templates: int
    count: int = 5
    names: str = ""
    like: str = ""
    kin: str = ""
    places: str = "floor"
    carries: str = ""
    further: range = range(0)
    varied: bool = False
    fronts: tuple[Fronts, ...] = ()
    growth: tuple[float, float] = (1.0, 0.0)
    appliance: bool = False


def category(name: str, **fields: Any) -> Callable[[Sampler], Category]:
    """The decorator that makes a category of a function that samples its models; `fields` are those of `Category`."""
    return lambda sample: Category(name=name, sample=sample, **fields)


def sized(generator: type[Generator], *ranges: tuple[Size, Size], digits: int = 3) -> Sampler:
    """What samples models of a generator between a lowest and a highest size, of the first, second... range in turn."""

    def sample(rng: Rng, index: int) -> Sampled:
        x, y, z = rng.uniform(*ranges[index % len(ranges)])
        return Sampled(round_size(x, y, z, digits), generator.sample_parameters(rng, index))

    return sample
