"""Refusals of the operating system, in one line; and what it has to have on the disk before a file is finished."""

import contextlib
import errno
import fcntl
import importlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from roomkin.stages.contracts.errors import InputError

MENDS = {
    errno.ENOSPC: "make room on the disk, and run it again", errno.EDQUOT: "make room in your quota, and run it again",
    errno.EROFS: "choose a folder that can be written",
    errno.EACCES: "choose a folder that you may use, or change its permissions",
    errno.EPERM: "choose a folder that you may use, or change its permissions", errno.EIO: "is there room on the disk?",
    errno.EMFILE: "raise the limit of open files: ulimit -n",
}  # fmt: skip
JOB_START = "ACDC_JOB_START"  # environment variable, module:function: what every job of a workflow calls first
FULL_MEMORY = ("allocate memory", "out of memory", "Insufficient memory")  # of torch, CUDA, OpenCV


def start_job() -> None:
    """Call what the workflow that started this process has its jobs call; nothing for a process started by hand."""
    module, _, function = os.environ.get(JOB_START, "").partition(":")
    if module:
        getattr(importlib.import_module(module), function)()


def line_of(error: Exception) -> str | None:
    """The refusal as a line: the file, why, how to mend it. None for errors of another kind."""
    if isinstance(error, MemoryError) or any(words in str(error) for words in FULL_MEMORY):
        fix = "run fewer jobs at once (--cores), or with smaller options"
        reported = InputError("", "out of memory.", fix, code="E-SYSTEM-MEMORY")
    elif isinstance(error, OSError):
        number = errno.ENOSPC if "No space left" in str(error) else error.errno
        reason = os.strerror(number) if number else " ".join(str(error).split())[:200]
        reported = InputError(error.filename or "", f"{reason}.", MENDS.get(number or 0, ""), code="E-SYSTEM")
    else:
        return None
    return f"{reported} [{reported.code}]"


@contextlib.contextmanager
def name_file_in_errors(path: Path, temporary: Path | None = None) -> Iterator[None]:
    """Let errors of the operating system name `path`, which those of writing do not, nor those of HDF5 and torch."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        full = "No space left" in str(error) or (isinstance(error, RuntimeError) and _is_full(path))
        if full or (isinstance(error, OSError) and error.filename in (None, str(temporary))):
            gone = isinstance(error, FileNotFoundError)  # OpenCV takes away what it cannot write, without a word
            code = errno.ENOSPC if full else _explain_unwritten(path) if gone else getattr(error, "errno", None)
            if code:
                raise OSError(code, os.strerror(code), str(path)) from error
        raise


def _explain_unwritten(path: Path) -> int:
    """The error of writing a file beside a path; that of the disk if it can be written."""
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            return errno.EIO
    except OSError as error:
        return error.errno or errno.EIO


def _is_full(path: Path) -> bool:
    """Whether the disk has no room for another block."""
    try:
        found = os.statvfs(path.parent)
    except OSError:
        return False
    return found.f_blocks > 0 and found.f_bavail == 0


def check_writable(*folders: Path) -> None:
    """Refuse folders that nothing can be written into, before a workflow starts. What is not there yet will be made.

    Raises:
        InputError: names the first.
    """
    for folder in folders:
        if folder.exists() and not os.access(folder, os.W_OK | os.X_OK):
            mend = "choose a folder that can be written, or change its permissions"
            raise InputError(folder, "cannot be written into.", mend, code="E-FOLDER-READ-ONLY")


@contextlib.contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Keep out all others who lock a folder, where its filesystem has locks; it is made if it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def sync(path: Path) -> None:
    """Wait until a file, or a folder and all in it, is on the disk: only then a power cut leaves it whole."""
    for each in [path, *path.rglob("*")] if path.is_dir() else [path]:
        descriptor = os.open(each, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def sync_names(folder: Path) -> None:
    """The same of the names in a folder, where the filesystem can do that."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
