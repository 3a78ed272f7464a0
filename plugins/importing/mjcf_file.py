"""MJCF (MuJoCo) files: what they include, all of it in the user's folder, compiled in memory with no disk."""

import os.path
import resource
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import mujoco

from roomkin.plugins.importing.sandbox import is_inside, read_inside
from roomkin.stages.articulated.mesh_resolver import explain_missing
from roomkin.stages.articulated.urdf_tree import AROUND, MOST_SHAPES
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.solids import MINIMUM_INERTIA, MINIMUM_MASS

DIRECTORIES = ("assetdir", "meshdir", "texturedir")  # of a compiler element


class Sources:
    """The XML files of a model, itself first, and the files that they name."""

    def __init__(self, path: Path, folder: Path) -> None:
        """Read the XML files.

        Raises:
            InputError: one lies outside of the folder or is no XML, or together they are too much.
        """
        self.path, self.folder = path, folder
        self.roots = dict[Path, ET.Element]()
        self._attached = defaultdict[str, dict[Path, set[Path]]](dict)  # by their name, and by the file that gives it
        self._sizes = dict[Path, int]()
        queue = [path]
        while queue:
            here = queue.pop()
            if here not in self.roots:
                self.roots[here] = parse_root(here, folder)
                queue += [part for element in self.roots[here].iter() for part in self._parts(element, here)]
        for here, root in self.roots.items():
            for element in root.iter("model"):
                for part in self._parts(element, here):
                    name = element.get("name", "") or self.roots[part].get("model", "")
                    self._attached[name].setdefault(here, set()).add(part)
        if (size := self._size(path, ())) > MOST_SHAPES:
            what = f"has {size} elements once all is included, attached and replicated."
            raise InputError(path, what, f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")

    def files(self) -> dict[Path, bytes]:
        """The bytes of every file that the model is made of, by the path that MuJoCo looks for it at.

        Raises:
            InputError: one is missing, or lies outside of the folder.
        """
        elements = [element for root in self.roots.values() for element in root.iter()]
        directories = {""}.union(element.get(key, "") for element in elements for key in DIRECTORIES)
        names = {name for element in elements for name in _names(element)}
        if any(element.get("strippath") == "true" for element in elements):
            names = {name.rpartition("/")[2] for name in names}
        found = {path: read_inside(path, self.folder) for path in self.roots}
        for name in sorted(names):
            places = product(self.roots, sorted(directories))
            if not (files := {file for here, directory in places for file in self._find_file(here, directory, name)}):
                raise explain_missing(self.path, "there is no file", name, self.path.parent, self.folder)
            found |= {file: read_inside(file, self.folder) for file in files - found.keys()}
        return found

    def _parts(self, element: ET.Element, here: Path) -> list[Path]:
        """The XML files that an element includes or names to attach: beside the model, or beside its own file."""
        names = _names(element) if element.tag in ("include", "model") else []
        return [file for name in names for base in (self.path, here) for file in self._find_file(base, "", name)]

    def _find_file(self, here: Path, directory: str, name: str) -> Iterator[Path]:
        """The file of a name in a directory beside a file, if there is one.

        Raises:
            InputError: it lies outside of the folder.
        """
        try:
            file = Path(os.path.normpath(here.parent / directory.replace("\\", "/") / name))
            real = file.resolve()
            exists, is_file = real.exists(), real.is_file()
        except (OSError, RuntimeError, ValueError):  # names that are too long, links in a circle
            return
        if exists and not real.is_relative_to(self.folder.resolve()):
            what = f"names '{name[:200]}', outside of {self.folder.name}/."
            raise InputError(self.path, what, "copy it there", code="E-FILE-OUTSIDE")
        if is_file:
            yield file

    def _size(self, here: Path, above: tuple[Path, ...]) -> int:
        """How many elements a file becomes."""
        if here in above:
            what = f"includes or attaches {here.name}, which includes or attaches it in turn."
            raise InputError(self.path, what, "take one of the two out", code="E-MJCF-REFUSED")
        if here not in self._sizes:
            self._sizes[here] = self._elements(self.roots[here], here, (*above, here))
        return self._sizes[here]

    def _elements(self, element: ET.Element, here: Path, above: tuple[Path, ...]) -> int:
        """How many elements an element becomes, with those in it."""
        parts = set(self._parts(element, here)) if element.tag == "include" else set()
        if element.tag == "attach":  # a model that this file names, or one that includes it
            named = self._attached[element.get("model", "")]
            parts = named.get(here) or set().union(*named.values()).difference(above)
        inside = sum(self._elements(child, here, above) for child in element)
        inside += sum(self._size(part, above) for part in parts)
        counts = [int(word) for word in element.get("count", "").split() if word.isdecimal() and len(word) < 20]
        return 1 + (inside or len(counts) > 0) * prod(counts)  # a grid of flexible parts has none inside


def _names(element: ET.Element) -> list[str]:
    """The files that an element names; all attributes of MJCF that name files begin so."""
    return [value.replace("\\", "/") for key, value in element.attrib.items() if key.startswith("file") and value]


def parse_root(path: Path, folder: Path) -> ET.Element:
    """The root of an MJCF file.

    Raises:
        InputError: it is no XML, or lies outside of the folder.
    """
    try:
        text = read_inside(path, folder).decode("utf-8-sig")
        if "<!DOCTYPE" in text:
            raise InputError(path, "declares a DOCTYPE, which MJCF does not need.", "remove it", code="E-XML-DOCTYPE")
        return ET.fromstring(text.strip(AROUND))
    except (UnicodeDecodeError, ET.ParseError, ValueError) as error:
        raise InputError(path, f"is not XML: {error}.", code="E-XML-BROKEN") from None


def compile_model(path: Path, folder: Path) -> tuple[Any, Any]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of a file.

    Raises:
        InputError: MuJoCo refuses the file, it is a part of a model, or it names files outside `folder`.
    """
    if (tag := parse_root(path, folder).tag) != "mujoco":
        raise InputError(path, f"has <{tag[:40]}> at the top.", "give the file that includes it", code="E-MJCF-PART")
    files = Sources(path, folder).files()
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes MUJOCO_LOG.TXT where the user is
    try:
        with mujoco.MjVfs() as memory, _forbid_disk():
            for file, data in files.items():
                memory[str(file)] = data
            spec = mujoco.MjSpec.from_file(str(path), vfs=memory)
            # Bodies that nothing weighs, as of visual geoms alone, get their masses from their shapes later.
            spec.compiler.boundmass, spec.compiler.boundinertia = MINIMUM_MASS, MINIMUM_INERTIA
            for texture in spec.textures:
                texture.embed = mujoco.mjtEmbed.mjEMBED_TRUE  # else some are left as names, for a viewer to open
            return spec, spec.compile(vfs=memory)
    except Exception as error:  # of MuJoCo's own kinds, by version
        reason = " ".join(str(error).split())[:300]
        raise InputError(path, f"MuJoCo does not take it: {reason}", code="E-MJCF-REFUSED") from None


@contextmanager
def _forbid_disk() -> Iterator[None]:
    """Let nothing in this process open a file: what MuJoCo lacks in memory it would look for on the disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def root_tag(path: Path, folder: Path) -> str | None:
    """Name of the outermost element; empty: there is none; None: the file leads out of the folder, and is not read."""
    if not is_inside(path, folder):
        return None
    try:
        return next((element.tag for _, element in ET.iterparse(path, ["start"])), "")
    except (OSError, ET.ParseError, ValueError):
        return ""
