"""Names and categories of models, as the names of files and folders say."""

import json
import re
import unicodedata
from collections.abc import Iterable
from itertools import chain, count
from pathlib import Path

from roomkin.plugins.importing.sandbox import read_text_inside
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import by_joined_name, split_words
from roomkin.stages.contracts.errors import plain_letters

COMMON = {  # words that say nothing of what a model is
    "asset", "base", "collision", "data", "description", "export", "glb", "main", "mesh", "meshes", "misc", "mjcf",
    "mobility", "model", "obj", "object", "other", "output", "result", "robot", "scene", "textured", "urdf", "visual",
    "xacro", "xml",
}  # fmt: skip

SOUNDS = str.maketrans(
    dict(
        zip(
            "абвгдезиклмнопрстуфхыэіґαβγδεζηικλμνοπρσςτυφω",
            "abvgdeziklmnoprstufhyeigavgdeziiklmnoprsstyfo",
            strict=True,
        )
    )
    | {"ж": "zh", "ц": "ts", "ч": "ch", "ш": "sh", "щ": "shch", "ъ": "", "ь": "", "ю": "yu", "я": "ya", "є": "ye"}
    | {"θ": "th", "ξ": "x", "χ": "ch", "ψ": "ps"}
)  # letters of Cyrillic and Greek


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
    """Lower-case letters, digits and underscores; letters of other scripts as they sound, or by their number."""
    latin = "".join(map(_spell, plain_letters(text).translate(SOUNDS)))
    return re.sub(r"[^a-z0-9]+", "_", latin).strip("_") or "model"


def _spell(letter: str) -> str:
    """A letter of any script in Latin ones: か is ka, 椅 is u6905."""
    if letter.isascii() or unicodedata.category(letter)[0] not in "LMN":
        return letter
    name = unicodedata.name(letter, "")
    return f"u{ord(letter):x}" if "IDEOGRAPH" in name or not name else name.split()[-1].lower()


def number_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... after those that are there already."""
    used, result = set(taken), []
    for name in names:
        free = next(one for one in chain([name], (f"{name}_{number}" for number in count(2))) if one not in used)
        used.add(free)
        result.append(free)
    return result
