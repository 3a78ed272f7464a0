"""Matching: what is added to a model's distance, the way back of the patches, and color."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import CategoryMatch
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject
from roomkin.stages.geometry.masks import foreground
from roomkin.stages.matching.candidates import Candidates, is_misplaced, list_addends, size_gap
from roomkin.stages.matching.descriptors import patch_colors
from roomkin.stages.matching.encoders import make_encoder
from roomkin.stages.matching.ranking import make_query
from tests.unit.matching_data import World, view_of_box

OFF = {
    "nearest_views": 1,
    "symmetric": 0,
    "colour": 0,
    "label_weight": 0,
    "size_weight": 0,
    "place_weight": 0,
    "count_weight": 0,
}


def thing(size: tuple[float, float, float], mounting: int = 2, **fields: object) -> SceneObject:
    box = Box(center=(0, 0, size[2] / 2), size=size, yaw=0)
    base = {"id": "x_1", "label": "stool", "mask": 1, "box": box, "mounting": Mounting(type=mounting, walls=[])}
    return SceneObject.model_validate(base | fields)


def model(id: str, **fields: object) -> LibraryEntry:
    base = {"id": id, "category": id, "archive": "x.zip", "doors": 0, "drawers": 0, "checksum": ""}
    return LibraryEntry.model_validate(base | fields)


def test_size_is_compared_whichever_way_it_is_turned() -> None:
    assert size_gap(thing((1.0, 0.5, 0.8)), model("a", size=(0.5, 1.0, 0.8))) == 0
    assert size_gap(thing((1.0, 0.5, 0.8)), model("a", size=(1.0, 0.5, 1.6))) == pytest.approx(np.log(2) / 3)
    assert size_gap(thing((1.0, 0.5, 0.8)), model("a")) == 0


@pytest.mark.parametrize(
    ("mounting", "placement", "wrong"),
    [(1, "wall", 0), (1, "floor", 1), (1, "object", 1), (2, "wall", 1), (3, "wall", 1), (3, "floor", 0),
     (2, "object", 0), (1, None, 0)],
)  # fmt: skip
def test_what_hangs_is_not_what_stands(mounting: int, placement: str | None, wrong: float) -> None:
    assert is_misplaced(thing((0.4, 0.4, 0.4), mounting), model("a", placement=placement)) == wrong


def test_addends_are_weighted_named_and_left_out_at_weight_0() -> None:
    near = [CategoryMatch(category="stool", distance=0.0), CategoryMatch(category="sofa", distance=0.6)]
    candidates = Candidates([model("stool"), model("sofa", doors=3)], near, "")
    item = thing((1, 1, 1), articulated=True, doors=1)
    assert list_addends(item, candidates, MatchingConfig.model_validate(OFF)) == [{}, {}]
    weights = MatchingConfig.model_validate(OFF | {"label_weight": 0.5, "count_weight": 0.1})
    assert list_addends(item, candidates, weights) == [
        {"label": 0.0, "counts": pytest.approx(0.1)},
        {"label": pytest.approx(0.3), "counts": pytest.approx(0.2)},
    ]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("priors"))


def test_the_sum_decides_and_its_parts_are_told(world: World, tmp_path: Path) -> None:
    plain = world.match(tmp_path / "plain.json", **OFF)
    assert all(not one.parts for item in plain.objects for one in item.by_distance)
    named = world.match(tmp_path / "named.json", **OFF | {"label_weight": 9.0})
    for item in named.objects[:4]:
        order = [match.category for match in item.categories]
        ranks = [order.index(one.category) for one in item.by_distance]
        assert ranks == sorted(ranks), item.id  # at such a weight names alone order the categories
        assert all(one.distance == pytest.approx(sum(one.parts.values()), abs=1e-4) for one in item.by_distance)
    models = [[{one.asset for one in item.by_distance} for item in each.objects] for each in (plain, named)]
    assert models[0] == models[1]


def test_the_way_back_is_mixed_in_before_the_nearest_view_is_taken(world: World, tmp_path: Path) -> None:
    there, both, back = (
        {one.asset: one.distance for one in result.objects[0].by_distance}
        for share in (0.0, 0.5, 1.0)
        if (result := world.match(tmp_path / f"{share}.json", **OFF | {"symmetric": share}))
    )
    assert there != back
    for asset, distance in both.items():  # no view is nearer both ways than the nearest views of either
        assert distance >= (there[asset] + back[asset]) / 2 - 1e-4


def test_the_mean_of_the_nearest_views_is_taken(world: World, tmp_path: Path) -> None:
    one, two = (
        {found.asset: found.distance for found in result.objects[0].by_distance}
        for count in (1, 2)
        if (result := world.match(tmp_path / f"{count}.json", **OFF | {"nearest_views": count, "views": 16}))
    )
    views = world.match(tmp_path / "views.json", **OFF | {"k_ori": 16}).objects[0].cousins
    for cousin in views:
        nearest = sorted(view.distance for view in cousin.orientations)
        assert one[cousin.asset] == pytest.approx(nearest[0], abs=1e-4)
        assert two[cousin.asset] == pytest.approx(sum(nearest[:2]) / 2, abs=1e-4)


def test_colors_are_those_of_the_object_alone() -> None:
    view = view_of_box(0.4)
    red = np.where(view.mask[..., None], np.uint8([200, 40, 40]), np.uint8([0, 255, 0]))
    positions = make_encoder(MatchingConfig()).encode([view])[0].positions
    colors = patch_colors(replace(view, rgb=red), positions)
    assert colors.shape == (len(positions), 3)
    assert np.ptp(colors, axis=0).max() < 0.05 and colors[0, 1] > 1.5  # the same red everywhere, no green let in
    blue = np.arange(red.shape[1]) > np.flatnonzero(view.mask.any(axis=0)).mean()  # the right half
    halves = patch_colors(replace(view, rgb=np.where(blue[:, None], np.uint8([40, 40, 200]), red)), positions)
    assert (halves[positions[:, 0] > 0.3, 2] < -1).all() and (halves[positions[:, 0] < -0.3, 2] > 0).all()
    empty = replace(view, mask=np.zeros_like(view.mask))
    assert patch_colors(empty, np.empty((0, 2), np.float32)).shape == (0, 3)


def test_color_counts_only_with_a_weight() -> None:
    view, encoder = view_of_box(0.4), make_encoder(MatchingConfig())
    grey, inverted = (make_query(one, encoder, 1.0) for one in (view, replace(view, rgb=255 - view.rgb)))
    blind = make_query(view, encoder)
    assert blind and grey and inverted and grey.patches.shape[1] == blind.patches.shape[1] + 3
    gaps = np.abs(grey.patches[:, -3:] - inverted.patches[:, -3:]).max(axis=0)
    assert gaps[0] > 0.3 and gaps[1:].max() < 0.05  # greys differ in lightness alone


def test_thin_parts_count_if_asked() -> None:
    mask = np.zeros((96, 96), np.float32)
    mask[:12] = 1  # a table's top ...
    mask[:, 4:8] = 1  # ... and a leg of a third of a patch
    assert foreground(mask, 8, 8).sum() == 8 and foreground(mask, 8, 8, 0.3).sum() == 8 + 7
