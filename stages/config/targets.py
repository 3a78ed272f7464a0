"""Entries of the policy experiment: targets, which are opened, and policies, which open them."""

import re
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, Field

from roomkin.stages.contracts.errors import suggest_nearest
from roomkin.stages.contracts.policy_config import RANDOMISED, RULES, SET_NAME, is_set
from roomkin.stages.contracts.section import Section, Seed, unfit


def _check_set(name: str) -> str:
    """Refuse what is no training set; the nearest that is one is named, with the number that was given."""
    if not is_set(name):
        size = re.search(r"[1-9]\d*", name)
        known = ["twin", "all", *(f"{rule}_{size[0] if size else 4}" for rule in RULES)]
        mend = suggest_nearest(name, [set_name + tail for tail in ("", RANDOMISED) for set_name in known])
        raise unfit(f"'{name}' is no training set", mend)
    return name


TrainingSet = Annotated[str, AfterValidator(_check_set), Field(json_schema_extra={"pattern": f"^{SET_NAME}$"})]


class RoomTarget(Section):
    """A task with the object of a room that it is about."""

    task: str | None = Field(None, description="door, drawer, ... or a task of yours; null: as the target is named")
    room: str = Field("room_3", description="room of the object, one of `rooms`")
    object: str = Field("hanging_cabinet_1", description="its id in that room's objects.json")
    options: dict[str, Any] = Field({}, description="keys of section `task` that differ here, e.g. {max_steps: 200}")
    assets: str | None = Field(
        None,
        description="a committed file of the target's assets (docs/policies.md), checked against the library; null: "
        "chosen anew",
    )
    episodes: int | None = Field(None, ge=1, description="null: `experiment.episodes`")


class PolicyChoice(Section):
    """What opens targets: a way to train. Its kind follows from its configs."""

    configs: list[str] | None = Field(
        None,
        min_length=1,
        description="names of `training.configs`, one kind of policy; null: the one that is called as the "
        "policy; of more than `experiment.best_configs` selection rollouts choose the best",
    )
    targets: list[str] | None = Field(None, min_length=1, description="targets or pools that it opens; null: all")
    training_sets: list[TrainingSet] | None = Field(None, description="null: `experiment.training_sets`")
    seeds: list[Seed] | None = Field(None, min_length=1, description="null: `experiment.seeds`")


class PolicyPlan(NamedTuple):
    """A policy with nothing left open."""

    targets: list[str]
    configs: list[str]
    training_sets: list[str]
    seeds: list[int]


class Cell(NamedTuple):
    """Policies that differ in run and seed alone."""

    target: str
    policy: str
    training_set: str
