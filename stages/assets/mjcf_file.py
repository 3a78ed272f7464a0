"""One MJCF file as MuJoCo reads it: what it includes put in its place, files named by whole paths, inside a folder."""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from stages.articulated.inside import OutsideError, find_inside
from stages.contracts.errors import InputError

DEEPEST = 20  # files that include each other
KEPT = {"asset", "compiler", "default", "worldbody"}  # all else is control, sensors and looks of a viewer
# Nothing is thrown away or merged, and the whole paths that we write count.
COMPILER = {"discardvisual": "false", "fusestatic": "false", "strippath": "false"}


def compiled(path: Path, folder: Path) -> tuple[Any, Any]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of a file.

    Raises:
        InputError: MuJoCo is missing or refuses the file, it is a part of a model, or names files outside `folder`.
    """
    root = parsed(path)
    if root.tag != "mujoco":
        raise InputError(path, f"has <{root.tag[:40]}> at the top.", "a model in MJCF starts with <mujoco>")
    try:
        import mujoco
    except ImportError:
        raise InputError(path, "is MJCF, which MuJoCo reads.", "pip install mujoco") from None
    directories = {"mesh": "", "texture": "", "hfield": ""}
    _include(root, path, path, folder, 0)
    for compiler in root.iter("compiler"):
        told = compiler.attrib
        for kind, key in (("mesh", "meshdir"), ("hfield", "meshdir"), ("texture", "texturedir")):
            directories[kind] = told.get(key, told.get("assetdir", directories[kind]))
    for element in root.iter():
        for key in [key for key in element.attrib if key.startswith("file")]:
            name = element.attrib[key]
            element.set(key, str(_inside(Path(directories.get(element.tag, "")) / name, path, folder)))
    for element in [element for element in root if element.tag not in KEPT]:
        root.remove(element)
    ET.SubElement(root, "compiler", COMPILER)
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes MUJOCO_LOG.TXT where the user is
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
        return spec, spec.compile()
    except Exception as error:  # of MuJoCo's own kinds, by version
        reason = " ".join(str(error).split())[:200]
        raise InputError(path, f"MuJoCo does not take it: {reason}") from None


def parsed(path: Path) -> ET.Element:
    """The root of an MJCF file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        if "<!DOCTYPE" in text:
            raise InputError(path, "declares a DOCTYPE, which MJCF does not need.", "remove it")
        return ET.fromstring(text)
    except (OSError, UnicodeDecodeError, ET.ParseError, ValueError) as error:
        raise InputError(path, f"is not XML: {error}.") from None


def root_tag(path: Path) -> str:
    """Name of the outermost element; empty if there is none."""
    try:
        return next((element.tag for _, element in ET.iterparse(path, ["start"])), "")
    except (OSError, ET.ParseError, ValueError):
        return ""


def _include(element: ET.Element, here: Path, path: Path, folder: Path, depth: int) -> None:
    """Put what is included in the place of every <include>."""
    if depth > DEEPEST:
        raise InputError(path, "its files include each other without end.")
    for index in range(len(element) - 1, -1, -1):
        child = element[index]
        if child.tag == "include":
            file = _inside(Path(child.get("file", "")), here, folder, path)
            part = parsed(file)
            _include(part, file, path, folder, depth + 1)
            element[index : index + 1] = list(part)
        else:
            _include(child, here, path, folder, depth)


def _inside(name: Path, here: Path, folder: Path, above: Path | None = None) -> Path:
    """A file by its name in MJCF: relative to the file `here` or to the model `above`, or with folders renamed."""
    try:
        plain = Path(*[part for part in name.parts if part not in ("..", "/")])
        for name_, base in ((name, here), (name, above or here), (plain, here)):
            if name_.is_absolute():
                continue
            direct = (base.parent / name_).resolve()
            if direct.is_file() and direct.is_relative_to(folder.resolve()):
                return direct
        found = find_inside(str(plain), here.parent, folder)
    except OutsideError:
        found = None
    if found is None:
        raise InputError(above or here, f"there is no file '{str(name)[:200]}' in {folder.name}/.", "copy it inside")
    return found
