"""The order in which the paper lists tasks, training sets and test assets, and how a page names them."""

import re

from stages.contracts.training_sets import DRAW, DRAWN, SetName, is_randomised, is_set, plain, read_set

TASKS = {"door": "Door opening", "drawer": "Drawer opening", "bowl": "Putting away bowl"}
TASKS |= {"door_object": "Door, whole object", "drawer_object": "Drawer, whole object"}  # of config/study
ENDINGS = ["", "_handle", "_diffusion", "_blind"]  # rows of one task by their names, in this order
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

NO_IMAGE = "no-image"  # the variant of config/study/table2.yaml that judges are read against


def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key under which room_2 comes before room_10."""
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", str(text)))


def ending(task: str) -> str:
    """The ending of a row's name by which it is sorted beside the row that it shares assets with; else nothing."""
    return next((name for name in ENDINGS if name and task.endswith(name)), "")


def task_key(task: str) -> tuple[int, str, int, str]:
    """Sort key of a task: the paper's order, others after it; rows of one task and their sets beside each other."""
    row, _, run = task.partition("/")
    base, known = row.removesuffix(ending(row)), list(TASKS)
    return (known.index(base) if base in known else len(known), base, ENDINGS.index(ending(row)), run)


def set_key(name: str) -> tuple[int, tuple[tuple[int, int, str], ...]]:
    """Sort key of a training set or test asset: twin, by number, 'all', 'dissimilar', 'trained', sets, the skill."""
    first = {"twin": 0, "all": 2, "dissimilar": 2, "trained": 3, "unseen": 4}
    return ((first | dict.fromkeys(SPLITS, 5) | {SKILL: 6}).get(plain(name), 1), natural(name))


def title_of(number: int, name: str) -> str:
    """A number of assets or roles with their title: '24 unseen assets', '1 unseen asset'."""
    text = title(name)
    return f"{number} {text if number != 1 else text.replace('assets', 'asset').replace('roles', 'role')}"


def title(name: str) -> str:
    """A name for people: cousins_4 -> '4 cousins', cousin_2 -> 'cousin 2', door_handle -> 'Door opening, handle',
    cover_8_randomised -> '8 covering assets, randomised'.

    A row's name is no word about its policies: what they are, the config says (`methods.kind`).
    """
    row, _, run = name.partition("/")
    if run:
        return f"{title(row)}, {run}"
    if name in TASKS:
        return TASKS[name]
    if task := next((task for task in TASKS if name.startswith(f"{task}_")), None):
        return f"{TASKS[task]}, {name.removeprefix(f'{task}_').replace('_', ' ')}"
    if is_randomised(name):
        return f"{title(plain(name))}, randomised"
    if is_set(name) and (read := read_set(name)).rule in SETS:
        return f"{read.size} {SETS[read.rule]}"
    return NAMES.get(name, name.replace("_", " "))


def role_title(role: str) -> str:
    """A role for people; random_3 is one asset, as a training set it is three; random_19 is the third of draw 2."""
    rule, number, randomised = read_set(role) if is_set(role) else SetName(role, 1, False)
    if rule not in DRAWN:
        return title(role)
    draw, place = divmod(number - 1, DRAW)
    return f"{rule} {place + 1}" + f" of draw {draw + 1}" * (draw > 0) + ", randomised" * randomised
