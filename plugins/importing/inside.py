"""Read the files of the user's folder, and no others."""

import stat
from pathlib import Path

from roomkin.stages.contracts.arrays import MAX_BYTES
from roomkin.stages.contracts.errors import InputError, explain, file_missing
from roomkin.stages.contracts.files import MAX_TEXT


def check_inside(path: Path, folder: Path) -> None:
    """Refuse what is no file of the user's folder, before anybody opens it.

    Raises:
        InputError: it is not there, leads out of the folder, or is a pipe, a device or the like.
    """
    try:
        outside, kind = not path.resolve().is_relative_to(folder.resolve()), path.stat().st_mode
    except FileNotFoundError:
        raise file_missing(path) from None
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, among others
        raise InputError(path, f"cannot be read ({explain(error)}).", code="E-FILE-UNREADABLE") from None
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
        raise InputError(path, f"cannot be read ({explain(error)}).", code="E-FILE-UNREADABLE") from None


def read_text_inside(path: Path, folder: Path) -> bytes:
    """What is in a file of text of the user's folder; nothing if it cannot be read: the import reports it."""
    try:
        return read_inside(path, folder, MAX_TEXT)
    except InputError:
        return b""
