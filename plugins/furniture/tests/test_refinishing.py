"""Another finish changes what is seen of a model and nothing else."""

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import CATEGORIES, sample
from roomkin.plugins.furniture.finishes import finish_of
from roomkin.plugins.furniture.folder import generate
from roomkin.plugins.furniture.makers.furniture import is_finish, paint, refinish
from roomkin.plugins.furniture.model import bounds, parts_of


@pytest.mark.parametrize("category", sorted(CATEGORIES))
def test_another_finish_keeps_the_geometry(category: str) -> None:
    recipe = sample(category, 0, 0)
    other = refinish(recipe, np.random.default_rng(1))
    assert other == refinish(recipe, np.random.default_rng(1))
    changed = {key for key, value in recipe.parameters.items() if other.parameters[key] != value}
    assert changed == {key for key in recipe.parameters if is_finish(key)}
    model, painted = generate(recipe), generate(other)
    assert (bounds(model) == bounds(painted)).all()
    assert model.symmetry == painted.symmetry
    parts = list(zip(parts_of(model), parts_of(painted), strict=True))
    assert all((a.mesh.vertices == b.mesh.vertices).all() and a.density == b.density for a, b in parts)
    assert any(a.color != b.color for a, b in parts)


def test_a_plant_keeps_its_colors() -> None:
    recipe = sample("plant_pot", 0, 0)
    assert paint(recipe, (0.2, 0.2, 0.2)) == recipe


@pytest.mark.parametrize("category", sorted(CATEGORIES.keys() - {"plant_pot"}))
def test_a_model_is_painted_where_most_of_it_is_seen(category: str) -> None:
    recipe, red = sample(category, 0, 0), (0.6, 0.1, 0.05)
    painted = paint(recipe, red)
    changed = {key for key, value in recipe.parameters.items() if painted.parameters[key] != value}
    assert changed and all(is_finish(key) for key in changed)
    before, after = (list(parts_of(generate(each))) for each in (recipe, painted))
    assert any(np.allclose(part.color, red, atol=2e-3) for part in after)
    assert {part.finish.material for part in after} <= {part.finish.material for part in before}
    pieces = [[piece.vertices for part in parts for piece in part.pieces] for parts in (before, after)]
    assert all((one == other).all() for one, other in zip(*pieces, strict=True))
    masses = [sum(part.density * part.mesh.volume for part in parts) for parts in (before, after)]
    assert abs(masses[0] - masses[1]) < 1e-3  # a lining in the color of its pan is left out
    assert paint(recipe, red) == painted


def test_what_was_of_one_color_stays_so_and_shades_stay_shades() -> None:
    recipe = sample("bowl", 0, 0)
    recipe.parameters.update(colour="wood 0.2 0.4 0.6 1", inside="wood 0.2 0.4 0.6 1")
    other = refinish(recipe, np.random.default_rng(0)).parameters
    assert other["colour"] == other["inside"] != recipe.parameters["colour"]
    recipe.parameters.update(inside="wood 0.1 0.2 0.3 1")
    other = refinish(recipe, np.random.default_rng(0)).parameters
    color, inside = finish_of(str(other["colour"])), finish_of(str(other["inside"]))
    assert color.material == inside.material
    assert np.allclose(np.array(inside.color) * 2, color.color, atol=3e-3)
