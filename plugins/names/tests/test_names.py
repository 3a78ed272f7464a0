"""Names that are proposed: what is observed of a mask, how it is weighed, how the table is learnt."""

import hashlib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from benchmarks.names import choose_looks, share_names
from plugins.inputs.rgbd.frame import Frame, Labelled
from plugins.inputs.rgbd.naming import name_things
from plugins.names import observed
from plugins.names.examples import Example, draw_examples
from plugins.names.learn import learn_table
from plugins.names.observed import WITHOUT, Observed, observe
from plugins.names.propose import FEET, OUT, TABLE, WEIGHTS, place_at_wall, propose_names, read_classes, read_table, say
from stages.contracts import InputError
from stages.contracts.categories import known_categories, sizes_of
from stages.contracts.category import log_extents
from stages.geometry.boxes import UprightBox
from tests.unit.synthetic_room import BACK_WALL, INTRINSICS, WORLD_FROM_CAMERA, trace

DIGEST = "66b8089517d8349c1ed1e5a5f9eba65715f7ab305e26d98fecaa9d0ab829bb11"


def test_the_table_is_the_shipped_one_and_knows_every_category() -> None:
    assert hashlib.sha256(TABLE.read_bytes()).hexdigest() == DIGEST
    table = read_table()
    assert list(table.names) == sorted(known_categories())
    assert np.exp(table.feet).sum(axis=1) == pytest.approx(np.ones(len(table.names)), abs=1e-5)
    assert np.exp(table.out).sum(axis=1) == pytest.approx(np.ones(len(table.names)), abs=1e-5)


def test_every_category_but_a_few_has_classes_of_imagenet() -> None:
    classes = read_classes()
    assert set(classes) == set(known_categories())
    assert all(0 <= one < 1000 for ours in classes.values() for one in ours)
    assert {name for name, ours in classes.items() if not ours} == {"can", "mirror", "ottoman", "picture", "suitcase"}


def usual(category: str, foot: float) -> Observed:
    """A thing of a category's usual size, of looks that say nothing: the mean over all categories."""
    table = read_table()
    looks = np.linalg.lstsq(table.looks, table.offset.mean() - table.offset, rcond=None)[0]
    return Observed(looks, None, np.median(log_extents(sizes_of(category)), axis=0), foot)


def share_of(category: str, observed: Observed) -> float:
    """How sure a category is."""
    return {one.name: one.probability for one in propose_names(observed)}[category.replace("_", " ")]


@pytest.mark.parametrize(
    ("category", "foot"),
    [("wall_cabinet", 1.4), ("picture", 1.5), ("mug", 0.0), ("bottle", 0.0), ("stool", 0.0)],
)
def test_size_and_height_alone_say_much(category: str, foot: float) -> None:
    found = propose_names(usual(category, foot))
    assert category.replace("_", " ") in [one.name for one in found[:9]]  # of 64
    assert sum(one.probability for one in found) == pytest.approx(1)
    assert [one.probability for one in found] == sorted((one.probability for one in found), reverse=True)


def test_what_hangs_is_no_chest_on_the_floor() -> None:
    chest, hung = "chest_of_drawers", "wall_cabinet"
    high, low = (share_of(chest, seen) / share_of(hung, seen) for seen in (usual(chest, 1.4), usual(chest, 0.0)))
    assert low > 1.4 * high


def test_how_far_a_thing_stands_out_of_its_wall_tells_pictures_from_cabinets() -> None:
    hung = usual("wall_cabinet", 1.4)
    flat, deep = (replace(hung, out=np.array([0.0, out])) for out in (0.04, 0.36))
    assert share_of("picture", flat) > 2 * share_of("picture", deep)
    assert share_of("wall_cabinet", deep) > 1.5 * share_of("wall_cabinet", flat)


def test_places_at_a_wall() -> None:
    outs = [None, [-3.0, 0.05], [0.0, 0.05], [0.0, 0.2], [0.0, 0.4], [0.3, 1.0]]
    assert [place_at_wall(None if out is None else np.array(out)) for out in outs] == list(range(len(OUT) + 3))


def test_a_class_of_imagenet_is_a_vote_for_its_categories() -> None:
    plain = usual("mug", 0.7)
    scores = np.zeros(1000)
    scores[504] = 8  # coffee mug
    scores[0] = 20  # a tench is no thing of ours, and does not count
    assert share_of("mug", replace(plain, classes=scores)) > 2 * share_of("mug", plain)
    said = say(replace(plain, classes=scores), read_table())[1]
    assert read_table().names[said.argmax()] == "mug"


def test_without_the_classifier_names_are_proposed_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    depth, masks = trace([UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 1.0], 0.3)])
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    value = int(masks.max())
    frame = Frame(rgb, depth, INTRINSICS, Labelled(masks.astype(np.uint16), {value: "object"}))

    def weigh_with(scores: torch.Tensor | None) -> Frame:
        monkeypatch.setattr(observed, "classifier", lambda: scores if scores is None else lambda picture: scores[None])
        return name_things(frame)

    without, seen = weigh_with(None), weigh_with(10.0 * torch.eye(1000)[504])
    assert without.notes == [WITHOUT] and not seen.notes
    assert without.masks is not None and seen.masks is not None
    sure = [{one.name: one.probability for one in found.masks.proposals[value]} for found in (without, seen)]
    assert len(sure[0]) == 3 and sure[0] != sure[1]


def test_the_classifier_needs_its_weights(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def absent() -> Path:
        raise InputError("weights", "are not installed.", "install them", code="E-WEIGHTS-MISSING")

    monkeypatch.setattr(observed, "published_file", absent)
    observed.classifier.cache_clear()
    assert observed.classifier() is None
    observed.classifier.cache_clear()


def test_names_are_proposed_among_those_of_a_library() -> None:
    found = propose_names(usual("mug", 0.7), among=["sofa", "mug", "pouf"])
    assert {one.name for one in found} == {"mug", "sofa"} and found[0].name == "mug"


def test_size_foot_and_wall_are_measured() -> None:
    box = UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 0.3], 0.3)
    depth, masks = trace([box])
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    seen = observe(rgb, depth.astype(float), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)
    assert seen.size is not None and seen.foot == pytest.approx(0.35, abs=0.03)
    assert np.exp(seen.size) == pytest.approx([0.4, 0.8, 0.3], rel=0.2)
    assert seen.looks.shape == (112,) and 0 < np.linalg.norm(seen.looks) <= 1
    blind = observe(rgb, np.zeros(depth.shape), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)
    assert blind.size is None and blind.foot is None and blind.out is None
    assert np.array_equal(blind.looks, seen.looks)
    assert len(propose_names(blind)) == len(known_categories())


def test_what_hangs_stands_out_of_its_wall() -> None:
    deep = 0.3
    hung = UprightBox([BACK_WALL - deep / 2, 0.0, 1.2], [deep, 0.6, 0.5], 0.0)
    depth, masks = trace([hung])
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    seen = observe(rgb, depth.astype(float), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)
    assert seen.out is not None and seen.out[1] == pytest.approx(deep, abs=0.02)
    lonely = observe(
        rgb, np.where(masks == masks.max(), depth, 0.0), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA
    )
    assert lonely.out is None


def examples(count: int, seed: int) -> list[Example]:
    """Three categories: one by looks, one by size, one by foot; looks are noise but for the first."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(count):
        name = "abc"[number % 3]
        looks = rng.normal(0, 0.05, 112) + (name == "a") * np.eye(112)[0]
        size = rng.normal(-1 + (name == "b"), 0.1, 3)
        found.append(Example(name, Observed(looks, None, size, 1.0 if name == "c" else 0.0)))
    return found


def said_of(things: list[Example]) -> tuple[np.ndarray, np.ndarray]:
    """What a table that others taught says of things, and which names are right."""
    table = learn_table(examples(300, 0))
    return np.array([say(one.observed, table) for one in things]), np.array([table.names == one.name for one in things])


def test_a_table_is_learnt_and_names_what_it_did_not_see() -> None:
    said, right = said_of(examples(90, 1))
    assert (share_names(said, WEIGHTS[0]).argmax(axis=1) == right.argmax(axis=1)).mean() > 0.95
    assert np.searchsorted(FEET, 1.0) == learn_table(examples(300, 0)).feet[2].argmax()


def test_looks_weigh_as_much_as_they_are_right() -> None:
    said, right = said_of(examples(90, 1))
    assert choose_looks(said, right) > 0.15
    said[:, 0] = np.roll(said[:, 0], 1, axis=1)  # now they are wrong
    assert choose_looks(said, right) < 0.1


def test_examples_are_things_of_our_categories() -> None:
    found = draw_examples(each=1, models=1, seed=3, rooms=1)
    counts = Counter(one.name for one in found)
    assert 3 < len(counts) <= len(known_categories()) and counts.keys() <= known_categories().keys()
    assert set(counts.values()) == {1}
