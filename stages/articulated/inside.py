"""Find the files that a model's file names, confined to the user's folder."""

import os.path
import unicodedata
from collections.abc import Callable
from itertools import product
from pathlib import Path

from roomkin.stages.contracts.errors import InputError


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
