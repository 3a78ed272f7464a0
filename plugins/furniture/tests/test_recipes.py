"""Typed recipes: fields are sampled in order, what is given is not sampled, categories are found by folder."""

import numpy as np
import pytest
from pydantic import ValidationError

from roomkin.plugins.furniture.catalogue import CATEGORIES, GENERATORS, has_fronts, sample
from roomkin.plugins.furniture.colors import PAINTS
from roomkin.plugins.furniture.fields import between, chance, fixed, in_turn, of, one_of, whole, zero_or
from roomkin.plugins.furniture.model import Model, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, round_size, uniform


class Thing(Generator):
    """A thing of nothing."""

    wide: float = between(0.2, 0.4)
    rim: float = zero_or(0.01, 0.02)
    legs: int = whole(3, 5)
    lid: bool = chance()
    style: str = one_of("flat", "round")
    shape: str = in_turn("box", "ball")
    wall: float = fixed(0.004)
    colour: Coating = of(PAINTS)
    inside: Coating

    def build(self, size: Size) -> Model:
        return Model([])


def thing(index: int = 0, **given: object) -> Thing:
    return Thing.sample_parameters(np.random.default_rng(5), index, **({"inside": [0.1, 0.2, 0.3]} | given))


def test_fields_are_sampled_within_their_ranges() -> None:
    things = [Thing.sample_parameters(np.random.default_rng(k), k, inside="paint 0 0 0 0") for k in range(40)]
    assert all(0.2 <= one.wide <= 0.4 and round(one.wide, 3) == one.wide for one in things)
    assert {one.rim == 0 for one in things} == {one.lid for one in things} == {True, False}
    assert {one.legs for one in things} == {3, 4} and {one.style for one in things} == {"flat", "round"}
    assert [one.shape for one in things[:3]] == ["box", "ball", "box"]
    assert {one.wall for one in things} == {0.004}


def test_what_is_given_takes_no_random_numbers_and_a_function_is_called_in_its_turn() -> None:
    rng = np.random.default_rng(5)
    expected = uniform(rng, 0.2, 0.4)
    plain, given = thing(), thing(rim=0.015)
    assert plain.wide == given.wide == expected
    assert given.legs == int(rng.integers(3, 5)), "the rim was not sampled"
    seen: list[str] = []
    assert thing(inside=lambda: seen.append("called") or [0.0, 0.0, 0.0]).inside == [0.0, 0.0, 0.0]
    assert seen == ["called"]
    assert list(plain.parameters()) == list(Thing.model_fields), "in the order of the fields"


def test_wrong_parameters_are_refused() -> None:
    for changes in ({"legs": "many"}, {"colour": "wood 2 0 0 0"}, {"wide": float("nan")}, {"lids": 2}):
        with pytest.raises(ValidationError):
            thing().change_parameters(**changes)
    assert round_size(0.12345, 1, 2) == (0.123, 1.0, 2.0)


def test_every_recipe_names_a_generator_and_every_category_is_found() -> None:
    assert list(CATEGORIES) == sorted(CATEGORIES)
    for name, record in CATEGORIES.items():
        assert sample(name, record.templates, 0).generator in GENERATORS
        assert record.count >= record.templates > 0
    assert {name for name in CATEGORIES if has_fronts(name) == (False, True)} == {"chest_of_drawers", "desk"}
    assert has_fronts("oven") == (True, True) and has_fronts("chair") == has_fronts("no such thing") == (False, False)
