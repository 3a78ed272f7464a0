"""Contract of `films.json`: the episodes that were filmed, as animated WebP files beside it."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract


class Film(Contract):
    """One filmed episode."""

    role: str = Field(description="role of the asset: twin, cousin_1, ...")
    asset: str
    seed: int = Field(description="of the initial state")
    success: bool
    steps: int
    opened: float = Field(description="fraction of the joint's range at the end")
    file: str = Field(description="name of the animated WebP beside films.json")


class Films(Contract):
    """`films.json`."""

    version: Literal[1] = 1
    films: list[Film]
