"""The files that a model's file names, confined to the user's folder; for trimesh, too."""

import os.path
import unicodedata
import warnings
from collections.abc import Callable
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from PIL import EpsImagePlugin, Image
from trimesh.resolvers import Resolver

from roomkin.stages.contracts.errors import InputError, explain


class OutsideError(Exception):
    """The file exists, or would, outside the folder."""


class LinkError(OutsideError):
    """It is in the folder, as a link out of it."""


def find_inside(name: str, here: Path, folder: Path) -> Path | None:
    """The file that a file in `here` names; None: there is none.

    It is looked for in `here` and in the folders above it, up to `folder`; where packages or folders in front of the
    name are called otherwise than in the file (a package that was renamed, a part of a collection), without those; and
    last with small and capital letters alike and accents in either form, as where many files were written.

    Raises:
        OutsideError: it lies, or would lie, outside.
    """
    folder, parts = folder.resolve(), Path(name).parts
    try:
        here = here.resolve()
        bases = [base for base in (here, *here.parents) if base.is_relative_to(folder)]
        spellings: tuple[Callable[..., Path], ...] = (Path.joinpath, _match_spelling)
        endings = [parts[left_out:] for left_out in range(1 if ".." in parts else len(parts))]
        for spelt, ending, base in product(spellings, endings, bases):
            path = spelt(base, *ending)
            found = path.resolve()
            if found.is_file():
                if not found.is_relative_to(folder):
                    raise LinkError if Path(os.path.normpath(path)).is_relative_to(folder) else OutsideError
                return found
        if not (here / name).resolve().is_relative_to(folder):
            raise OutsideError
    except (OSError, RuntimeError, ValueError):  # names that are too long, links in a circle
        pass
    return None


def _match_spelling(base: Path, *parts: str) -> Path:
    """The path below a folder, with letters as they are on disk."""
    for part in parts:
        path = base / part
        if not path.exists() and base.is_dir():
            path = next((child for child in base.iterdir() if _plain(child.name) == _plain(part)), path)
        base = path
    return base


def _plain(name: str) -> str:
    return unicodedata.normalize("NFC", name).lower()


def is_link_out(name: str, here: Path, folder: Path) -> bool:
    """Whether the file that a file in `here` names is a link out of the folder."""
    try:
        find_inside(name, here, folder)
    except OutsideError as error:
        return isinstance(error, LinkError)
    return False


def explain_missing(who: Path, what: str, name: str, here: Path, folder: Path) -> InputError:
    """The complaint of `who` that no such file is in the folder, or only a link out of it; a folder above that has the
    file is named.

    Args:
        what: what names it and what it is, e.g. "link 'door', <visual>: there is no mesh".
    """
    if is_link_out(name, here, folder):
        what = f"{what} '{name[:200]}' in {folder.name}/, but a link out of it."
        return InputError(who, what, "copy there what it links to", code="E-FILE-OUTSIDE")
    folder, fix = folder.resolve(), "copy it there"
    for base in (here.resolve(), *folder.parents):
        try:
            found = (base / name).resolve()
            above = Path(os.path.commonpath([found, folder]))
            if found.is_file() and above not in (folder, Path(above.anchor)):
                fix = f"give {above} in its place, which has it, or copy it there"
                break
        except (OSError, RuntimeError, ValueError):
            break
    return InputError(who, f"{what} '{name[:200]}' in {folder.name}/.", fix, code="E-FILE-MISSING")


EpsImagePlugin.gs_binary = False  # PostScript is a program, and Pillow would have Ghostscript run it
PICTURES = {".bmp", ".gif", ".jpeg", ".jpg", ".png", ".tga", ".tif", ".tiff", ".webp"}


class MeshResolver(Resolver):  # type: ignore[misc]
    """The files that the mesh file `path` names, looked for beside it and above, up to `folder`.

    trimesh goes on without what cannot be read; `lost` says so, a line each. `made`: files that are made up, by name.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder, self.lost, self.made = path, folder, list[str](), dict[str, bytes]()
        self.file_name = path.name  # which trimesh calls nameless meshes by

    def get(self, name: str) -> bytes:
        """The bytes of a file.

        Raises:
            FileNotFoundError: it is not in the folder, or is a picture that cannot be opened.
        """
        if name in self.made:
            return self.made[name]
        found = self.find(name)
        if found is None:
            is_link = any(is_link_out(one, self.path.parent, self.folder) for one in _spellings(name))
            raise self._note_loss(_written(name), f"is {'a link out of' if is_link else 'not in'} {self.folder.name}/")
        data = found.read_bytes()
        if found.suffix.lower() in PICTURES and (fault := fault_of(data)):
            raise self._note_loss(_written(name), fault)
        return data

    def find(self, name: str) -> Path | None:
        """The file of that name; None: it is not in the folder."""
        try:
            found = (find_inside(one, self.path.parent, self.folder) for one in _spellings(name))
            return next(filter(None, found), None)
        except OutsideError:
            return None

    def _note_loss(self, name: str, why: str) -> FileNotFoundError:
        self.lost.append(f"{self.path.name} is shown without '{name[:200]}', which {why}")
        return FileNotFoundError(f"'{name[:200]}' {why}")

    def keys(self) -> list[str]:
        """None are listed."""
        return []

    def write(self, name: str, data: Any) -> None:
        """Nothing is written."""
        raise PermissionError(name)

    def namespaced(self, namespace: str) -> "MeshResolver":
        """The same files."""
        return self


def _spellings(name: str) -> list[str]:
    """A name as it is written, and as it is meant where it is an address."""
    spelt = _written(name).lstrip("/")
    return [spelt, unquote(spelt)]


def _written(name: str) -> str:
    return name.strip().replace("\\", "/")


def fault_of(data: bytes) -> str | None:
    """The reason why a picture cannot be read; None: it can. Pillow says which are too large."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(BytesIO(data)) as picture:
                picture.load()
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        return "is too large"
    except (OSError, ValueError, SyntaxError) as error:
        return f"is no whole picture ({explain(error)})"
    return None
