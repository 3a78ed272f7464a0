"""An MJCF file as MuJoCo compiles it; all files that it names lie in the user's folder."""

import xml.etree.ElementTree as ET
from itertools import product
from pathlib import Path
from typing import Any

import mujoco

from stages.articulated.urdf_tree import AROUND
from stages.contracts.errors import InputError
from stages.geometry.solids import MINIMUM_INERTIA, MINIMUM_MASS

DIRECTORIES = ("assetdir", "meshdir", "texturedir")  # of a compiler element


def compiled(path: Path, folder: Path) -> tuple[Any, Any]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of a file.

    Raises:
        InputError: MuJoCo refuses the file, it is a part of a model, or it names files outside `folder`.
    """
    if (tag := parsed(path).tag) != "mujoco":
        raise InputError(path, f"has <{tag[:40]}> at the top.", "give the file that includes it", code="E-MJCF-PART")
    check_inside(path, folder)
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes MUJOCO_LOG.TXT where the user is
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        # Bodies that nothing weighs, as of visual geoms alone, get their masses from their shapes later.
        spec.compiler.boundmass, spec.compiler.boundinertia = MINIMUM_MASS, MINIMUM_INERTIA
        return spec, spec.compile()
    except Exception as error:  # of MuJoCo's own kinds, by version
        reason = " ".join(str(error).split())[:300]
        raise InputError(path, f"MuJoCo does not take it: {reason}", code="E-MJCF-REFUSED") from None


def check_inside(path: Path, folder: Path) -> None:
    """Refuse a file that names others, or includes files that name others, outside of a folder.

    Raises:
        InputError: names the first.
    """
    names, directories, seen, queue = set[str](), {""}, set[Path](), [path]
    while queue:
        here = queue.pop()
        if here in seen:
            continue
        seen.add(here)
        for element in parsed(here).iter():
            directories.update(element.attrib[key] for key in DIRECTORIES if key in element.attrib)
            files = [value for key, value in element.attrib.items() if key.startswith("file")]
            names.update(files)
            if element.tag == "include":  # beside the model, or beside the file that includes it
                near = [base / name for base in (path.parent, here.parent) for name in files]
                queue += [file for file in near if file.is_file()]
    for name, directory, beside in product(sorted(names), sorted(directories), sorted(seen)):
        file = (beside.parent / directory / name).resolve()
        if file.exists() and not file.is_relative_to(folder.resolve()):
            what = f"names '{name[:200]}', outside of {folder.name}/."
            raise InputError(path, what, "copy it there", code="E-FILE-OUTSIDE")


def parsed(path: Path) -> ET.Element:
    """The root of an MJCF file.

    Raises:
        InputError: it is no XML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        if "<!DOCTYPE" in text:
            raise InputError(path, "declares a DOCTYPE, which MJCF does not need.", "remove it", code="E-XML-DOCTYPE")
        return ET.fromstring(text.strip(AROUND))
    except (OSError, UnicodeDecodeError, ET.ParseError, ValueError) as error:
        raise InputError(path, f"is not XML: {error}.", code="E-XML-BROKEN") from None


def root_tag(path: Path) -> str:
    """Name of the outermost element; empty if there is none."""
    try:
        return next((element.tag for _, element in ET.iterparse(path, ["start"])), "")
    except (OSError, ET.ParseError, ValueError):
        return ""
