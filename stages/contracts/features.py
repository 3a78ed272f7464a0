"""Contract of a feature store: the JSON index beside the rows."""

from pydantic import Field, model_validator

from stages.contracts.files import Document
from stages.contracts.types import Angle, Count, Id, Text, check_unique


class FeatureIndex(Document):
    """`shard_I.json`: which rows belong to which view of which asset.

    Beside it `shard_I.npy`: the rows, (N, D) float16, or (N, K) int8, codes of which a row is
    mean + (codes * steps) @ components; and `shard_I.npz`: mean (D,), components (K, D) and steps (K,) if there are
    codes, and wholes (views, W), every view as one vector.
    """

    encoder: Text
    settings: str = Field(description="digest of the encoder's settings; another one makes another store")
    upright: bool = Field(description="whether normals are upright (the snapshot camera's elevation was known)")
    assets: list[Id]
    yaws: list[Angle] = Field(min_length=1, description="radians; views in this order, then the representative")
    starts: list[Count] = Field(
        description="first row of view v of asset a at a * (len(yaws) + 1) + v; the last is the count"
    )

    @model_validator(mode="after")
    def _complete(self) -> "FeatureIndex":
        check_unique("assets", self.assets)
        if len(self.starts) != len(self.assets) * (len(self.yaws) + 1) + 1:
            raise ValueError("starts: needs one entry per view and one at the end")
        if self.starts[0] != 0 or self.starts != sorted(self.starts):
            raise ValueError("starts: must begin with 0 and never fall")
        return self
