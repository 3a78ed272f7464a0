"""Contract of `matching distances`: how alike the models of the library look, seen from the cousins of one object."""

from pydantic import Field, model_validator

from stages.contracts.files import Document
from stages.contracts.types import Id, NonNegative, Text, check_unique


class Distances(Document):
    """`distances/<object>.json`: embedding distances between representative snapshots (paper B.4, Table 3).

    `distances[cousin]` holds one number per asset of `assets`. Both are articulated models: what a task can open.
    """

    scene: Id
    object: Id
    encoder: Text
    assets: list[Id]
    distances: dict[Id, list[NonNegative]] = Field(description="from each articulated cousin of the object")

    @model_validator(mode="after")
    def _complete(self) -> "Distances":
        check_unique("assets", self.assets)
        for cousin, row in self.distances.items():
            if len(row) != len(self.assets):
                raise ValueError(f"distances.{cousin}: has {len(row)} entries for {len(self.assets)} assets")
        return self

    def from_asset(self, cousin: str) -> dict[str, float]:
        """Distance of every asset to one of the object's cousins."""
        return dict(zip(self.assets, self.distances[cousin], strict=True))
