"""What the network of shapes learns from, and how: dirt, junk, rooms, determinism."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from benchmarks.name_training import dirt, learn
from benchmarks.name_training.learn import (
    Examples,
    Options,
    draw_examples,
    find_wholes,
    list_names,
    name_kind,
    train,
    vary,
)
from benchmarks.name_training.pictures import pictures_in, sense_depth
from benchmarks.name_training.rooms import furnish, make_pool
from benchmarks.name_training.solids import JUNK, make_junk
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.stages.perception.classification.network import NUMBERS, ShapeNetwork
from roomkin.stages.perception.classification.propose import FAR

SHAPE = (120, 160)
OWNER = np.zeros(SHAPE, np.uint8)
OWNER[40:80, 80:110] = 3
cv2.ellipse(OWNER, (70, 60), (25, 20), 0, 0, 360, 2, -1)
THING = OWNER == 2


def iou(mask: np.ndarray, other: np.ndarray = THING) -> float:
    """Intersection over union."""
    return float((mask & other).sum() / (mask | other).sum())


def spoil(change: str, times: int = 20) -> list[np.ndarray]:
    """The thing with a fault, so many times."""
    return [getattr(dirt, change)(THING, OWNER, np.random.default_rng(seed)) for seed in range(times)]


@pytest.mark.parametrize(
    ("change", "low", "high"),
    [
        ("_resize", 0.7, 0.99),
        ("_shift", 0.6, 1),
        ("_coarsen", 0.8, 1),
        ("_cut_corner", 0.74, 0.98),
        ("_pierce", 0.4, 1),
    ],
)
def test_small_faults_leave_most_of_a_mask(change: str, low: float, high: float) -> None:
    assert all(low <= iou(mask) <= high for mask in spoil(change))
    assert len({mask.tobytes() for mask in spoil(change)}) > 3


def test_a_half_is_inside_and_what_is_added_outside() -> None:
    assert all(0.25 < iou(mask) < 0.7 and not (mask & ~THING).any() for mask in spoil("_halve"))
    assert all(iou(mask) < 1 and not (THING & ~mask).any() for mask in spoil("_add_behind"))
    assert all(np.array_equal(mask, OWNER > 1) for mask in spoil("_add_neighbour"))


def test_a_mask_is_of_the_thing_that_it_covers_alone_or_with_what_it_carries() -> None:
    wholes = {2: [THING, OWNER > 1], 3: [OWNER == 3]}
    assert dirt.share_owner(OWNER > 1, wholes) == (2, 1.0)
    assert dirt.share_owner(OWNER == 3, wholes) == (3, 1.0)
    assert dirt.share_owner(OWNER == 0, wholes)[1] == 0 and dirt.share_owner(THING, {}) == (0, 0.0)


def test_patches_are_of_what_is_no_thing() -> None:
    patches = [dirt.cut_patch(OWNER == 0, np.random.default_rng(seed)) for seed in range(20)]
    assert all(patch.any() and not (patch & (OWNER > 1)).any() for patch in patches)
    assert not dirt.cut_patch(np.zeros(SHAPE, bool), np.random.default_rng(0)).any()


def test_names_are_the_categories_and_none() -> None:
    assert list_names() == [*sorted(CATEGORIES), "other"]
    assert name_kind("sofa") == "sofa" and name_kind("office_chair") == "chair"
    assert {name_kind(kind) for kind in JUNK} == {"chair", "other"}


@pytest.mark.parametrize("kind", JUNK)
def test_junk_is_solid_and_never_the_same(kind: str) -> None:
    one, two = (make_junk(kind, np.random.default_rng(seed)).size for seed in range(2))
    assert (one > 0).all() and not np.array_equal(one, two)


def test_pipes_are_upright_or_level() -> None:
    pipes = [one.mesh.extents for seed in range(20) for one in JUNK["pipes"](np.random.default_rng(seed))]
    assert all(np.diff(np.sort(sides)).min() < 1e-6 for sides in pipes), "a round rod along an axis has two equal sides"


def test_what_a_thing_carries_may_be_shown_with_it() -> None:
    rng = np.random.default_rng(3)
    room = furnish(make_pool(1, 0), rng)
    for picture in pictures_in(room, 6, rng):
        for number, some in find_wholes(picture, room).items():
            carried = {room.things[int(one) - 2].support for one in np.unique(picture.owner[some[-1] & ~some[0]])}
            assert carried <= {number} and not (some[0] & ~some[-1]).any()


def test_a_sensor_errs_by_centimetres_and_loses_edges() -> None:
    rng = np.random.default_rng(1)
    picture = next(pictures_in(furnish(make_pool(1, 0), rng), 9, rng))
    edge = cv2.morphologyEx(picture.depth, cv2.MORPH_GRADIENT, np.ones((3, 3))) > 0.3
    for seed in range(5):
        depth = sense_depth(picture, np.random.default_rng(seed))
        known = depth > 0
        assert 0.3 < known.mean() < 1
        assert np.median(np.abs(depth / picture.depth - 1)[known]) < 0.05
    assert (depth == 0)[edge].mean() > 1.5 * (depth == 0)[~edge].mean()


@pytest.fixture(scope="module")
def few() -> Examples:
    return draw_examples(rooms=2, models=1, seed=3)


def test_examples_are_the_same_by_two_processes(few: Examples) -> None:
    again = draw_examples(rooms=2, models=1, seed=3, processes=2)
    assert all(np.array_equal(one, other) for one, other in zip(few, again, strict=True))
    assert len(few.name) > 20 and few.numbers.shape[1] == NUMBERS
    assert 3 < len(np.unique(few.name)) <= len(list_names()) and few.name.max() == len(list_names()) - 1


def test_the_same_weights_are_learnt_twice_and_written(few: Examples, tmp_path: Path) -> None:
    torch.set_num_threads(1)
    for name in "ab":
        network = train(few, len(list_names()), 0, Options(epochs=1, batch=16), "cpu")
        learn.write_network(tmp_path / name, network, list_names())
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_shapes_vary_as_a_whole() -> None:
    torch.manual_seed(0)
    points, around, numbers = torch.rand(8, 40, 3), torch.full((8, 20, 3), FAR), torch.zeros(8, NUMBERS)
    numbers[:, 4] = 1
    varied, far, told = vary(points, around, numbers)
    assert (far == FAR).all() and not torch.equal(varied, points)
    assert (told[:, 4] + told[:, 5] == 1).all() and 0 < told[:, 4].sum() < 8  # cut at the left: mirrored, at the right
    assert (varied.std(dim=1) / points.std(dim=1)).log().abs().max() < 0.5


def test_points_come_in_no_order_but_for_their_centers() -> None:
    network = ShapeNetwork(5).eval()
    points, around, numbers = torch.rand(1, 256, 3), torch.rand(1, 128, 3), torch.rand(1, NUMBERS)
    shuffled = torch.cat([points[:, :64], points[:, 64:].flip(1)], dim=1)
    with torch.inference_mode():
        assert torch.allclose(network(points, around, numbers), network(shuffled, around.flip(1), numbers), atol=1e-5)
