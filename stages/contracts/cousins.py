"""Contract of the `matching` stage: `cousins.json`."""

from itertools import pairwise
from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.doubt import Doubt, Provenance
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.objects import check_status
from roomkin.stages.contracts.types import Angle, Count, Finite, Id, NonNegative, Rank, SceneName, Text, check_unique

NO_MODEL = "no language model"  # in the name of a judge that stands in for one


class CategoryMatch(Contract):
    """A library category near to the object's label; smaller distance is nearer."""

    category: Id
    distance: Finite


class Judged(Contract):
    """The scores of a candidate or a yaw by the judge that decided, if it gives any."""

    score: Finite | None = Field(None, description="more is better; null: the judge gives none, or did not look at it")
    terms: dict[str, Finite] = Field({}, description="what the score is made of, by name, before weights")

    @property
    def fits(self) -> bool:
        """False: nothing fits, says the judge `geometry`, and its score is what is known besides (docs/matching.md)."""
        return self.score is None or self.score != -self.terms.get("priors", float("inf"))


class Candidate(Judged):
    """An asset compared with the object (paper A.6)."""

    asset: Id
    category: Id
    distance: NonNegative = Field(
        description="mean nearest-patch L2 distance without the worst 10 %, and what else counts: `parts`"
    )
    parts: dict[str, NonNegative] = Field(
        {}, description="what distance is the sum of, by name, if more than patches count: patches, label, size, ..."
    )
    votes: Count | None = Field(None, description="patches won in its voting round; null: not among the top k_model")


class Orientation(Judged):
    """A way to stand: that of a snapshot compared with the object, or one that a judge found."""

    yaw: Angle = Field(description="turn of the asset about z as the camera sees it; 0: front faces the camera")
    distance: NonNegative | None = Field(None, description="of the snapshot at this yaw; null: there is none")
    votes: Count | None = None


class Cousin(Judged):
    """One digital cousin, best first."""

    rank: Rank
    asset: Id
    category: Id
    distance: NonNegative
    parts: dict[str, NonNegative] = {}
    votes: Count | None
    orientation: Orientation
    orientations: list[Orientation] = Field(description="the k_ori nearest views, best first")
    differs: str = Field("", description="doors and drawers as stated and as it has them; empty: it has them so")


class ObjectCousins(Contract):
    """The cousins of one object."""

    id: Id
    label: Text
    status: Literal["ok", "failed"] = "ok"
    reason: str = ""
    doubts: list[Doubt] = Field([], description="what may be wrong and a person can mend: a name that is not known")
    note: str = Field("", description="what was relaxed, which judge abstained, what shares its order; empty: nothing")
    categories: list[CategoryMatch] = []
    by_votes: list[Candidate] = Field([], description="top k_model by iterated voting, in order of selection")
    by_distance: list[Candidate] = Field([], description="every candidate, nearest first")
    decided_by: str = Field("", description="what chose the models, e.g. distance or votes")
    orientation_decided_by: str = ""
    cousins: list[Cousin] = Field([], description="ranks 1 to k without gaps, each asset once")

    @model_validator(mode="after")
    def _check_ranks(self) -> "ObjectCousins":
        check_status(self.id, self.status, self.reason)
        if (self.status == "ok") != bool(self.cousins):
            raise ValueError(f"cousins: '{self.id}' is {self.status}, but has {len(self.cousins)} cousins")
        ranks = [cousin.rank for cousin in self.cousins]
        if ranks != list(range(1, len(ranks) + 1)):
            raise ValueError(f"cousins: ranks of '{self.id}' are {ranks[:12]}, not 1 to {len(ranks)} in order")
        check_unique(f"cousins: assets of '{self.id}'", [cousin.asset for cousin in self.cousins])
        check_unique(f"by_votes: assets of '{self.id}'", [candidate.asset for candidate in self.by_votes])
        check_unique(f"by_distance: assets of '{self.id}'", [candidate.asset for candidate in self.by_distance])
        distances = [candidate.distance for candidate in self.by_distance]
        if distances != sorted(distances):
            raise ValueError(f"by_distance: '{self.id}' has a nearer candidate behind a farther one")
        if self.decided_by == "distance" and any(one.distance > next.distance for one, next in pairwise(self.cousins)):
            raise ValueError(f"cousins: '{self.id}' is decided by distance, but its distances fall with rank")
        return self


class Cousins(Document):
    """`cousins.json`: one entry per object of `objects.json`, in its order."""

    scene: SceneName
    encoder: Text
    objects: list[ObjectCousins]
    made: Provenance | None = None

    @model_validator(mode="after")
    def _check_ids(self) -> "Cousins":
        check_unique("objects: ids", [item.id for item in self.objects])
        return self


class Distances(Document):
    """`distances/<object>.json`: embedding distances between representative snapshots (paper B.4, Table 3).

    `distances[cousin]` holds one number per asset of `assets`. Both are articulated models: what a task can open.
    """

    scene: SceneName
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
