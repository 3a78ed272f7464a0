"""The order in which the paper lists tasks, training sets and test assets, and how a page names them."""

import re

TASKS = {"door": "Door opening", "drawer": "Drawer opening", "bowl": "Putting away bowl"}
TASKS |= {"door_object": "Door, whole object"}  # of config/study
NAMES = {"all": "all assets", "trained": "training assets"}
CLOUDS = {"target_link": "cloud of the target link", "object": "cloud of the whole object"}
VARIANTS = {  # as the paper has them; what decided in a run stands in cousins.json
    "a": "encoder model, VLM orientation",
    "b": "encoder model, encoder orientation",
    "c": "VLM model, VLM orientation",
    "d": "VLM model, encoder orientation",
}

NO_IMAGE = "no-image"  # the variant of config/study/table2.yaml that judges are read against


def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key under which room_2 comes before room_10."""
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", str(text)))


def task_key(task: str) -> tuple[int, str]:
    """Sort key of a task: the paper's order, others after it."""
    known = list(TASKS)
    return (known.index(task) if task in known else len(known), task)


def set_key(name: str) -> tuple[int, tuple[tuple[int, int, str], ...]]:
    """Sort key of a training set or test asset: twin, by number, 'all', 'dissimilar', 'trained', 'unseen'."""
    first = {"twin": 0, "all": 2, "dissimilar": 2, "trained": 3, "unseen": 4}.get(name, 1)
    return (first, natural(name))


def title(name: str) -> str:
    """A name for people: cousins_4 -> '4 cousins', cousin_2 -> 'cousin 2'."""
    if name in TASKS:
        return TASKS[name]
    if match := re.fullmatch(r"cousins_(\d+)", name):
        return f"{match[1]} cousins"
    if name in NAMES:
        return NAMES[name]
    return name.replace("_", " ")
