"""Zip archives that stand for folders: a rule declares one file, and who reads it unpacks what it needs."""

import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path, PurePosixPath

from roomkin.stages.contracts.errors import InputError, file_missing
from roomkin.stages.contracts.files import write_atomically

UNREADABLE = (OSError, zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError)  # what zipfile raises


def pack(folder: Path, out: Path) -> None:
    """Write all files below `folder` into a zip archive, by name and undated: the same files make the same bytes."""
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    with write_atomically(out) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in sorted(files):
            about = zipfile.ZipInfo(name)  # of 1980
            about.external_attr = 0o644 << 16
            archive.writestr(about, files[name].read_bytes(), zipfile.ZIP_DEFLATED, compresslevel=1)


def unpack(path: Path, fix: str, below: str = "") -> Path:
    """A folder with the files of an archive, or with those whose names begin with `below`, until the process ends.

    Raises:
        InputError: it is no archive, is damaged, or a name leads out of it.
    """
    with open_archive(path, fix) as archive:
        names = [name for name in archive.namelist() if name.startswith(below) and not name.endswith("/")]
        content = {name: archive.read(name) for name in names}
    folder = Path(tempfile.mkdtemp(dir=_scratch().name))
    for name in names:
        if ".." in PurePosixPath(name).parts or PurePosixPath(name).is_absolute():
            raise InputError(path, f"holds '{name}', which leads out of it.", fix, code="E-ARCHIVE-UNSAFE")
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content[name])
    return folder


@contextmanager
def open_archive(path: Path, fix: str) -> Iterator[zipfile.ZipFile]:
    """An archive, opened once for whoever reads it again; what is wrong with it becomes an `InputError`."""
    try:
        yield _open_zip(path, path.stat().st_mtime_ns)
    except FileNotFoundError:
        raise file_missing(path, fix) from None
    except UNREADABLE as error:
        what = f"is no zip archive that can be read ({error})."
        raise InputError(path, what, fix, code="E-FILE-UNREADABLE") from None


@cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="acdc-unpacked-")


@lru_cache
def _open_zip(path: Path, changed: int) -> zipfile.ZipFile:
    return zipfile.ZipFile(path)
