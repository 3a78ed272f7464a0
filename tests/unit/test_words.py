"""Counts and sizes in words."""

import pytest

from roomkin.stages.contracts.category import CategoryFacts, describe_unusual
from roomkin.stages.contracts.errors import count, describe_size
from roomkin.stages.contracts.objects import Mounting


def test_one_thing_is_not_called_many() -> None:
    assert [count(number, "doubt") for number in (0, 1, 2)] == ["0 doubts", "1 doubt", "2 doubts"]
    assert (count(1, "family", "families"), count(2, "family", "families")) == ("1 family", "2 families")


def test_a_size_is_said_wide_deep_high() -> None:
    assert describe_size((0.1, 1.21, 1.08)) == "121 wide × 10 deep × 108 cm high"


@pytest.mark.parametrize(
    ("size", "usual"),
    [
        ((0.1, 1.21, 1.08), "33 to 75 wide × 4 deep × 33 to 79 cm high"),
        ((1.21, 0.1, 1.08), "4 wide × 33 to 75 deep × 33 to 79 cm high"),
    ],
)
def test_the_usual_size_is_turned_as_the_thing_and_equal_ends_are_said_once(
    size: tuple[float, float, float], usual: str
) -> None:
    known = CategoryFacts(name="picture", sizes=[(0.04, 0.33, 0.33), (0.04, 0.75, 0.79), (0.04, 0.5, 0.5)])
    assert describe_unusual(known, size) == f"is {describe_size(size)}; usual are {usual}"


def test_a_mounting_is_said_in_words() -> None:
    assert Mounting(type=1, walls=["wall_1"]).words == "hangs on a wall (wall_1)"
    assert Mounting(type=2).words == "stands free"
