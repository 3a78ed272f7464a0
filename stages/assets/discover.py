"""Find the models of a user's folder: which files are one, what they are called, of what category they are."""

import json
import re
import sys
from collections.abc import Iterable, Sequence
from itertools import chain, count
from pathlib import Path
from typing import NamedTuple

from stages.assets.mjcf_file import root_tag

# PartNet-Mobility and GAPartNet: <number>/, with the category in meta.json; the first of these files is the model.
NUMBERED = ("mobility.urdf", "mobility_annotation_gapartnet.urdf")
CATEGORIES = {  # of PartNet-Mobility, in the words of the library where they differ
    "bucket": "trash_can", "foldingchair": "chair", "kitchenpot": "cooking_pot", "lamp": "table_lamp",
    "refrigerator": "fridge",     "storagefurniture": "bottom_cabinet", "trashcan": "trash_can",
}  # fmt: skip
PAGE = "index.html"  # of the verb `import`, in the folder that it writes
COMMON = {"base", "main", "mesh", "mobility", "model", "object", "robot", "scene", "textured", "urdf", "visual"}


class Found(NamedTuple):
    """A model: its file, the folder of the user's that it lies in, its category and its name, in words."""

    path: Path
    folder: Path
    category: str
    name: str


def discover(folder: Path, kinds: Sequence[str]) -> list[Found]:
    """The models below a folder, sorted.

    <category>/<model>.<kind>; <category>/<model>/...: its files of the first kind that it has; <number>/mobility.urdf,
    with the category in meta.json, or <category>/<number>/mobility.urdf. What lies in a folder of its own is called
    as that folder is, unless several models do.

    Args:
        folder: of the user.
        kinds: suffixes of model files, the most telling first.
    """
    found: list[Found] = []
    for child in sorted(path for path in folder.iterdir() if path.is_dir()):
        if numbered := numbered_model(child):
            found.append(Found(numbered, folder, told_category(child) or folder.name, child.name))
            continue
        for inner in sorted(child.iterdir()):
            if is_model(inner, kinds):
                found.append(Found(inner, folder, child.name, inner.stem))
            elif inner.is_dir() and (numbered := numbered_model(inner)):
                found.append(Found(numbered, folder, told_category(inner) or child.name, inner.name))
            elif inner.is_dir():
                found += [
                    Found(path, folder, child.name, _name(path, inner, n)) for path, n in _first_kind(inner, kinds)
                ]
    models = [one for one in found if not is_part(one.path)]
    if len(models) < len(found):
        parts = len(found) - len(models)
        print(f"{folder}: {parts} files are parts that MJCF models include, no models: skipped", file=sys.stderr)
    return models


def numbered_model(folder: Path) -> Path | None:
    """The URDF of a model of PartNet-Mobility or GAPartNet; of its versions the first."""
    return next((folder / name for name in NUMBERED if (folder / name).is_file()), None)


def told_category(folder: Path) -> str | None:
    """What meta.json says that the model is, in the library's words; None: it does not."""
    try:
        told = json.loads((folder / "meta.json").read_text(encoding="utf-8")).get("model_cat")
    except (OSError, ValueError, AttributeError):
        return None
    if not isinstance(told, str) or not told.strip():
        return None
    return CATEGORIES.get(told.lower(), re.sub(r"(?<=[a-z])(?=[A-Z])", "_", told))


def is_model(path: Path, kinds: Sequence[str]) -> bool:
    """Whether it is a file of one of the kinds; XML is MJCF, or a part of it, if it says so."""
    if not path.is_file() or path.suffix.lower() not in kinds:
        return False
    return path.suffix.lower() != ".xml" or root_tag(path).startswith("mujoco")


def is_part(path: Path) -> bool:
    """Whether it is MJCF that others include."""
    return path.suffix.lower() == ".xml" and root_tag(path) != "mujoco"


def _first_kind(folder: Path, kinds: Sequence[str]) -> list[tuple[Path, int]]:
    """The files of the first kind that occurs in a model's folder, and how many they are."""
    inside = [path for path in sorted(folder.rglob("*")) if is_model(path, kinds)]
    groups = ([path for path in inside if path.suffix.lower() == kind] for kind in kinds)
    files = next((group for group in groups if group), [])
    return [(path, len(files)) for path in files]


def _name(path: Path, folder: Path, models: int) -> str:
    return folder.name if models == 1 or path.stem.lower() in COMMON else path.stem


def numbered_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... after those that are there already."""
    used, result = set(taken), []
    for name in names:
        numbered = (f"{name}_{number}" for number in count(2))
        free = next(one for one in chain([name], numbered) if one not in used)
        used.add(free)
        result.append(free)
    return result
