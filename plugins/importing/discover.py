"""Find the models of a user's folder: which files are one, and what they are taken for."""

import json
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from roomkin.plugins.importing.mjcf_file import root_tag
from roomkin.plugins.importing.sandbox import (
    is_common,
    name_model,
    read_category,
    read_text_inside,
    run_in_fork,
    strip_name,
)
from roomkin.stages.contracts.categories import category_in
from roomkin.stages.contracts.errors import count, escape_control, list_plain_words

# PartNet-Mobility and GAPartNet: <number>/, with the category in meta.json; the first of these files is the model.
NUMBERED = ("mobility.urdf", "mobility_annotation_gapartnet.urdf")
PAGE, PACK = "index.html", "pack.yaml"  # of the command `import`, in the folder that it writes
WHOLE = {".urdf", ".xml"}  # models that name the meshes that they are made of
UNREAD = {".sdf", ".world", ".xacro", ".usda"}  # likewise, of kinds that are not read: their meshes are parts, too
FOREIGN = (  # all kinds that are not read
    ".3ds", ".3mf", ".blend", ".c4d", ".fbx", ".iges", ".igs", ".kinbody.xml", ".ma", ".max", ".mb", ".off", ".sdf",
    ".skp", ".step", ".stp", ".usd", ".usda", ".usdc", ".usdz", ".world", ".wrl", ".x3d", ".xacro",
)  # fmt: skip
# What parts are called, and the folders that they lie in, beside a model that is not read.
PART_WORDS = {"body", "collider", "collision", "door", "drawer", "hull", "link", "ucx"}
PART_FOLDERS = {"collision", "collisions", "mesh", "meshes", "parts", "visual", "visuals"}
NAMES = re.compile(rb"""file(?:name)?\s*=\s*["']([^"']+)["']|<uri>\s*([^<]+?)\s*</uri>|@([^@\n]+)@""")

OWN_NAME = re.compile(rb"""<(?:robot|mujoco)\s[^>]*?\b(?:name|model)\s*=\s*["']([^"']*)""")


class Given(NamedTuple):
    """A model: its file, the folder of the user's that it lies in, its category and its name, in words."""

    path: Path
    folder: Path
    category: str
    name: str


def discover(folder: Path, kinds: Sequence[str]) -> list[Given]:
    """The models below a folder, sorted; looked for in a process of its own, as files there are read for it.

    Layouts: <category>/<model>.<kind>; <category>/<model>/..., of which the files of the first kind there count;
    <model>.<kind>, whose name may be a category; <number>/mobility.urdf (PartNet-Mobility), with or without a category
    above. A folder whose name says nothing (`assets`, `urdf`) is skipped over. A model alone in its folder takes the
    folder's name.

    Not models: MJCF that others include; meshes that a URDF, MJCF, SDF or USD file names, and others beside these;
    meshes that lie or are called as parts beside a model that is not read.

    Args:
        folder: of the user.
        kinds: suffixes of model files, the most telling first.
    """
    found, lines = json.loads(run_in_fork(folder, lambda: json.dumps(_discover(folder, kinds), default=str)))
    for line in lines:
        print(escape_control(line), file=sys.stderr)
    return [Given(Path(path), Path(within), category, name) for path, within, category, name in found]


def describe_single_file(path: Path) -> Given:
    """A model file that is given by itself."""
    if path.name not in NUMBERED:
        return Given(path, path.parent, _category_of(path, path.parent) or strip_name(path.stem), path.stem)
    folder = path.parent
    return Given(path, folder, read_category(folder, folder) or folder.resolve().parent.name, folder.resolve().name)


def _discover(folder: Path, kinds: Sequence[str]) -> tuple[list[Given], list[str]]:
    """The models, and a line for each thing that is not one."""
    if numbered := _numbered_model(folder):
        return [describe_single_file(numbered)], []
    unused = {path: why for path in sorted(folder.rglob("*")) if (why := _explain_unusable(path, folder, kinds))}
    lines = [f"left out: {path.relative_to(folder)}: {why}" for path, why in unused.items()]
    found = list(_find_models(folder, folder, kinds))
    models = [one for one in found if not is_part(one.path, folder)]
    if any(one.path.suffix.lower() not in WHOLE for one in models):
        named = _find_named_meshes(folder)
        around = {path.parent for path in named} - {folder}
        models = [
            one
            for one in models
            if one.path.suffix.lower() in WHOLE or not (one.path in named or around.intersection(one.path.parents))
        ]
    if parts := len(found) - len(models):
        lines.append(f"{folder}: {parts} files are parts that other models include or name: no models")
    unread = [path for path in sorted(folder.rglob("*")) if find_unread_end(path, folder)]
    beside = {one.path: whole for one in models for whole in unread if _is_beside(one.path, whole, folder)}
    if beside:
        names = ", ".join(sorted({whole.relative_to(folder).as_posix() for whole in beside.values()}))
        lines.append(f"{folder}: {count(len(beside), 'file')} beside {names}, taken for parts of it: no models")
    return [one for one in models if one.path not in beside], lines


def find_unread_end(path: Path, folder: Path) -> str | None:
    """The end of a model's name of a kind that is not read, `.xacro` of one that is called URDF; None: it is read."""
    if path.suffix.lower() == ".urdf" and b"<xacro:" in read_text_inside(path, folder):
        return ".xacro"
    return next((end for end in FOREIGN if is_utf8(path.name) and path.name.lower().endswith(end)), None)


def _is_beside(path: Path, whole: Path, folder: Path) -> bool:
    """Whether a mesh is a part of a model that is not read, which lies beside or above it: by where it lies, or what it
    is called."""
    place = _find_place(whole, folder)
    if path.suffix.lower() in WHOLE or not path.is_relative_to(place):
        return False
    inner = {name.lower() for name in path.relative_to(place).parts[:-1]}
    return bool(PART_FOLDERS & inner or PART_WORDS & {*list_plain_words(path.stem)})


def _explain_unusable(path: Path, folder: Path, kinds: Sequence[str]) -> str | None:
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


def _find_models(here: Path, folder: Path, kinds: Sequence[str]) -> Iterator[Given]:
    """The models of a folder, or of one in it that says nothing; some may be parts of others."""
    for child in _list_usable(here, folder, kinds):
        if is_model(child, folder, kinds):
            yield Given(child, folder, _category_of(child, folder) or strip_name(child.stem), child.stem)
        elif not child.is_dir():
            continue
        elif numbered := _numbered_model(child):
            yield Given(numbered, folder, read_category(child, folder) or here.name, child.name)
        elif is_common(child.name):
            yield from _find_models(child, folder, kinds)
        else:
            yield from _find_in_category(child, folder, kinds)


def _find_in_category(child: Path, folder: Path, kinds: Sequence[str]) -> list[Given]:
    """The models of a category's folder. If its name is none of ours, but that of a model in it is, it holds various
    things: each is then of the category that its own name says."""
    shared, own = category_in(child.name), strip_name(child.name)
    found: list[Given] = []
    for inner in _list_usable(child, folder, kinds):
        if is_model(inner, folder, kinds):
            found.append(Given(inner, folder, shared or _category_of(inner, folder) or own, inner.stem))
        elif inner.is_dir() and (numbered := _numbered_model(inner)):
            found.append(Given(numbered, folder, read_category(inner, folder) or shared or own, inner.name))
        elif inner.is_dir():
            files = _first_kind(inner, folder, kinds)
            for path in files:
                names = [*path.relative_to(child).parts[:-1], path.stem, _read_own_name(path, folder)]
                category = shared or next(filter(None, map(category_in, names)), own)
                found.append(Given(path, folder, category, name_model(path, inner, len(files) == 1)))
    if all(one.category == own for one in found):
        return found
    named = {one: strip_name(one.name) for one in found if one.category == own and list_plain_words(one.name)}
    return [one._replace(category=named.get(one, one.category)) for one in found]


def _category_of(path: Path, folder: Path) -> str | None:
    """The known category that a file's name means, or the name that is written in it; None: neither."""
    return category_in(path.stem) or category_in(_read_own_name(path, folder))


def _read_own_name(path: Path, folder: Path) -> str:
    """What a URDF or MJCF calls itself; empty: nothing."""
    found = OWN_NAME.search(read_text_inside(path, folder)) if path.suffix.lower() in WHOLE else None
    return found[1].decode(errors="replace") if found else ""


def _list_usable(here: Path, folder: Path, kinds: Sequence[str]) -> list[Path]:
    """The files of a folder that are looked at, sorted."""
    return [child for child in sorted(here.iterdir()) if _explain_unusable(child, folder, kinds) is None]


def _first_kind(place: Path, folder: Path, kinds: Sequence[str]) -> list[Path]:
    """The files of the first kind that occurs in a model's folder."""
    inside = [path for path in sorted(place.rglob("*")) if is_utf8(str(path)) and is_model(path, folder, kinds)]
    return next(filter(None, ([path for path in inside if path.suffix.lower() == kind] for kind in kinds)), [])


def _numbered_model(folder: Path) -> Path | None:
    """The URDF of a model of PartNet-Mobility or GAPartNet; of its versions the first."""
    return next((folder / name for name in NUMBERED if (folder / name).is_file()), None)


def _find_named_meshes(folder: Path) -> set[Path]:
    """The meshes below a folder that a file of a model in it uses: by name below where the model lies (its folder, or
    the next above that says something), elsewhere by the name of their folder, too."""
    files = [path for path in folder.rglob("*") if is_utf8(str(path)) and path.is_file()]
    meshes: dict[str, list[Path]] = {}
    for path in files:
        if path.suffix.lower() not in WHOLE:
            meshes.setdefault(path.name.lower(), []).append(path)
    named = set()
    for whole in files:
        if whole.suffix.lower() not in WHOLE | UNREAD:
            continue
        place = _find_place(whole, folder)
        for form in NAMES.findall(read_text_inside(whole, folder)):
            *above, name = b"".join(form).decode(errors="replace").replace("\\", "/").lower().split("/")
            for mesh in meshes.get(name, ()):
                if mesh.is_relative_to(place) or [mesh.parent.name.lower()] == above[-1:]:
                    named.add(mesh)
    return named


def _find_place(whole: Path, folder: Path) -> Path:
    """The folder that is a model's: that of its file, or the next above whose name says something."""
    place = whole.parent
    while place != folder and is_common(place.name):
        place = place.parent
    return place


def is_utf8(name: str) -> bool:
    """Whether the name of a file is text."""
    return name == name.encode(errors="replace").decode()


def is_model(path: Path, folder: Path, kinds: Sequence[str]) -> bool:
    """Whether it is a file of one of the kinds; XML is MJCF, or a part of it, if it says so."""
    if not path.is_file() or path.suffix.lower() not in kinds:
        return False
    tag = root_tag(path, folder) if path.suffix.lower() == ".xml" else None
    return tag is None or tag.startswith("mujoco")


def is_part(path: Path, folder: Path) -> bool:
    """Whether it is MJCF that others include."""
    return path.suffix.lower() == ".xml" and root_tag(path, folder) not in (None, "mujoco")
