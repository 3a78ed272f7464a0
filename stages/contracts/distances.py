"""Contract of `matching distances`: how alike the models of the library look, seen from the cousins of one object."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from stages.contracts.files import Contract

Distance = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Distances(Contract):
    """`distances/<object>.json`: embedding distances between representative snapshots (paper B.4, Table 3).

    `distances[cousin]` holds one number per asset of `assets`. Both are articulated models: what a task can open.
    """

    version: Literal[1] = 1
    scene: str
    object: str
    encoder: str
    assets: list[str]
    distances: dict[str, list[Distance]] = Field(description="from each articulated cousin of the object")

    @model_validator(mode="after")
    def _complete(self) -> "Distances":
        if len(set(self.assets)) < len(self.assets):
            raise ValueError("assets has a name twice")
        for cousin, row in self.distances.items():
            if len(row) != len(self.assets):
                raise ValueError(f"distances.{cousin} has {len(row)} entries for {len(self.assets)} assets")
        return self

    def from_asset(self, cousin: str) -> dict[str, float]:
        """Distance of every asset to one of the object's cousins."""
        return dict(zip(self.assets, self.distances[cousin], strict=True))
