"""The layout of doors and drawers on the front of a thing."""

from collections.abc import Sequence

from pydantic import model_validator

from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.parts import FRONTS, FrontType
from roomkin.stages.contracts.types import Fraction


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
