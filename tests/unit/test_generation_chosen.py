"""Which cousin stands in the scene of a rank: what a thing was called and how it was counted come before its size."""

from dataclasses import replace

import numpy as np

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.cousins import Cousin, Orientation
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.generation.inputs import MatchedObject
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.placing import Places, choose, choose_by_rank, find_synonyms
from tests.unit.generation_scenes import thing


def _standing(*cousins: tuple[str, int, float], rank: int = 1, limit: float | None = 2.0) -> Placed:
    """What stands of cousins at their places, best first: category, drawers, and how often each is as large."""
    placed = []
    for number, (category, drawers, times) in enumerate(cousins, 1):
        item = thing("chest_1", (0, 0, 0), (1, 1, 1))
        asset = item.asset.model_copy(update={"category": category, "drawers": drawers})
        box = replace(item.box, size=(times, times, times))
        placed.append(replace(item, asset=asset, box=box, cousin=number))
    return choose_by_rank(placed, rank, limit, {"chest", "commode"})


def test_a_cousin_that_would_be_squeezed_is_passed_over_at_every_rank() -> None:
    fits, small = ("chest", 3, 1.5), ("chest", 3, 4.0)
    first, second = _standing(small, fits), _standing(small, fits, rank=2)
    assert (first.cousin, first.doubts) == (2, ())
    assert first.steps == ("passed over, for so many times they would be stretched: cousins 1 (4.0)",)
    assert second.cousin == 2 and second.steps[0].startswith("only 1 of its cousins have its size")
    assert _standing(small, fits, limit=None).cousin == 1


def test_where_no_cousin_fits_the_one_that_is_stretched_least_stands() -> None:
    least = _standing(("chest", 3, 5.0), ("chest", 3, 4.0))
    assert least.cousin == 2 and [one.cause for one in least.doubts] == ["size"]
    assert least.doubts[0].what == "no cousin has its size: this one is stretched 4.0 times"
    assert least.steps == ("passed over, for so many times they would be stretched: cousins 1 (5.0)",)


def test_other_categories_and_other_counts_do_not_stand_for_what_does_not_fit() -> None:
    small, other_kind, other_count = ("chest", 3, 4.0), ("table", 0, 1.0), ("chest", 2, 1.0)
    assert _standing(small, other_kind, other_count).cousin == 1
    assert _standing(small, other_kind, other_count, rank=2).cousin == 3  # of its kind, before it stands there again
    assert _standing(("chest", 3, 1.0), other_count, ("chest", 3, 1.2), rank=2).cousin == 3
    assert _standing(small, ("commode", 3, 1.0)).cousin == 2  # its label means both


def test_a_label_means_every_category_that_is_as_near() -> None:
    near = {"table_lamp": 0.14, "floor_lamp": 0.15, "candlestick": 0.75}
    assert find_synonyms(near, "floor_lamp") == find_synonyms(near, "table_lamp") == {"table_lamp", "floor_lamp"}
    assert find_synonyms(near, "candlestick") == set(near)
    assert find_synonyms(near, "box") == {"box"}  # chosen by hand


class AsTheyAre(Places):
    """Every cousin is like one item."""

    def __init__(self, item: Placed) -> None:
        self.item, self.options = item, GenerationConfig(max_stretch=2.0)

    def find(self, one: MatchedObject, cousin: Cousin) -> Placed:
        return replace(self.item, asset=self.item.asset.model_copy(update={"id": cousin.asset, "category": "chest"}))


def test_after_a_persons_choice_the_next_scenes_have_the_cousins_in_order() -> None:
    item = replace(thing("chest_1", (0, 0, 0), (1, 1, 1)), doubts=(DoubtKind.OPENINGS.of(what="one door"),))
    about = {"category": "chest", "votes": None, "orientation": Orientation(yaw=0.0), "orientations": []}
    cousins = [Cousin(rank=n, asset=f"chest_{n}", distance=n, **about) for n in (1, 2, 3)]
    seen = SceneObject(id="chest_1", label="chest", mask=1, status="failed", reason="-")

    def chosen(said: Correction, rank: int) -> Placed:
        one = MatchedObject(seen, cousins, {}, np.empty((0, 3), np.float32), None, said)
        return choose(one, rank, {}, AsTheyAre(item))

    def standing(said: Correction, rank: int) -> str:
        return chosen(said, rank).asset.id

    said, nothing = Correction(mask=1, model="chest_9"), Correction(mask=1)
    assert chosen(nothing, 1).doubts == item.doubts and chosen(said, 1).doubts == (), "a person knows better"
    assert [standing(said, rank) for rank in (1, 2, 3)] == ["chest_9", "chest_1", "chest_2"]
    assert [standing(nothing, rank) for rank in (1, 2, 3)] == ["chest_1", "chest_2", "chest_3"]
    assert standing(Correction(mask=1, model="chest_1"), 2) == "chest_2"
