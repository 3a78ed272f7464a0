"""The order in which the paper lists training sets and test assets, and how a page names them."""

import re
from collections.abc import Mapping
from typing import Any

from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.contracts.policy_config import is_randomised, is_set, read_set, strip_randomised

TASKS = {front: f"{front} opening".capitalize() for front in FRONTS} | {"put_away_bowl": "Putting away bowl"}
SPLITS = ("test", "validation")  # test assets that are sets of unseen assets
SKILL = "skill"  # training set of the scripted skill's rows
NAMES = {"all": "all assets", "trained": "training assets"}
NAMES |= {"test": "unseen assets", "validation": "unseen assets (validation)", "unseen": "held-out roles"}
NAMES |= {SKILL: "scripted skill", "matched": "matched by the run"}
SETS = {"cousins": "cousins", "random": "random assets", "cover": "covering assets"}  # training sets by their rules
CLOUDS = {"target_link": "cloud of the target link", "object": "cloud of the whole object"}
VARIANTS = {  # as the paper has them; what decided in a run stands in cousins.json
    "a": "encoder model, VLM orientation",
    "b": "encoder model, encoder orientation",
    "c": "VLM model, VLM orientation",
    "d": "VLM model, encoder orientation",
}

DEFAULT = "default"  # the variant of config.yaml
NO_IMAGE = "no-image"  # the variant of config/study/table2.yaml that judges are read against


def sort_key(text: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key under which room_2 comes before room_10."""
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", str(text)))


def variant_key(name: str) -> tuple[bool, tuple[tuple[int, int, str], ...]]:
    """Sort key of a variant: that of config.yaml first."""
    return name != DEFAULT, sort_key(name)


def set_key(name: str) -> tuple[int, tuple[tuple[int, int, str], ...]]:
    """Sort key of a training set or test asset: twin, by number, 'all', 'dissimilar', 'trained', sets, the skill."""
    first = {"twin": 0, "all": 2, "dissimilar": 2, "trained": 3, "unseen": 4}
    return ((first | dict.fromkeys(SPLITS, 5) | {SKILL: 6}).get(strip_randomised(name), 1), sort_key(name))


def title(name: str) -> str:
    """A name for people: cousins_4 -> '4 cousins', cousin_2 -> 'cousin 2', cover_8_randomised -> '8 covering assets,
    randomised'."""
    if is_randomised(name):
        return f"{title(strip_randomised(name))}, randomised"
    if is_set(name) and (read := read_set(name)).rule in SETS:
        return f"{read.size} {SETS[read.rule]}"
    return NAMES.get(name, name.replace("_", " "))


def task_title(task: str) -> str:
    """A task for people."""
    return TASKS.get(task, title(task).capitalize())


def target_title(target: str, task: str) -> str:
    """A target for people, by what is done there: 'Door opening', 'Door opening, room 1' (door_room_1)."""
    rest = title(target.removeprefix(f"{task}_"))
    return task_title(task) if target in task else f"{task_title(task)}, {rest}"


def row_title(row: Mapping[str, Any]) -> str:
    """A row of a table for people: its target and its policy, which the paper's and the skill's do not have."""
    target, policy = target_title(row["target"], row["task"]), row["policy"]
    return target if policy in ("", SKILL) else f"{target}, {policy}"
