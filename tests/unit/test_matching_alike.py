"""Alike things get one order of models, by what is seen of all of them."""

import pytest

from roomkin.stages.contracts.cousins import Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject
from roomkin.stages.matching.deciding import agree_on_order, group_alike


def _thing(name: str, height: float = 0.9, **fields: object) -> SceneObject:
    box = Box(center=(0, 0, height / 2), size=(0.4, 0.5, height), yaw=0)
    base = {"id": name, "label": "chair", "mask": 1, "box": box, "mounting": Mounting(type=2)}
    return SceneObject.model_validate(base | fields)


def _entry(name: str, **scores: float | None) -> ObjectCousins:
    view = Orientation(yaw=0.0)
    cousins = [
        Cousin(rank=rank, asset=asset, category="chair", distance=1, votes=None, score=score, orientation=view,
               orientations=[view])
        for rank, (asset, score) in enumerate(scores.items(), 1)
    ]  # fmt: skip
    return ObjectCousins(id=name, label="chair", cousins=cousins)


def _order(entry: ObjectCousins) -> list[str]:
    assert [one.rank for one in entry.cousins] == list(range(1, len(entry.cousins) + 1))
    return [one.asset for one in entry.cousins]


def test_what_is_seen_of_all_decides_for_each() -> None:
    entries = [_entry("chair_1", a=0.9, b=0.8), _entry("chair_2", b=0.9, a=0.3), _entry("chair_3", a=0.7, b=0.6)]
    first, second, third = agree_on_order(entries, [_thing("chair_1"), _thing("chair_2", 0.92), _thing("chair_3", 1.2)])
    assert _order(first) == _order(second) == ["b", "a"]
    assert first.note == "models in one order with chair_2, which is alike"
    assert third == entries[2]


def test_a_model_that_one_of_them_does_not_have_counts_there_as_its_last() -> None:
    items = [_thing("chair_1"), _thing("chair_2")]
    first, second = agree_on_order([_entry("chair_1", a=0.9, b=0.8), _entry("chair_2", b=0.5, c=0.4)], items)
    assert _order(first) == ["a", "b"]  # 0.65 each: ties stay
    assert _order(second) == ["b", "c"]
    first, _ = agree_on_order([_entry("chair_1", a=0.9, b=0.8), _entry("chair_2", b=0.7, c=0.1)], items)
    assert _order(first) == ["b", "a"]


def test_without_scores_everything_stays() -> None:
    entries = [_entry("chair_1", a=None, b=None), _entry("chair_2", b=0.9, a=0.3)]
    assert agree_on_order(entries, [_thing("chair_1"), _thing("chair_2")]) == entries


@pytest.mark.parametrize(
    "other",
    [{"label": "stool"}, {"doors": 1, "articulated": True}, {"mounting": Mounting(type=1)}, {"box": None},
     {"height": 0.99}],
)  # fmt: skip
def test_what_is_called_counted_mounted_or_measured_otherwise_is_not_alike(other: dict) -> None:
    assert group_alike([_thing("a_1"), _thing("a_2")]) == [[0, 1]]
    assert group_alike([_thing("a_1"), _thing("a_2", **other)]) == []
