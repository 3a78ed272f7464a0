"""Find and read the files that a model's file names, confined to the user's folder."""

import os.path
import stat
from collections.abc import Callable
from itertools import product
from pathlib import Path

from stages.contracts.arrays import MAX_BYTES
from stages.contracts.errors import InputError


class OutsideError(Exception):
    """The file exists, or would, outside the folder."""


def find_inside(name: str, here: Path, folder: Path) -> Path | None:
    """The file that a file in `here` names; None: there is none.

    It is looked for in `here` and in the folders above it, up to `folder`; where packages or folders in front of the
    name are called otherwise than in the file (a package that was renamed, a part of a collection), without those; and
    last with small and capital letters alike, as on the systems where many files were written.

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
            found = spelt(base, *ending).resolve()
            if found.is_file():
                if not found.is_relative_to(folder):
                    raise OutsideError
                return found
        if not (here / name).resolve().is_relative_to(folder):
            raise OutsideError
    except (OSError, RuntimeError, ValueError):  # names that are too long, links in a circle
        pass
    return None


def check_inside(path: Path, folder: Path) -> None:
    """Refuse what is no file of the user's folder, before anybody opens it.

    Raises:
        InputError: it is not there, leads out of the folder, or is a pipe, a device or the like.
    """
    try:
        outside, kind = not path.resolve().is_relative_to(folder.resolve()), path.stat().st_mode
    except FileNotFoundError:
        raise InputError(path, "no such file.", code="E-FILE-MISSING") from None
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, among others
        raise InputError(path, f"cannot be read ({type(error).__name__}).", code="E-FILE-UNREADABLE") from None
    if outside:
        raise InputError(path, f"is a link out of {folder.name}/.", "copy it inside", code="E-FILE-OUTSIDE")
    if not stat.S_ISREG(kind):  # nobody may ever write to a pipe, and a device has no end
        raise InputError(path, "is no file that can be read.", code="E-FILE-UNREADABLE")


def is_inside(path: Path, folder: Path) -> bool:
    """Whether it is a file of the user's folder, which may be opened."""
    try:
        check_inside(path, folder)
    except InputError:
        return False
    return True


def read_inside(path: Path, folder: Path, most: int = MAX_BYTES) -> bytes:
    """The bytes of a file of the user's folder.

    Raises:
        InputError: as `check_inside`, or it is larger than `most` bytes, or cannot be read.
    """
    check_inside(path, folder)
    try:
        if path.stat().st_size > most:
            raise InputError(path, f"is larger than {most / 1e6:g} MB.", code="E-FILE-LARGE")
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({type(error).__name__}).", code="E-FILE-UNREADABLE") from None


def _match_spelling(base: Path, *parts: str) -> Path:
    """The path below a folder, with small and capital letters as they are on disk."""
    for part in parts:
        path = base / part
        if not path.exists() and base.is_dir():
            path = next((child for child in base.iterdir() if child.name.lower() == part.lower()), path)
        base = path
    return base


def explain_missing(who: Path, what: str, name: str, here: Path, folder: Path) -> InputError:
    """The complaint of `who` that no such file is in the folder; a folder above that has the file is named.

    Args:
        what: what names it and what it is, e.g. "link 'door', <visual>: there is no mesh".
    """
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
