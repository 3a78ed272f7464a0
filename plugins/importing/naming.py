"""Names and categories of models, as the names of files and folders say."""

import json
import re
from collections.abc import Iterable
from itertools import chain, count
from pathlib import Path

from plugins.importing.inside import read_text_inside
from stages.contracts.categories import known_categories
from stages.contracts.category import by_joined_name, split_words

COMMON = {  # words that say nothing of what a model is
    "asset", "base", "collision", "data", "export", "glb", "main", "mesh", "meshes", "misc", "mjcf", "mobility",
    "model", "obj", "object", "other", "output", "result", "robot", "scene", "textured", "urdf", "visual", "xml",
}  # fmt: skip


def is_common(name: str) -> bool:
    """Whether a name consists of words that any model could have (`assets`, `mesh_obj`)."""
    words = split_words(name)
    return bool(words) and all(word in COMMON or word.removesuffix("s") in COMMON for word in words)


def strip_name(name: str) -> str:
    """A name without leading numbers and trailing common words: `011_banana_mesh` is banana."""
    kept = re.sub(r"^[\W\d_]+", "", name)
    while (shorter := re.sub(r"[\W\d_]+[A-Za-z]+$", "", kept)) != kept and is_common(kept[len(shorter) :]):
        kept = shorter
    return kept or name


def name_model(path: Path, folder: Path, alone: bool) -> str:
    """The folder's name if the model is alone in it, else that of the file or of the nearest folder that tells."""
    above = [place.name for place in path.parents if place.is_relative_to(folder)]
    names = [*([folder.name] if alone else []), path.stem, *above, folder.parent.name]
    return next((name for name in names if not is_common(name)), folder.name)


def read_category(model: Path, folder: Path) -> str | None:
    """What meta.json in a model's folder says that it is, in the library's words; None: it does not."""
    try:
        category = json.loads(read_text_inside(model / "meta.json", folder)).get("model_cat")
    except (ValueError, AttributeError, RecursionError):
        return None
    if not isinstance(category, str) or not category.strip():
        return None
    known = by_joined_name(known_categories()).get(category.lower())
    return known.name if known else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", category)


def snake_case(text: str) -> str:
    """Lower-case letters, digits and underscores."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "model"


def number_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... after those that are there already."""
    used, result = set(taken), []
    for name in names:
        free = next(one for one in chain([name], (f"{name}_{number}" for number in count(2))) if one not in used)
        used.add(free)
        result.append(free)
    return result
