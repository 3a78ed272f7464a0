"""Textures: the same everywhere, small, seamless, and on a model at their real scale, along its grain."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.finishes import MATERIALS, Finish, change_material, finish_of, shade
from roomkin.plugins.furniture.folder import build, generate, robot_of
from roomkin.plugins.furniture.textures import SIDE, pattern_of, texture_of
from roomkin.stages.articulated.model import Texture
from roomkin.stages.articulated.resizing import resize_asset
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.library import Recipe

PATTERNS = [
    (material, pattern) for material, kind in MATERIALS.items() if kind.repeat for pattern in range(kind.patterns)
]


@pytest.mark.parametrize(("material", "pattern"), PATTERNS)
def test_patterns_are_seamless_small_and_keep_the_color(material: str, pattern: int) -> None:
    texture = texture_of(Finish(material, (0.4, 0.3, 0.2), pattern))
    shades = pattern_of(material, pattern)
    if shades is None:
        assert texture is None and material == "glaze"
        return
    assert texture is not None and len(texture.image) < 16_000
    assert shades.mean() == pytest.approx(1.0, abs=0.03)
    for field in (shades, shades.T):
        steps = np.abs(np.diff(field, axis=0)).mean(axis=1)
        assert np.abs(field[-1] - field[0]).mean() <= 1.1 * steps.max(), "there is a seam"


def test_a_texture_is_the_same_in_every_process() -> None:
    first = pattern_of("wood", 1)
    as_another_had_it = [1.24186901, 1.2471847, 1.25236521]
    assert first is not None and first[0, :3] == pytest.approx(as_another_had_it, abs=1e-6)
    finish = Finish("wood", (0.55, 0.36, 0.2), 1)
    again = texture_of.__wrapped__(finish)
    assert again == texture_of(finish)
    other = texture_of(finish.change_color((0.5, 0.36, 0.2)))
    assert isinstance(again, Texture) and isinstance(other, Texture) and again.name != other.name


def test_finishes_are_read_as_they_are_written() -> None:
    assert finish_of("wood 0.5 0.25 0.125 3") == Finish("wood", (0.5, 0.25, 0.125), 3)
    assert finish_of([0.1, 0.2, 0.3]) == Finish("paint", (0.1, 0.2, 0.3))
    assert str(finish_of("wood 0.5 0.25 0.125 3")) == "wood 0.5 0.25 0.125 3"
    assert finish_of(shade("wood 0.5 0.25 0.125 3", 2.0)).color == (1.0, 0.5, 0.25)
    assert finish_of(change_material("card", "glaze 0.5 0.25 0.125 3")).material == "card"
    for wrong in ("velvet 0.1 0.1 0.1 0", "wood 0.1 0.1 0.1 9", "wood 0.1 0.1 2 0", "wood 0.1 0.1 0", [0.1, 0.2]):
        with pytest.raises(ValueError, match=r"."):
            finish_of(wrong)


def test_the_grain_runs_along_at_its_real_scale_at_any_size(tmp_path: Path) -> None:
    parameters = sample("table", 0, 0).parameters | {
        "top": "rectangle", "legs": "square", "leg_colour": [0.5, 0.5, 0.5], "top_colour": "wood 0.55 0.36 0.2 0",
    }  # fmt: skip
    recipe = Recipe(generator="table", parameters=parameters)
    asset = build(recipe, (0.8, 1.6, 0.7), tmp_path / "table", "table", "table")
    for folder, length in (
        (tmp_path / "table", 1.6),
        (resize_asset(tmp_path / "table", (0.8, 2.4, 0.7), tmp_path), 2.4),
    ):
        assert sorted(path.suffix for path in (folder / "meshes").glob("wood*")) == [".jpg", ".mtl"]
        visuals = read_urdf(folder / asset.urdf, folder).links["base"].visuals
        top = next(visual.mesh for visual in visuals if visual.color is None)
        assert top.visual.material.image.size == (SIDE, SIDE)
        upper = top.faces[top.face_normals[:, 2] > 0.9].ravel()
        along, across = np.ptp(top.visual.uv[upper], axis=0)
        assert along == pytest.approx(length / MATERIALS["wood"].repeat[0], abs=1e-3)
        assert across == pytest.approx(0.8 / MATERIALS["wood"].repeat[1], abs=1e-3)


def test_slim_parts_show_their_color_and_neighbours_other_pieces_of_the_picture() -> None:
    recipe = sample("bottom_cabinet", 3, 0)
    finish = "wood 0.55 0.36 0.2 0"
    finish_parameters = {"front_colour": finish, "handle_colour": finish, "panel": "flat", "handle": "bar"}
    painted = recipe.model_copy(update={"parameters": recipe.parameters | finish_parameters})
    links = robot_of(generate(painted), "x").links
    visuals = [visual for name, link in links.items() if name != "base" for visual in link.visuals]
    wooden = [visual for visual in visuals if visual.color[:3] == (0.55, 0.36, 0.2)]
    slim = [bool(np.sort(visual.mesh.extents)[1] < 0.03) for visual in wooden]
    assert [visual.texture is None for visual in wooden] == slim and set(slim) == {True, False}
    starts = [visual.start for visual in links["base"].visuals if visual.texture is not None]
    assert len(set(starts)) == len(starts) > 3
