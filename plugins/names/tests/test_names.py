"""Names that are proposed: what is observed of a mask, how it is weighed, how the table is learnt."""

import hashlib
from collections import Counter

import numpy as np
import pytest

from plugins.names.examples import Example, draw_examples
from plugins.names.learn import choose_weights, learn_table
from plugins.names.observed import Observed, observe
from plugins.names.propose import FEET, TABLE, Table, propose_names, read_table
from stages.contracts.categories import known_categories, sizes_of
from stages.contracts.category import log_extents
from stages.geometry.boxes import UprightBox
from tests.unit.synthetic_room import INTRINSICS, WORLD_FROM_CAMERA, trace

DIGEST = "784d542feba15360e6e80b277b6cdcc0b3831545f72ef582b0226aa4b2a9ab08"


def test_the_table_is_the_shipped_one_and_knows_every_category() -> None:
    assert hashlib.sha256(TABLE.read_bytes()).hexdigest() == DIGEST
    table = read_table()
    assert list(table.names) == sorted(known_categories())
    assert np.exp(table.feet).sum(axis=1) == pytest.approx(np.ones(len(table.names)), abs=1e-5)
    assert (table.weights > 0).all() and (table.weights < 1).all(), "less than all of what each says: they overlap"


def usual(category: str, foot: float) -> Observed:
    """A thing of a category's usual size, of looks that say nothing: the mean over all categories."""
    table = read_table()
    looks = np.linalg.lstsq(table.looks, table.offset.mean() - table.offset, rcond=None)[0]
    return Observed(looks, np.median(log_extents(sizes_of(category)), axis=0), foot)


@pytest.mark.parametrize(
    ("category", "foot"),
    [("wall_cabinet", 1.4), ("picture", 1.5), ("mug", 0.0), ("bottle", 0.0), ("stool", 0.0)],
)
def test_size_and_height_alone_say_much(category: str, foot: float) -> None:
    found = propose_names(usual(category, foot))
    assert category.replace("_", " ") in [one.name for one in found[:5]]
    assert sum(one.probability for one in found) == pytest.approx(1)
    assert [one.probability for one in found] == sorted((one.probability for one in found), reverse=True)


def test_what_hangs_is_no_chest_on_the_floor() -> None:
    high, low = (propose_names(usual("chest_of_drawers", foot)) for foot in (1.4, 0.0))
    share = [{one.name: one.probability for one in found}["chest of drawers"] for found in (high, low)]
    assert share[1] > 2 * share[0]


def test_names_are_proposed_among_those_of_a_library() -> None:
    found = propose_names(usual("mug", 0.7), among=["sofa", "mug", "pouf"])
    assert {one.name for one in found} == {"mug", "sofa"} and found[0].name == "mug"


def test_size_and_foot_are_measured_above_the_floor() -> None:
    box = UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 0.3], 0.3)
    depth, masks = trace([box])
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    seen = observe(rgb, depth.astype(float), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)
    assert seen.size is not None and seen.foot == pytest.approx(0.35, abs=0.03)
    assert np.exp(seen.size) == pytest.approx([0.4, 0.8, 0.3], rel=0.2)
    assert seen.looks.shape == (112,) and 0 < np.linalg.norm(seen.looks) <= 1
    blind = observe(rgb, np.zeros(depth.shape), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)
    assert blind.size is None and blind.foot is None
    assert np.array_equal(blind.looks, seen.looks)
    assert len(propose_names(blind)) == len(known_categories())


def examples(count: int, seed: int) -> list[Example]:
    """Three categories: one by looks, one by size, one by foot; looks are noise but for the first."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(count):
        name = "abc"[number % 3]
        looks = rng.normal(0, 0.05, 112) + (name == "a") * np.eye(112)[0]
        size = rng.normal(-1 + (name == "b"), 0.1, 3)
        found.append(Example(name, Observed(looks, size, 1.0 if name == "c" else 0.0)))
    return found


def test_a_table_is_learnt_and_weighed() -> None:
    table = learn_table(examples(300, 0), np.ones(3))
    others = examples(90, 1)
    weights = choose_weights(table, others)
    learnt = Table(**{**vars(table), "weights": weights})
    right = [propose_names(one.observed, learnt)[0].name == one.name for one in others]
    assert np.mean(right) > 0.95
    assert np.searchsorted(FEET, 1.0) == table.feet[2].argmax()


def test_weights_are_calibrated() -> None:
    """Things of no category: nothing that is said of them counts."""
    table = learn_table(examples(300, 0), np.ones(3))
    rng = np.random.default_rng(2)
    shuffled = [Example(str(rng.choice(list("abc"))), one.observed) for one in examples(300, 3)]
    assert choose_weights(table, shuffled).max() < 0.1


def test_examples_are_things_of_our_categories() -> None:
    found = draw_examples(each=1, models=1, seed=3, rooms=1)
    counts = Counter(one.name for one in found)
    assert 3 < len(counts) <= len(known_categories()) and counts.keys() <= known_categories().keys()
    assert set(counts.values()) == {1}
