"""`in_scene.json`: demonstrations inside generated scenes, one per cousin rank."""

from functools import partial
from typing import Literal

from pydantic import Field, model_validator

from roomkin.plugins.films.kinds import Film
from roomkin.stages.contracts.files import Contract, Document, read_json
from roomkin.stages.contracts.objects import check_status
from roomkin.stages.contracts.types import Count, Id, Rank, SceneName, Text, check_unique


class SceneDemonstration(Contract):
    """The outcome in one scene; a film and an episode (rank_<n>.h5) lie beside the file if it is ok."""

    scene: SceneName
    variant: Id
    rank: Rank
    asset: str = Field(description="the cousin that stands there; empty if none does")
    status: Literal["ok", "failed"]
    reason: str = Field("", description="why there is none, in words")
    joint: str = ""
    attempts: Count = Field(0, description="places and initial states that were tried")
    shift: tuple[float, float] = Field((0.0, 0.0), description="of the robot from its usual place, x and y, metres")
    film: Film | None = None

    @model_validator(mode="after")
    def _whole(self) -> "SceneDemonstration":
        check_status(f"rank {self.rank}", self.status, self.reason)
        if (self.film is not None) != (self.status == "ok"):
            raise ValueError(
                f"demonstrations: rank {self.rank} is {self.status}, but has {'no' * (not self.film)} film"
            )
        return self


class SceneDemonstrations(Document):
    """`in_scene.json`."""

    task: Text
    object: Text
    demonstrations: list[SceneDemonstration] = Field(min_length=1)

    @model_validator(mode="after")
    def _check_ranks(self) -> "SceneDemonstrations":
        check_unique("demonstrations: ranks", [str(one.rank) for one in self.demonstrations])
        return self


CHECKS = {"in_scene": partial(read_json, SceneDemonstrations)}
