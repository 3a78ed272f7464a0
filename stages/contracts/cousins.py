"""Contract of the `matching` stage: `cousins.json`."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract


class CategoryMatch(Contract):
    """A library category near to the object's label; smaller distance is nearer."""

    category: str
    distance: float


class Candidate(Contract):
    """An asset compared with the object by its representative snapshot (paper A.6)."""

    asset: str
    category: str
    distance: float = Field(description="DINO distance: mean nearest-patch L2 distance without the worst 10 %")
    votes: int | None = Field(None, description="patches won in its voting round; null: not among the top k_model")


class Orientation(Contract):
    """A yaw snapshot compared with the object."""

    yaw: float = Field(description="turn of the asset about z as the camera sees it; 0: front faces the camera")
    distance: float
    votes: int | None = None


class Cousin(Contract):
    """One digital cousin, best first."""

    rank: int
    asset: str
    category: str
    distance: float
    votes: int | None
    orientation: Orientation
    orientations: list[Orientation] = Field(description="the k_ori nearest views, best first")


class ObjectCousins(Contract):
    """What matching found for one object."""

    id: str
    label: str
    status: Literal["ok", "failed"] = "ok"
    reason: str = ""
    note: str = Field("", description="what had to be relaxed to find candidates; empty: nothing")
    categories: list[CategoryMatch] = []
    by_votes: list[Candidate] = Field([], description="top k_model by iterated voting, in order of selection")
    by_distance: list[Candidate] = Field([], description="every candidate, nearest first")
    decided_by: str = Field("", description="what chose the models, e.g. distance or votes")
    orientation_decided_by: str = ""
    cousins: list[Cousin] = []


class Cousins(Contract):
    """`cousins.json`: one entry per object of `objects.json`, in its order."""

    version: Literal[1] = 1
    scene: str
    encoder: str
    objects: list[ObjectCousins]
