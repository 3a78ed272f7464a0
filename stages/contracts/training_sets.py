"""Names of training sets and of the roles whose demonstrations make them up: read and written here alone."""

import re
from typing import NamedTuple

RULES = {"cousins": "cousin", "random": "random", "cover": "cover"}  # rules that name a number of assets -> their roles
DRAWN = ("random", "cover")  # rules by chance: their assets are drawn anew for every draw
DRAW = 16  # assets of a draw; the numbers of the next draw's roles go on behind them
RANDOMISED = "_randomised"  # ends a set or role whose every attempt draws extents, friction and mass anew
SET_NAME = rf"(?:twin|all|(?:{'|'.join(RULES)})_[1-9]\d*)(?:{RANDOMISED})?"
ROLE_NAME = rf"(?:twin|all|(?:{'|'.join(RULES.values())})_[1-9]\d*)(?:{RANDOMISED})?"


class SetName(NamedTuple):
    """The parts of a training set's name: `cousins_8_randomised` is eight cousins, randomised."""

    rule: str
    size: int  # stores of demonstrations: one per asset; `all` is one store of many assets
    randomised: bool


def read_set(name: str) -> SetName:
    """The parts of a training set's name, which matches `SET_NAME`."""
    rule, _, size = strip_randomised(name).partition("_")
    return SetName(rule, int(size or 1), is_randomised(name))


def is_set(name: str) -> bool:
    """Whether a name is that of a training set."""
    return re.fullmatch(SET_NAME, name) is not None


def is_randomised(name: str) -> bool:
    """Whether the assets of a set or role are randomised."""
    return name.endswith(RANDOMISED)


def strip_randomised(name: str) -> str:
    """The set or role without its randomisation: that of the same assets."""
    return name.removesuffix(RANDOMISED)


def drawn_role(rule: str, draw: int, place: int) -> str:
    """The role of an asset by its place in a draw, both from 0: random_3 is the third of the first draw."""
    return f"{RULES[rule]}_{draw * DRAW + place + 1}"
