"""The categories of the library, found in `categories/`, and their models by number: templates and their relatives.

Of cabinets every other generation is near its template (the same fronts and kind of handle in other proportions,
finishes, panels), the others are farther: other fronts, handles, hinges. Relatives of all else are sampled anew in the
style of their template (docs/assets.md).
"""

import inspect
import math
import re
import zlib
from functools import cache
from typing import Any, get_args

import numpy as np

from roomkin.plugins.furniture import categories
from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.category import Category, Fronts
from roomkin.plugins.furniture.colors import APPLIANCE, METALS, PAINTS, WOODS, pick
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.fronts import HANDLE_SHARES, HANDLES, STYLES, PanelStyle
from roomkin.plugins.furniture.recipe import Generator, Rng, Sampled, round_size, uniform
from roomkin.stages.contracts.library import Recipe, model_name

IN_TURN = 24  # models of a category that vary its templates in turn, at least
ABOUT = 2  # doors and drawers more or less, as matching's count_threshold (A.7)


def in_turn(category: Category, index: int) -> bool:
    """Whether a relative varies the template whose turn it is; later ones go where models with such fronts are few."""
    return not category.fronts or index < max(IN_TURN, 3 * category.templates // 2)


def find_rarest_template(fronts: list[tuple[int, int]], templates: int) -> int:
    """Which template has the fewest models with about its numbers of doors and drawers; `fronts`: of all models."""
    alike = [sum(abs(a - c) + abs(b - d) <= ABOUT for c, d in fronts) for a, b in fronts[:templates]]
    return alike.index(min(alike))


def vary_template(category: Category, template: Sampled, generation: int, rng: Rng, any_fronts: bool = True) -> Sampled:
    """A variation of a template that is a cabinet; odd generations are near, even ones farther from it: with any
    fronts of their category, or with one cell more or less than it."""
    recipe, far = template.recipe, generation % 2 == 0
    assert isinstance(recipe, Cabinet)
    changes: dict[str, Any] = _sample_appearance(category, rng)
    # Wider and lower, or narrower and higher: a relative does not fit into its template's box unchanged.
    spread = 0.22 if far else 0.14
    wider = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0))
    factors = rng.uniform(-1.0, 1.0), wider, -wider * rng.uniform(0.5, 1.0)
    x, y, z = (extent * math.exp(spread * factor) for extent, factor in zip(template.size, factors, strict=True))
    changes["handle_length"] = _clip_value(recipe.handle_length * rng.uniform(0.7, 1.5), 0.1, 0.6)
    changes["handle_at"] = _clip_value(recipe.handle_at + rng.uniform(-0.25, 0.25), -1.0, 1.0)
    changes["drawer_weight"] = _clip_value(recipe.drawer_weight * rng.uniform(0.8, 1.3), 0.15, 0.6)
    if far:
        handle = str(rng.choice(HANDLES, p=HANDLE_SHARES))
        changes |= {"handle": handle, "protrusion": STYLES[handle].protrusion, "hinge": int(rng.choice([-1, 1]))}  # type: ignore[index]
        changes["handle_at"] = uniform(rng, -0.9, 0.9)
        if category.fronts and recipe.column_weights is None:
            fronts = list(category.fronts) if any_fronts else _change_cells(recipe)
            major, layout = fronts[int(rng.integers(len(fronts)))]
            across, up = _grid(recipe.major, recipe.layout)
            new_across, new_up = _grid(major, layout)
            y *= (new_across / across) ** category.growth[0]
            z *= (new_up / up) ** category.growth[1]
            changes |= {"major": major, "layout": layout}
    elif rng.random() < 0.5:
        changes["inset_front"] = not recipe.inset_front and not category.appliance
    return Sampled(round_size(x, y, z), recipe.change_parameters(**changes))


def _sample_appearance(category: Category, rng: Rng) -> dict[str, Any]:
    """Colors, and where it is no appliance the style of the panels."""
    front = pick(rng, APPLIANCE) if category.appliance else pick(rng, PAINTS, WOODS)
    body = shade(front, 0.82) if rng.random() < 0.6 or category.appliance else pick(rng, PAINTS, WOODS)
    appearance: dict[str, Any] = {"front_colour": front, "body_colour": body, "handle_colour": pick(rng, METALS)}
    if category.appliance:
        return appearance | {"field_colour": front}
    panel = str(rng.choice(get_args(PanelStyle)))
    return appearance | {"field_colour": shade(front, float(rng.choice([0.72, 0.85, 1.2]))), "panel": panel}


def _change_cells(recipe: Cabinet) -> list[Fronts]:
    """The recipe's fronts with one cell more or less in one of its lines."""
    found: list[Fronts] = []
    for k, line in enumerate(recipe.layout):
        for changed in ([*line, line[-1]], line[:-1] if len(line) > 1 else None):
            if changed is not None:
                lines = [*recipe.layout[:k], changed, *recipe.layout[k + 1 :]]
                found.append((recipe.major, [[str(cell) for cell in each] for each in lines]))
    return found


def _grid(major: str, layout: list[Any]) -> tuple[int, int]:
    """How many cells lie side by side, and how many one above the other."""
    longest = max(len(line) for line in layout)
    return (len(layout), longest) if major == "columns" else (longest, len(layout))


def _clip_value(value: float, low: float, high: float) -> float:
    return round(float(min(max(value, low), high)), 3)


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
    goes_in_turn = in_turn(record, index)
    if not goes_in_turn:
        template = find_rarest_template([_fronts(category, k, seed) for k in range(index)], record.templates)
    if not record.varied:
        return record.sample(rng, template), template  # in the template's style: styles go by number
    first = record.sample(_generator(category, template, seed), template)
    generation = index // record.templates if goes_in_turn else index
    return vary_template(record, first, generation, rng, any_fronts=goes_in_turn), template


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
