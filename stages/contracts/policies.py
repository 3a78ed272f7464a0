"""Contracts of the policy part: the experiment's assets, the attempt ledger, the rollout rows."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract
from stages.contracts.library import Vector


class TaskAsset(Contract):
    """One asset in the policy experiment."""

    role: str = Field(description="twin, cousin_1, cousin_2, ... or dissimilar")
    asset: str
    category: str
    joint: str = Field(description="the joint that the task opens")
    size: Vector = Field(description="nominal box at which it is loaded, metres")
    distance: float = Field(description="DINO distance to the twin between representative snapshots (Table 3)")


class TaskAssets(Contract):
    """`assets.json`: the twin is the best match of a named object of a named room, the cousins are the next ones."""

    version: Literal[1] = 1
    task: str
    scene: str
    object: str
    encoder: str
    assets: list[TaskAsset]


class Attempt(Contract):
    """A line of `attempts.jsonl`: every attempt, also those that failed (paper A.5: only successes become data)."""

    attempt: int
    seed: int
    success: bool
    cause: str = Field(
        description="'success' or where it failed: no_handle, no_plan, approach, converge, grasp_slip, ..."
    )
    steps: int
    opened: float = Field(description="fraction of the target joint's range at the end")
    episode: int | None = Field(None, description="index in episodes.h5 if kept")


class Rollout(Contract):
    """A row of `rollouts.csv`."""

    task: str
    training_set: str
    run: str
    seed: int
    checkpoint: str
    test_asset: str = Field(description="role of the test asset")
    asset: str
    dino_distance: float
    episode: int
    initial_state: int = Field(description="seed of the initial state; the same for every policy (paired)")
    success: bool
    steps: int
    opened: float


class SceneScore(Contract):
    """A row of `scores.csv`: one object of one generated scene against the truth (paper B.1)."""

    scene: str
    variant: str
    rank: int
    scale_m: float
    object: str
    status: Literal["ok", "failed", "missed"]
    true_asset: str
    asset: str | None = Field(description="null if nothing was placed")
    category_correct: bool
    model_correct: bool
    l2_cm: float | None
    orientation_rad: float | None = Field(description="null for symmetric objects")
    iou: float | None
    oriented_iou: float | None
    stable: bool | None
