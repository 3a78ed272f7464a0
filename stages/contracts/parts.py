"""The kinds of moving parts (of what joint, how far they move, how they open), and how they lie on a front.

A part type is what GAPartNet (Geng et al., CVPR 2023) calls a hinge door, a slider drawer, a slider button. Every part
is closed at the lower limit of its joint and opens towards the upper one. What moves otherwise stays fixed.
"""

import re
from collections.abc import Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
from pydantic import model_validator

from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.types import Fraction

FrontType = Literal["door", "drawer"]  # what an object's counts and its front name (paper A.7): `doors`, `drawers`
PartType = Literal["door", "drawer", "button"]
HingeSide = Literal["left", "right", "bottom", "top", "slide"]
FRONTS: tuple[FrontType, ...] = get_args(FrontType)


class PartKind(NamedTuple):
    """A kind of moving part.

    joint: its type. sides: at which a task opens it; slide: it has no hinge. motion: the least and the most that one
    moves, radians or metres. spring: with which it returns to its lower limit, N/m; 0: it stays where it is left.
    """

    joint: Literal["revolute", "prismatic"]
    sides: tuple[HingeSide, ...]
    motion: tuple[float, float]
    spring: float = 0.0


PARTS: dict[PartType, PartKind] = {
    "door": PartKind("revolute", ("left", "right"), (np.deg2rad(20), np.inf)),
    "drawer": PartKind("prismatic", ("slide",), (0.05, np.inf)),
    # 2 to 4 N where it is pushed all the way, as push buttons of machines have it; chosen
    "button": PartKind("prismatic", ("slide",), (0.001, 0.05), spring=200.0),
}

OPENS = {
    "cabinet", "cabinets", "chest", "closet", "cupboard", "dishwasher", "drawer", "drawers", "dresser", "fridge",
    "microwave", "nightstand", "oven", "refrigerator", "sideboard", "wardrobe",
}  # fmt: skip


def says_opening(label: str) -> bool:
    """Whether what is called so has doors or drawers."""
    return bool(OPENS & set(re.split(r"\W+", label.lower())))


class Panel(Contract):
    """A door or drawer as a box on the front: shares of its width, from the left of whoever faces it, and height."""

    kind: FrontType
    left: Fraction
    right: Fraction
    bottom: Fraction
    top: Fraction

    @model_validator(mode="after")
    def _some_area(self) -> "Panel":
        if self.left >= self.right or self.bottom >= self.top:
            raise ValueError("panels: a box has left < right and bottom < top")
        return self


def count_fronts(panels: Sequence[Panel]) -> dict[str, int]:
    """How many doors and drawers there are."""
    return {f"{kind}s": sum(panel.kind == kind for panel in panels) for kind in FRONTS}


def check_counts(name: str, panels: Sequence[Panel], doors: int | None, drawers: int | None) -> None:
    """Refuse counts of doors and drawers that are not those of the boxes, where there are boxes."""
    for noun, count in count_fronts(panels).items():
        stated = doors if noun == "doors" else drawers
        if panels and stated is not None and stated != count:
            raise ValueError(f"{noun}: {stated} of '{name}', but {count} of its panels are {noun}")
