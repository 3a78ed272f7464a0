"""Cousins that open otherwise than was stated say so, and a scene of them doubts it first."""

from roomkin.stages.contracts.cousins import Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.library import Library
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.deciding import describe_counts, note_differences
from roomkin.stages.matching.match import describe_doubts
from tests.unit.test_matching_labels import entry

VIEW = Orientation(yaw=0.0, distance=0.0)
SAID = SceneObject(id="fridge_1", label="fridge", mask=1, articulated=True, doors=2, drawers=1)


def cousins(*assets: str) -> ObjectCousins:
    ranked = [
        Cousin(rank=rank, asset=asset, category=asset.rsplit("_", 1)[0], distance=1.0, votes=None, orientation=VIEW,
               orientations=[VIEW]) for rank, asset in enumerate(assets, 1)
    ]  # fmt: skip
    return ObjectCousins(id="fridge_1", label="fridge", decided_by="geometry", cousins=ranked)


def library(*counts: tuple[int, int], other: int = 0) -> Library:
    assets = [entry(f"fridge_{number}", *each) for number, each in enumerate(counts)]
    return Library(assets=[*assets, *([entry("oven_0", 2, 1)] if other else [])])


def test_counts_in_words() -> None:
    assert [describe_counts(2, 1), describe_counts(0, 4), describe_counts(1, 0)] == [
        "2 doors and 1 drawer",
        "no door and 4 drawers",
        "1 door and no drawer",
    ]


def test_every_cousin_with_other_counts_says_so() -> None:
    found = note_differences(cousins("fridge_0", "fridge_1"), SAID, library((2, 0), (2, 2), other=1))
    assert [one.differs for one in found.cousins] == [
        "was said to have 2 doors and 1 drawer, the model has 2 doors and no drawer; no fridge of the library has that",
        "was said to have 2 doors and 1 drawer, the model has 2 doors and 2 drawers; no fridge of the library has that",
    ]
    (line,) = describe_doubts([found])
    assert line.startswith("fridge_1 was said to have") and line.endswith("or bring one (docs/your-models.md)")


def test_it_says_which_model_has_them() -> None:
    first, second = note_differences(cousins("fridge_0", "fridge_1"), SAID, library((2, 0), (2, 1))).cousins
    assert first.differs.endswith("; cousin 2 has that") and second.differs == ""
    (only,) = note_differences(cousins("fridge_0"), SAID, library((2, 0), (2, 1))).cousins
    assert only.differs.endswith("; another fridge of the library has that")


def test_what_was_not_counted_does_not_differ() -> None:
    plain = SceneObject(id="fridge_1", label="fridge", mask=1, articulated=True)
    assert note_differences(cousins("fridge_0"), plain, library((2, 0))).cousins[0].differs == ""
    assert list(describe_doubts([note_differences(cousins("fridge_0"), plain, library((2, 0)))])) == []
