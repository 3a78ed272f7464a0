"""Names that are proposed: the shape of a mask, how what is said of it is weighed, and what the network says."""

import hashlib

import numpy as np
import pytest
import torch

from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import back_project, transform_points
from roomkin.stages.perception.classification import efficientnet
from roomkin.stages.perception.classification import propose as observed
from roomkin.stages.perception.classification.names import (
    NO_KIND,
    NO_NAME,
    LikelyName,
    find_reason,
    place_sure,
    refuse_size,
)
from roomkin.stages.perception.classification.propose import (
    AROUND,
    FAR,
    NETWORK,
    POINTS,
    Exponents,
    Names,
    Observed,
    combine,
    gather,
    measure_shape,
    observe,
    propose_names,
    read_classes,
    read_coco,
    read_network,
    share_classes,
    share_coco,
)
from tests.unit.synthetic_room import INTRINSICS, WORLD_FROM_CAMERA, trace

DIGEST = "9aa7bf303fe273a907fda6fca7d1544816268eeebaf4703ccd0c2ba3b133b29e"
NAMES = ["armchair", "book", "chair", "mug", "sofa", "stool", "table", "other"]


def seen(*boxes: UprightBox) -> Observed:
    """The last of some boxes in a room, grey all over."""
    depth, masks = trace(list(boxes))
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    return observe(rgb, depth.astype(float), masks == masks.max(), INTRINSICS, WORLD_FROM_CAMERA)


def test_the_network_is_the_shipped_one_and_knows_every_category() -> None:
    assert hashlib.sha256(NETWORK.read_bytes()).hexdigest() == DIGEST
    assert NETWORK.stat().st_size < 700_000
    network, names = read_network()
    assert sum(one.numel() for one in network.parameters()) < 300_000
    assert names == [*sorted(CATEGORIES), "other"]
    assert set(known_categories()) <= set(names)


def test_the_classifier_sees_nothing_beside_a_mask(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[torch.Tensor] = []
    monkeypatch.setattr(observed, "classifier", lambda: lambda picture: (shown.append(picture), torch.zeros(1, 9))[1])
    mask = np.zeros((60, 80), bool)
    mask[10:50, 20:30] = mask[40:50, 20:70] = True  # an L
    red = np.where(mask[..., None], np.uint8([200, 30, 30]), np.uint8([0, 255, 0]))
    for rgb in (red, np.where(mask[..., None], red, np.uint8([0, 0, 255])), 255 - red):
        observed.classify(rgb, mask)
    assert torch.equal(shown[0], shown[1]) and not torch.equal(shown[0], shown[2])


def test_classes_and_words_are_those_of_categories() -> None:
    assert set(read_classes()) <= set(known_categories())
    assert all(0 <= one < 1000 for ours in read_classes().values() for one in ours)
    assert {name for parts in read_coco().values() for name in parts} <= set(known_categories())
    assert all(sum(parts.values()) == pytest.approx(1) for parts in read_coco().values())


def test_names_are_sorted_and_sum_to_one_with_none_of_them() -> None:
    found = propose_names(seen(UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 1.0], 0.3)), {"chair": 0.3})
    sure = [one.probability for one in found.proposals]
    assert sum(sure) + found.other == pytest.approx(1)
    assert sure == sorted(sure, reverse=True)
    assert len({one.name for one in found.proposals}) == len(read_network()[1]) - 1


def test_the_same_is_said_twice() -> None:
    box = UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 1.0], 0.3)
    assert propose_names(seen(box)) == propose_names(seen(box))


def furnished(*pieces: tuple[list[float], list[float]]) -> Names:
    """What is proposed for boxes in a room that are one thing: centers and sizes, metres."""
    depth, masks = trace([UprightBox(center, size, 0.0) for center, size in pieces])
    rgb = np.full((*depth.shape, 3), 120, np.uint8)
    mask = masks > masks.max() - len(pieces)
    return propose_names(Observed(observe(rgb, depth.astype(float), mask, INTRINSICS, WORLD_FROM_CAMERA).shape))


def test_a_chair_of_boxes_is_a_chair_and_shapeless_bodies_are_nothing() -> None:
    seat, back = ([2.4, 0.3, 0.45], [0.45, 0.45, 0.05]), ([2.6, 0.3, 0.7], [0.04, 0.45, 0.5])
    legs = [([x, y, 0.22], [0.04, 0.04, 0.42]) for x in (2.2, 2.6) for y in (0.1, 0.5)]
    chair = furnished(seat, back, *legs)
    bars = [([2.4, 0.0, 0.3], [0.1, 1.4, 0.2]), ([2.5, 0.5, 0.9], [0.2, 0.1, 1.3]), ([2.6, 0.0, 1.5], [0.6, 0.2, 0.1])]
    junk = furnished(*bars)
    first, second, *_ = (one.name for one in chair.proposals)
    assert "chair" in (first, second) and first in ("chair", "stool", "armchair")
    assert junk.other > 1.5 * chair.other


def test_a_shape_is_turned_away_from_the_camera_and_stands_on_the_floor() -> None:
    box = UprightBox([2.4, 1.2, 0.5], [0.4, 0.6, 1.0], np.arctan2(1.2, 2.4))
    shape = seen(box).shape
    assert shape is not None and shape.points.shape == (POINTS, 3) and shape.around.shape == (AROUND, 3)
    assert np.ptp(shape.points, axis=0) == pytest.approx([0.4, 0.6, 1.0], abs=0.08)  # its front and its top are seen
    assert shape.points[:, 2].min() == pytest.approx(0, abs=0.05)
    assert shape.numbers[0] == pytest.approx(np.hypot(2.4, 1.2) - 0.1, abs=0.1)  # of what is seen: its front half
    assert not shape.numbers[2:6].any() and shape.numbers[6:].tolist() == pytest.approx([1, 1], abs=0.35)


def test_a_mask_at_the_border_is_cut_there_and_one_without_depth_has_no_shape() -> None:
    depth, _ = trace([])
    room, known = transform_points(WORLD_FROM_CAMERA, back_project(depth, INTRINSICS)), depth > 0
    mask = np.zeros(depth.shape, bool)
    mask[-30:, :40] = True
    shape = measure_shape(room, known, mask, 1.6)
    assert shape is not None and shape.numbers[2:6].tolist() == [0, 1, 1, 0]
    lonely = measure_shape(room, mask & known, mask, 1.6)
    assert lonely is not None and (lonely.around == FAR).all()
    assert measure_shape(room, ~known, mask, 1.6) is None


def test_without_depth_and_words_every_name_is_as_likely() -> None:
    assert gather(Observed(), None, NAMES) == pytest.approx(np.full((4, len(NAMES)), 1 / len(NAMES)))
    assert combine(gather(Observed(), {}, NAMES), Exponents(other=0)) == pytest.approx(1 / len(NAMES))
    one_against_two = np.array([[0.98, 0.02, 0.0], [0.0, 0.5, 0.5], [0.98, 0.02, 0.0], [0.98, 0.02, 0.0]])
    assert combine(one_against_two, Exponents(other=0)).argmax() == 0, "who says 0 does not overrule the others"


def test_a_class_of_imagenet_is_a_vote_for_its_categories() -> None:
    scores = np.zeros(1000)
    scores[504] = 8  # coffee mug
    scores[0] = 20  # a tench is no thing of ours, and does not count
    share = share_classes(scores, NAMES)
    assert NAMES[int(share.argmax())] == "mug" and share.sum() == pytest.approx(1, abs=0.5)


def test_a_word_of_coco_is_a_vote_and_its_doubt_is_of_all() -> None:
    share = dict(zip(NAMES, share_coco({"couch": 0.8}, NAMES), strict=True))
    assert sum(share.values()) == pytest.approx(1)
    assert share["sofa"] > share["armchair"] > share["mug"] == pytest.approx(0.2 / len(NAMES))
    both = share_coco({"couch": 0.9, "chair": 0.9}, NAMES)
    assert both.sum() == pytest.approx(1) and share_coco({"zebra": 0.9}, NAMES) == pytest.approx(1 / len(NAMES))
    said, silent = (propose_names(Observed(), word) for word in ({"couch": 0.8}, None))
    assert said.proposals[0].name == "sofa" and said.proposals[0].probability > 5 * silent.proposals[0].probability


def test_without_the_classifier_names_are_proposed_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    depth, masks = trace([UprightBox([2.6, 0.0, 0.5], [0.4, 0.8, 1.0], 0.3)])
    rgb, mask = np.full((*depth.shape, 3), 120, np.uint8), masks == masks.max()

    def weigh_with(scores: torch.Tensor | None) -> Names:
        monkeypatch.setattr(observed, "classifier", lambda: scores if scores is None else lambda picture: scores[None])
        return propose_names(observe(rgb, depth.astype(float), mask, INTRINSICS, WORLD_FROM_CAMERA))

    without, told = weigh_with(None), weigh_with(10.0 * torch.eye(1000)[504])
    assert without.proposals[0].probability > 0 and without.proposals != told.proposals


def test_the_classifier_needs_its_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent() -> None:
        raise InputError("weights", "are not installed.", "install them", code="E-WEIGHTS-MISSING")

    monkeypatch.setattr(efficientnet, "published_file", absent)
    observed.classifier.cache_clear()
    assert observed.classifier() is None
    observed.classifier.cache_clear()


def test_what_carries_is_placed_if_it_may_carry_at_all() -> None:
    table = Names([LikelyName("table", 0.15), LikelyName("desk", 0.1), LikelyName("bed", 0.05)], 0.7)
    cutlery = Names([LikelyName("cutlery", 0.2), LikelyName("table", 0.1)], 0.7)
    named = {1: table, 2: cutlery}
    assert place_sure(named, 0.5, [1, 2]) == {1: "table"} and place_sure(named, 0.5) == {}


def test_names_of_one_kin_are_sure_together() -> None:
    seats = Names([LikelyName("sofa", 0.3), LikelyName("bench", 0.3), LikelyName("mug", 0.1)], 0.3)
    assert find_reason(seats, 0.5) == "" and find_reason(seats, 0.7) == NO_NAME
    assert find_reason(Names([LikelyName("sofa", 0.3), LikelyName("mug", 0.3)], 0.4), 0.2) == NO_KIND
    assert find_reason(Names([LikelyName("a drill", 0.6), LikelyName("sofa", 0.4)], 0.0), 0.5) == "", (
        "one of no category"
    )


def test_the_noise_of_its_depth_makes_nothing_flat_too_large() -> None:
    picture = Names([LikelyName("picture", 0.9), LikelyName("box", 0.1)], 0.0)
    assert refuse_size(picture, np.array([0.3, 0.5, 0.6])).proposals[0].name == "picture"
    assert refuse_size(Names([LikelyName("picture", 0.5)], 0.5), np.array([0.1, 2.4, 0.6])).other > 0.9
