"""The categories of the library and the generators that recipes name, found in `categories/`; recipes by number."""

import inspect
import re
import zlib
from functools import cache

import numpy as np

from roomkin.plugins.furniture import categories, families
from roomkin.plugins.furniture.category import Category
from roomkin.plugins.furniture.recipe import Generator, Sampled
from roomkin.stages.contracts.library import Recipe, model_name

_FOUND = [value for module in categories.modules() for value in vars(module).values()]
ALL: dict[str, Category] = {
    record.name: record
    for record in sorted((value for value in _FOUND if isinstance(value, Category)), key=lambda record: record.name)
}
CATEGORIES = {name: record for name, record in ALL.items() if record.count}  # of the default library
GENERATORS: dict[str, type[Generator]] = {
    re.sub(r"(?<=[a-z])(?=[A-Z])", "_", value.__name__).lower(): value
    for value in _FOUND
    if isinstance(value, type) and issubclass(value, Generator) and not inspect.isabstract(value)
}


def sample(category: str, index: int, seed: int, variations: bool = True) -> Recipe:
    """The recipe of the `index`-th model of a category; it does not depend on how many others there are.

    Args:
        category: one of `ALL`.
        index: number of the model.
        seed: of the library.
        variations: whether models after the category's templates are variations of them; else each is a template.
    """
    sampled, template = _sample_indexed(category, index, seed, variations)
    generator = next(name for name, kind in GENERATORS.items() if kind is type(sampled.recipe))
    parameters = {"size": list(sampled.size), **sampled.recipe.parameters()}
    variation_of = None if template is None else model_name(category, template)
    return Recipe(generator=generator, parameters=parameters, variation_of=variation_of)


def _sample_indexed(category: str, index: int, seed: int, variations: bool = True) -> tuple[Sampled, int | None]:
    """A model of a category, and the number of its template; None: it is one."""
    record, rng = ALL[category], _generator(category, index, seed)
    template = index % record.templates
    if index < record.templates or not variations:
        return record.sample(rng, index), None
    if index in record.further:
        return record.sample(rng, index), template
    in_turn = families.in_turn(record, index)
    if not in_turn:
        template = families.find_rarest_template([_fronts(category, k, seed) for k in range(index)], record.templates)
    if not record.varied:
        return record.sample(rng, template), template  # in the template's style: styles go by number
    first = record.sample(_generator(category, template, seed), template)
    generation = index // record.templates if in_turn else index
    return families.vary_template(record, first, generation, rng, any_fronts=in_turn), template


@cache
def has_fronts(category: str) -> tuple[bool, bool]:
    """Whether templates of a category have doors (or flaps), and whether they have drawers."""
    record = ALL.get(category)
    counts = [_fronts(category, k, 0) for k in range(record.templates)] if record else []
    return any(doors for doors, _ in counts), any(drawers for _, drawers in counts)


@cache
def leaves(category: str) -> tuple[int, int]:
    """How many doors on upright hinges, and how many flaps, the templates of a category have."""
    templates = range(ALL[category].templates if category in ALL else 0)
    recipes = [_sample_indexed(category, index, 0)[0].recipe for index in templates]
    flaps = sum(line.count("flap") for recipe in recipes for line in getattr(recipe, "layout", []))
    return sum(recipe.fronts[0] for recipe in recipes) - flaps, flaps


@cache
def _fronts(category: str, index: int, seed: int) -> tuple[int, int]:
    """Doors (and flaps) and drawers of a model."""
    return _sample_indexed(category, index, seed)[0].recipe.fronts


def _generator(category: str, index: int, seed: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(category.encode()), index)))
