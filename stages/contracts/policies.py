"""Contracts of the policy part: the experiment's assets, the attempt ledger, the rollout rows."""

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts import types
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.library import HandleKind
from roomkin.stages.contracts.parts import HingeSide
from roomkin.stages.contracts.policy_config import DRAWN, drawn_role, strip_randomised
from roomkin.stages.contracts.types import Count, Extent, Finite, Id, NonNegative, Rank, Seed, Size, Text, check_unique


class TaskAsset(Contract):
    """One asset in the policy experiment, and what a policy and a gripper meet there."""

    role: Id = Field(
        description="twin, matched, cousin_1, ... or dissimilar; of the lists: all, random, cover, validation, test"
    )
    asset: Id
    category: Id
    family: Id = Field(description="the model that it is a variation of; its own id if it is none")
    digest: Text = Field(description="checksum of the model (asset.json)")
    joint: Text = Field(description="the joint that the task opens")
    size: Size = Field(description="nominal box at which it is loaded, metres")
    distance: NonNegative = Field(description="DINO distance to the twin between representative snapshots (Table 3)")
    handle: HandleKind
    hinge: HingeSide = Field(description="side on which the front hangs, seen from before it; slide: a drawer")
    panel_height: Finite = Field(description="of the front's center above the asset's bottom at this size, metres")
    panel_size: tuple[Extent, Extent] = Field(description="width and height of the front at this size, metres")
    handle_length: NonNegative = Field(description="longest extent of the handle at this size, metres")
    handle_height: Finite = Field(
        description="of the handle's center on the front: 0 at its lower edge, 1 at its upper"
    )


class TaskAssets(Document):
    """`assets.json`: the assets of a policy experiment about a named object of a named room.

    The twin is the object's true model where that is known, else what matching chose; `matched` is what matching chose
    where that is another one. Every family (template and variations) is on one side alone: what may be trained on, or
    the held-out cousins and the dissimilar asset, or `validation_assets`, or `test_assets`.
    """

    task: Id
    scene: types.SceneName
    object: Id
    encoder: Text
    assets: list[TaskAsset] = Field(min_length=1)
    held_out: list[Rank] = Field([], description="numbers of the cousins that no policy is trained on")
    all_assets: list[TaskAsset] = Field(
        [],
        description="what the training set `all` is collected on, each in the role all, nearest to the twin first: "
        "every usable asset of the object's three nearest categories whose family may be trained on",
    )
    draws: Rank = Field(1, description="so many draws, all as long, stand end to end in each of the next two lists")
    # The training sets `random_n` take the first n of a draw, by chance; `cover_n` likewise: the first n, for any n,
    # are spread over fronts' widths and handles' heights.
    random_assets: list[TaskAsset] = []
    cover_assets: list[TaskAsset] = []
    validation_assets: list[TaskAsset] = Field([], description="every choice is made on these")
    test_assets: list[TaskAsset] = Field([], description="seen once, at the end: no choice is made on them")

    @model_validator(mode="after")
    def _roles(self) -> "TaskAssets":
        roles = [asset.role for asset in self.assets]
        check_unique("assets: roles", roles)
        check_unique("assets", [asset.asset for asset in self.assets])
        cousins = [asset for asset in self.assets if asset.role.startswith("cousin_")]
        numbers = [asset.role.removeprefix("cousin_") for asset in cousins]
        order = ["twin", "matched", *(cousin.role for cousin in cousins), "dissimilar"]
        ordered = all(map(str.isdigit, numbers)) and sorted(map(int, numbers)) == list(map(int, numbers))
        if not ordered or roles[0] != "twin" or roles != [role for role in order if role in roles]:
            known = "twin, matched, cousin_1, cousin_2, ..., dissimilar"
            raise ValueError(f"assets: roles are {', '.join(roles)}, not {known}")
        distances = [cousin.distance for cousin in cousins]
        if distances != sorted(distances):
            raise ValueError("assets: cousins are not in the order of their distance")
        return self

    @model_validator(mode="after")
    def _families_on_one_side(self) -> "TaskAssets":
        hidden = self.hidden_roles
        sides = {
            "training": [
                *(asset for asset in self.assets if asset.role not in hidden), *self.all_assets, *self.random_assets,
                *self.cover_assets,
            ],
            "the held-out and dissimilar assets": [asset for asset in self.assets if asset.role in hidden],
            "validation_assets": self.validation_assets,
            "test_assets": self.test_assets,
        }  # fmt: skip
        found: dict[str, str] = {}
        for side, assets in sides.items():
            for asset in assets:
                if (first := found.setdefault(asset.family, side)) != side:
                    raise ValueError(f"{asset.asset}: its family '{asset.family}' is in {first} and in {side}")
        for name in ("all_assets", "validation_assets", "test_assets"):
            check_unique(name, [asset.asset for asset in getattr(self, name)])
        return self

    @model_validator(mode="after")
    def _draws(self) -> "TaskAssets":
        for rule in DRAWN:
            drawn, length = self.list_drawn(rule), self.length(rule)
            if len(drawn) % self.draws:
                raise ValueError(f"{rule}_assets: {len(drawn)} are not {self.draws} draws of one length")
            for start in range(0, len(drawn), length or 1):
                check_unique(f"{rule}_assets of one draw", [item.asset for item in drawn[start : start + length]])
        return self

    def list_drawn(self, rule: str) -> list[TaskAsset]:
        """The assets of all draws of a rule, `random` or `cover`."""
        return {"random": self.random_assets, "cover": self.cover_assets}[rule]

    def length(self, rule: str) -> int:
        """How many assets a draw of a rule has."""
        return len(self.list_drawn(rule)) // self.draws

    def drawn_roles(self) -> dict[str, TaskAsset]:
        """The assets of all draws by role: random_1, ..., cover_1, ..."""
        drawn = [(rule, number, asset) for rule in DRAWN for number, asset in enumerate(self.list_drawn(rule))]
        return {drawn_role(rule, *divmod(number, self.length(rule))): asset for rule, number, asset in drawn}

    @property
    def hidden_roles(self) -> set[str]:
        """Roles that no policy is trained on: the held-out cousins and the dissimilar asset."""
        return {"dissimilar", *(f"cousin_{number}" for number in self.held_out)}

    def find_asset(self, role: str, where: Path) -> TaskAsset:
        """The asset of a role.

        Raises:
            InputError: there is none in the file `where`; the message names the roles there are.
        """
        by_role = {asset.role: asset for asset in self.assets}
        if role not in by_role:
            raise InputError(where, f"has no role '{role}' (it has {', '.join(by_role)}).", code="E-ROLE-MISSING")
        return by_role[role]

    def assets_of(self, role: str, where: Path) -> list[TaskAsset]:
        """The assets whose demonstrations make up the store of a role, randomised or not: one, or for `all` many.

        Raises:
            InputError: there are none in the file `where`.
        """
        name = strip_randomised(role)
        rule = name.partition("_")[0]
        if rule in DRAWN:
            drawn = self.drawn_roles()
            if name not in drawn:
                what = f"has no '{name}': {self.draws} x {self.length(rule)} assets were drawn for {rule}_n."
                fix = "use a smaller training set, or run `experiment select` again"
                raise InputError(where, what, fix, code="E-ROLE-MISSING")
            return [drawn[name]]
        if name != "all":
            return [self.find_asset(name, where)]
        if not self.all_assets:
            what = "has no assets for the training set `all`."
            raise InputError(where, what, "run `experiment select`", code="E-ROLE-MISSING")
        return self.all_assets

    def split(self, name: Literal["validation", "test"], count: int) -> list[TaskAsset]:
        """The first `count` assets of a split; all if there are fewer."""
        return (self.test_assets if name == "test" else self.validation_assets)[:count]


class Attempt(Contract):
    """A line of `attempts.jsonl`: every attempt, also those that failed (paper A.5: only successes become data)."""

    attempt: Count
    asset: Id
    seed: Seed
    success: bool
    cause: Id = Field(
        description="'success' or where it failed: no_handle, no_plan, approach, converge, grasp_slip, ..."
    )
    recovery: Literal["push", "miss"] | None = Field(None, description="what the hand was made to recover from")
    retries: Count = Field(0, description="how often the skills tried again after a miss")
    steps: Count
    opened: Finite = Field(ge=-10, le=10, description="fraction of the target joint's range at the end")
    episode: Count | None = Field(None, description="index in episodes.h5 if kept")

    @model_validator(mode="after")
    def _cause(self) -> "Attempt":
        if self.success != (self.cause == "success"):
            raise ValueError(f"cause: is '{self.cause}', but success is {str(self.success).lower()}")
        return self


class Rollout(Contract):
    """A row of `rollouts.csv`; `once` names the columns that tell rows apart."""

    once: ClassVar = ("target", "policy", "training_set", "run", "seed", "checkpoint", "test_asset", "episode")

    target: Id = Field(description="name in `experiment.targets`, e.g. door_room_1")
    task: Id = Field(description="what is done there: door, drawer, ...")
    cloud: Literal["target_link", "object"] = Field(description="what the policy's cloud shows of the object")
    policy: Id = Field(description="name in `experiment.policies`; skill: the scripted skill")
    training_set: Id
    run: Id
    seed: Seed
    checkpoint: Text
    test_asset: Id = Field(
        description="role of the test asset; trained: an asset that the policy was trained on; test, validation: an "
        "asset of that split, whose family no policy was trained on"
    )
    asset: Id
    family: Id = Field(description="of the asset")
    handle: HandleKind
    handle_length: NonNegative = Field(description="longest extent of the handle, metres")
    feature_distance: NonNegative = Field(description="from the twin, between features that the encoder finds")
    episode: Count
    initial_state: Seed = Field(description="seed of the initial state; the same for every policy (paired)")
    success: bool = Field(description="the task's own, as section `task` sets it")
    official_success: bool = Field(description="any joint of the object passed 10 % of its range at any time")
    steps: Count
    opened: Finite = Field(ge=-10, le=10)


class RunScore(Contract):
    """How a policy config did in its selection rollouts on the twin, by its best checkpoint."""

    run: Id
    checkpoint: Text
    successes: Count
    episodes: Annotated[Count, Field(ge=1)]


class ChosenRuns(Document):
    """`chosen.json`: the policy configs of one cell that are trained with all seeds (B.4)."""

    target: Id
    policy: Id
    training_set: Id
    runs: list[Id] = Field(min_length=1, description="those chosen, the best one first")
    scores: list[RunScore] = Field(description="all candidates, as they were asked for")

    @model_validator(mode="after")
    def _check_runs(self) -> "ChosenRuns":
        check_unique("runs", self.runs)
        check_unique("scores: runs", [score.run for score in self.scores])
        if strangers := set(self.runs) - {score.run for score in self.scores}:
            raise ValueError(f"runs: {', '.join(sorted(strangers))} was not tried")
        return self


Angle = Annotated[Finite, Field(ge=0, le=3.1416)]
Overlap = Annotated[Finite, Field(ge=0, le=1.000001)]


class SceneScore(Contract):
    """A row of `scores.csv`: one object of one generated scene against the truth (paper B.1)."""

    once: ClassVar = ("scene", "variant", "rank", "object", "protocol", "draw")
    scene: types.SceneName
    variant: Id
    rank: Rank
    scale_m: Extent
    object: Text
    status: Literal["ok", "failed", "missed"]
    true_asset: str
    asset: str | None = Field(description="null if nothing was placed")
    category_correct: bool
    model_correct: bool
    l2_cm: NonNegative | None
    orientation_rad: Angle | None = Field(description="modulo the object's period; null for full symmetry")
    orientation_paper_rad: Angle | None = Field(description="as the paper counts: null for all symmetric objects")
    iou: Overlap | None
    oriented_iou: Overlap | None
    stable: bool | None
    shift_cm: NonNegative | None = Field(None, description="how far it moved in the settling test")
    penetration_cm: NonNegative | None = Field(None, description="deepest of its scene, between any two objects")
    # Mean distance of the two models' surfaces in the box of the true one, over its diagonal.
    chamfer: NonNegative | None = None
    shape_iou: Overlap | None = Field(None, description="of what both models fill of that box")
    panels_correct: bool | None = Field(None, description="as many doors and drawers; null: the true object has none")
    handle_correct: bool | None = Field(None, description="the same kinds of handles, likewise")
    hinge_correct: bool | None = Field(None, description="doors hung on the same sides, likewise")
    protocol: str = Field("", description="change of the room, of experiment.protocols; empty: none, as for Table 2")
    draw: Seed = Field(0, description="the seed of that change")
    model_judge: str = Field("", description="what chose the model; empty: nothing was matched, or unknown")
    orientation_judge: str = Field("", description="what chose the orientation, likewise")
