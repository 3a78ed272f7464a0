"""Shards of a library: those that it is made in, and parts of whole categories that a picture alone asks for."""

from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path

from pydantic import Field, model_validator

from roomkin.stages.contracts.files import Document
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.types import Text, check_unique

PART = "part_"
DIGITS = 4  # of a category's code: two of 60 categories share one with 1 chance in 40, and then both are drawn


class SceneShards(Document):
    """`shards.json`: the shards that hold all that the objects of a picture may be compared with."""

    shards: list[Text] = Field(min_length=1, description="as in `shard_<name>.json`; a part is named by its categories")

    @model_validator(mode="after")
    def _check_names(self) -> "SceneShards":
        check_unique("shards", self.shards)
        return self


def name_part(categories: Iterable[str]) -> str:
    """The shard of all models of some categories: a name that says which, whatever else the library holds."""
    return PART + "".join(sorted({_code(category) for category in categories}))


def holds(shard: str, model: LibraryEntry) -> bool:
    """Whether a shard holds a model of the library."""
    if not shard.startswith(PART):
        return Path(model.archive).stem == f"shard_{shard}"
    codes = shard.removeprefix(PART)
    return _code(model.category) in {codes[at : at + DIGITS] for at in range(0, len(codes), DIGITS)}


def _code(category: str) -> str:
    return sha256(category.encode()).hexdigest()[:DIGITS]
