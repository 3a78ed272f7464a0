"""Find the models of a user's folder: which files are one, what they are called, of what category they are."""

import json
import re
import sys
from collections.abc import Iterable, Sequence
from itertools import chain, count
from pathlib import Path
from typing import NamedTuple

from plugins.importing.inside import read_inside
from plugins.importing.mjcf_file import root_tag
from plugins.importing.sandbox import run_in_fork
from stages.contracts.categories import category_in, known_categories
from stages.contracts.category import by_joined_name, split_words
from stages.contracts.errors import InputError, escape_control
from stages.contracts.files import MAX_TEXT

# PartNet-Mobility and GAPartNet: <number>/, with the category in meta.json; the first of these files is the model.
NUMBERED = ("mobility.urdf", "mobility_annotation_gapartnet.urdf")
PAGE, PACK = "index.html", "pack.yaml"  # of the verb `import`, in the folder that it writes
COMMON = {  # words that say nothing of what a model is
    "asset", "base", "collision", "data", "export", "glb", "main", "mesh", "meshes", "misc", "mjcf", "mobility",
    "model", "obj", "object", "other", "output", "result", "robot", "scene", "textured", "urdf", "visual", "xml",
}  # fmt: skip
WHOLE = {".urdf", ".xml"}  # models that name the meshes that they are made of
NAMES = re.compile(rb"""file(?:name)?\s*=\s*["']([^"']+)["']""")


class Found(NamedTuple):
    """A model: its file, the folder of the user's that it lies in, its category and its name, in words."""

    path: Path
    folder: Path
    category: str
    name: str


def discover(folder: Path, kinds: Sequence[str]) -> list[Found]:
    """The models below a folder, sorted; looked for in a process of its own, as files there are read for it.

    Layouts: <category>/<model>.<kind>; <category>/<model>/..., of which the files of the first kind there count;
    <model>.<kind>, whose name may be a category; <number>/mobility.urdf (PartNet-Mobility), with or without a category
    above. A folder whose name says nothing (`assets`, `urdf`) is skipped over. A model alone in its folder takes the
    folder's name.

    Not models: MJCF that others include; meshes that a URDF or MJCF file names, and others beside these.

    Args:
        folder: of the user.
        kinds: suffixes of model files, the most telling first.
    """
    found, lines = json.loads(run_in_fork(folder, lambda: json.dumps(_discover(folder, kinds), default=str)))
    for line in lines:
        print(escape_control(line), file=sys.stderr)
    return [Found(Path(path), Path(within), category, name) for path, within, category, name in found]


def _discover(folder: Path, kinds: Sequence[str]) -> tuple[list[Found], list[str]]:
    """The models, and a line for each thing that is not one."""
    if numbered := find_numbered_model(folder):
        return [partnet(numbered)], []
    unused = {path: why for path in sorted(folder.rglob("*")) if (why := explain_unusable(path, folder, kinds))}
    lines = [f"left out: {path.relative_to(folder)}: {why}" for path, why in unused.items()]
    found = _find_models_below(folder, folder, kinds)
    models = [one for one in found if not is_part(one.path, folder)]
    if any(one.path.suffix.lower() not in WHOLE for one in models):
        named = find_named_meshes(folder)
        around = {path.parent for path in named} - {folder}
        models = [
            one
            for one in models
            if one.path.suffix.lower() in WHOLE or not (one.path in named or around.intersection(one.path.parents))
        ]
    if len(models) < len(found):
        parts = len(found) - len(models)
        lines.append(f"{folder}: {parts} files are parts that other models include or name: no models")
    return models, lines


def describe_single_file(path: Path, folder: Path | None = None) -> Found:
    """A model file by itself, in a folder that says nothing of it."""
    if folder is None and path.name in NUMBERED:
        return partnet(path)
    return Found(path, folder or path.parent, category_in(path.stem) or strip_name(path.stem), path.stem)


def explain_unusable(path: Path, folder: Path, kinds: Sequence[str]) -> str | None:
    """Why a file or folder is not looked at, whatever is in it; None: it is."""
    if not is_utf8(path.name):
        return "its name is not UTF-8"
    if path.is_symlink() and path.is_dir():
        if not path.resolve().is_relative_to(folder.resolve()):
            return f"is a link out of {folder.name}/"
        return f"is a link to a folder of {folder.name}/, which counts where it is"  # links may lead in circles
    if path.suffix.lower() in kinds and not path.is_file() and not path.is_dir():
        return "is no file that can be read" if path.exists() else "is a link to nothing"
    return None


def _list_usable(here: Path, folder: Path, kinds: Sequence[str]) -> list[Path]:
    """What lies in a folder and is looked at, sorted."""
    return [child for child in sorted(here.iterdir()) if explain_unusable(child, folder, kinds) is None]


def is_utf8(name: str) -> bool:
    """Whether the name of a file is text."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def partnet(path: Path) -> Found:
    """The model of a folder <number>/ of PartNet-Mobility by itself."""
    folder = path.parent
    return Found(path, folder, read_category(folder, folder) or folder.resolve().parent.name, folder.resolve().name)


def _find_models_below(here: Path, folder: Path, kinds: Sequence[str]) -> list[Found]:
    """The models of a folder, or of one in it that says nothing; some may be parts of others."""
    found: list[Found] = []
    for child in _list_usable(here, folder, kinds):
        if is_model(child, folder, kinds):
            found.append(describe_single_file(child, folder))
        elif not child.is_dir():
            continue
        elif numbered := find_numbered_model(child):
            found.append(Found(numbered, folder, read_category(child, folder) or here.name, child.name))
        elif is_common(child.name):
            found += _find_models_below(child, folder, kinds)
        else:
            found += _find_in_category(child, folder, kinds)
    return found


def _find_in_category(child: Path, folder: Path, kinds: Sequence[str]) -> list[Found]:
    """The models of a category's folder. If its name is none of ours, but that of a model in it is, it holds various
    things: each is then of the category that its own name says."""
    shared, own = category_in(child.name), strip_name(child.name)
    found: list[Found] = []
    for inner in _list_usable(child, folder, kinds):
        if is_model(inner, folder, kinds):
            found.append(Found(inner, folder, shared or category_in(inner.stem) or own, inner.stem))
        elif inner.is_dir() and (numbered := find_numbered_model(inner)):
            found.append(Found(numbered, folder, read_category(inner, folder) or shared or own, inner.name))
        elif inner.is_dir():
            for path, count_ in _first_kind(inner, folder, kinds):
                names = [*path.relative_to(child).parts[:-1], *([path.stem] if count_ > 1 else [])]
                category = shared or next((known for name in names if (known := category_in(name))), own)
                found.append(Found(path, folder, category, _name(path, inner, count_)))
    if all(one.category == own for one in found):
        return found
    named = {one: strip_name(one.name) for one in found if one.category == own and split_words(one.name)}
    return [one._replace(category=named.get(one, one.category)) for one in found]


def is_common(name: str) -> bool:
    """Whether a name consists of words that any model could have (`assets`, `mesh_obj`)."""
    return bool(split_words(name)) and all(
        word in COMMON or word.removesuffix("s") in COMMON for word in split_words(name)
    )


def strip_name(name: str) -> str:
    """A name without leading numbers and trailing common words: `011_banana_mesh` is banana."""
    kept = re.sub(r"^[\W\d_]+", "", name)
    while (shorter := re.sub(r"[\W\d_]+[A-Za-z]+$", "", kept)) != kept and is_common(kept[len(shorter) :]):
        kept = shorter
    return kept or name


def find_named_meshes(folder: Path) -> set[Path]:
    """The files below a folder whose name (without folders) is used by a URDF or MJCF file in it."""
    files = [path for path in folder.rglob("*") if is_utf8(str(path)) and path.is_file()]
    texts = (_text(path, folder) for path in files if path.suffix.lower() in WHOLE)
    used = (name.decode(errors="replace").replace("\\", "/") for text in texts for name in NAMES.findall(text))
    names = {name.rpartition("/")[2].lower() for name in used}
    return {path for path in files if path.suffix.lower() not in WHOLE and path.name.lower() in names}


def _text(path: Path, folder: Path) -> bytes:
    """What is in a file of text; nothing if it cannot be read: the import reports it."""
    try:
        return read_inside(path, folder, MAX_TEXT)
    except InputError:
        return b""


def find_numbered_model(folder: Path) -> Path | None:
    """The URDF of a model of PartNet-Mobility or GAPartNet; of its versions the first."""
    return next((folder / name for name in NUMBERED if (folder / name).is_file()), None)


def read_category(model: Path, folder: Path) -> str | None:
    """What meta.json in a model's folder says that it is, in the library's words; None: it does not."""
    try:
        category = json.loads(_text(model / "meta.json", folder)).get("model_cat")
    except (ValueError, AttributeError, RecursionError):
        return None
    if not isinstance(category, str) or not category.strip():
        return None
    known = by_joined_name(known_categories()).get(category.lower())
    return known.name if known else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", category)


def is_model(path: Path, folder: Path, kinds: Sequence[str]) -> bool:
    """Whether it is a file of one of the kinds; XML is MJCF, or a part of it, if it says so."""
    if not path.is_file() or path.suffix.lower() not in kinds:
        return False
    tag = root_tag(path, folder) if path.suffix.lower() == ".xml" else None
    return tag is None or tag.startswith("mujoco")


def is_part(path: Path, folder: Path) -> bool:
    """Whether it is MJCF that others include."""
    return path.suffix.lower() == ".xml" and root_tag(path, folder) not in (None, "mujoco")


def _first_kind(place: Path, folder: Path, kinds: Sequence[str]) -> list[tuple[Path, int]]:
    """The files of the first kind that occurs in a model's folder, and how many they are."""
    inside = [path for path in sorted(place.rglob("*")) if is_utf8(str(path)) and is_model(path, folder, kinds)]
    groups = ([path for path in inside if path.suffix.lower() == kind] for kind in kinds)
    files = next((group for group in groups if group), [])
    return [(path, len(files)) for path in files]


def _name(path: Path, folder: Path, models: int) -> str:
    """The folder's name if the model is alone in it, else that of the file or of the nearest folder that tells."""
    above = [place.name for place in path.parents if place.is_relative_to(folder)]
    names = [folder.name, path.stem, *above] if models == 1 else [path.stem, *above]
    return next((name for name in [*names, folder.parent.name] if not is_common(name)), folder.name)


def number_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... after those that are there already."""
    used, result = set(taken), []
    for name in names:
        numbered = (f"{name}_{number}" for number in count(2))
        free = next(one for one in chain([name], numbered) if one not in used)
        used.add(free)
        result.append(free)
    return result
