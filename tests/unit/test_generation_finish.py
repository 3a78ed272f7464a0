"""Cousins in the colors of the picture: what color an object has, and that nothing but looks changes."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.contracts import GeneratedScene, read_json
from roomkin.stages.contracts.generated import GAMMA
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.generation.generate import run
from roomkin.stages.generation.placed import find_main_color, paint
from roomkin.stages.generation.scene_file import read_items
from tests.refusals import refused
from tests.unit.generation_scenes import thing
from tests.unit.test_generation_run import scene  # noqa: F401  (a fixture)

RED, BLUE = (180, 40, 30), (30, 60, 170)


def test_the_main_color_is_that_of_most_pixels_in_neither_shadow_nor_glare() -> None:
    rng = np.random.default_rng(0)
    shown = np.array([RED] * 600 + [(60, 13, 10)] * 100 + [(250, 250, 250)] * 100 + [BLUE] * 200)
    rgb = np.clip(shown + rng.normal(0, 5, shown.shape), 0, 255).astype(np.float32) / 255
    found = find_main_color(cv2.cvtColor(rgb[None], cv2.COLOR_RGB2LAB)[0])
    assert found == pytest.approx((np.array(RED) / 255) ** GAMMA, abs=0.03)


def test_what_lies_half_in_shadow_has_the_color_that_is_lit() -> None:
    shown = np.array([RED] * 400 + [(60, 13, 10)] * 550 + [(250, 250, 250)] * 50)
    rgb = np.clip(shown + np.random.default_rng(0).normal(0, 5, shown.shape), 0, 255).astype(np.float32) / 255
    found = find_main_color(cv2.cvtColor(rgb[None], cv2.COLOR_RGB2LAB)[0])
    assert found == pytest.approx((np.array(RED) / 255) ** GAMMA, abs=0.03)


def test_a_model_that_is_no_recipe_s_stays_as_it_is_and_says_so() -> None:
    item = thing("mug_1", (0, 0, 0), (0.1, 0.1, 0.1))
    assert paint(item, None) is item
    kept = paint(item, (0.5, 0.1, 0.1))
    assert kept.finish == {} and kept.steps[-1].startswith("in its own colors")


def test_cousins_wear_the_colors_of_the_picture_and_stand_as_before(
    scene: dict[str, Path],  # noqa: F811
    tmp_path: Path,
) -> None:
    masks = read_masks(scene["objects"].with_name("masks.png"))
    picture = np.full((*masks.shape, 3), 128, np.uint8)
    picture[masks == 1] = RED
    cv2.imwrite(str(tmp_path / "rgb.png"), picture[..., ::-1])
    given = {key: scene[key] for key in ("cousins", "objects", "library")} | {"variant": "default"}
    options = {finish: json.dumps({"ranks": 1, "finish": finish}) for finish in ("library", "picture")}
    run(**given, options=options["library"], out=tmp_path / "plain")
    run(**given, options=options["picture"], image=(tmp_path / "rgb.png",), out=tmp_path / "painted")

    plain, painted = (read_json(GeneratedScene, tmp_path / name / "scene_1.json") for name in ("plain", "painted"))
    assert "finish" not in (tmp_path / "plain/scene_1.json").read_text()
    worn = {other.id: other.finish for other in painted.objects if other.finish}
    assert list(worn) == ["cabinet_1"]  # the mug has too few pixels
    assert [other.model_copy(update={"finish": {}}) for other in painted.objects] == plain.objects
    rgb = [[float(channel) for channel in str(finish).split()[1:4]] for finish in worn["cabinet_1"].values()]
    assert any(np.allclose(each, (np.array(RED) / 255) ** GAMMA, atol=0.01) for each in rgb)

    folders = AssetFolders(scene["library"])
    both = [read_items(each, folders, tmp_path / "sized", tmp_path)[0] for each in (plain, painted)]
    before, after = ([*read_model(item.folder).links.values()] for item in both)
    for one, other in zip(before, after, strict=True):
        assert all((a.vertices == b.vertices).all() for a, b in zip(one.collisions, other.collisions, strict=True))
    finishes = [
        [visual.texture or visual.color for link in links for visual in link.visuals] for links in (before, after)
    ]
    assert finishes[0] != finishes[1]

    with refused("E-OPTION-MISSING"):
        run(**given, options=options["picture"], out=tmp_path / "none")


@pytest.mark.parametrize("finish", [None, "library"])
@pytest.mark.parametrize("shown", [True, False])
def test_unless_told_otherwise_cousins_wear_the_picture_that_is_given(
    scene: dict[str, Path],  # noqa: F811
    tmp_path: Path,
    finish: str | None,
    shown: bool,
) -> None:
    masks = read_masks(scene["objects"].with_name("masks.png"))
    cv2.imwrite(str(tmp_path / "rgb.png"), np.full((*masks.shape, 3), RED[::-1], np.uint8))
    given = {key: scene[key] for key in ("cousins", "objects", "library")} | {"variant": "default", "out": tmp_path}
    options = json.dumps({"ranks": 1, "finish": finish})
    run(**given, options=options, image=(tmp_path / "rgb.png",) if shown else ())
    worn = any(each.finish for each in read_json(GeneratedScene, tmp_path / "scene_1.json").objects)
    assert worn == (shown and finish is None)
