"""Checksums of finished results: what `roomkin ops verify` holds them against.

One small file for each, in a tree of its own: results/.checksums/<path below results>.
"""

import hashlib
import os
import re
import shutil
from pathlib import Path

RESULTS = Path("results")  # of the working directory, which is that of the workflow in its jobs
CHECKSUMS = ".checksums"


def digest_of(path: Path) -> str:
    """SHA-256 of a file, as hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def find_results(path: Path) -> Path | None:
    """The results that a path lies in, from wherever it is written: the nearest folder above it that has checksums, or
    is `results` of the working directory."""
    own = RESULTS.absolute()
    return next((each for each in path.parents if each == own or (each / CHECKSUMS).is_dir()), None)


def record_of(path: Path, results: Path | None = None) -> Path | None:
    """Where the checksum of a result is; None: the path is no result, or not yet one. `results`: None finds them."""
    path = Path(os.path.normpath(path.absolute()))
    results = results.absolute() if results else find_results(path)
    if results is None or any(part.startswith(".") for part in path.relative_to(results).parts):
        return None
    return results / CHECKSUMS / path.relative_to(results)


def forget(path: Path) -> None:
    """Remove the checksum of a result, or those of a folder, about to change: a kill in between leaves no wrong one."""
    found = record_of(path)
    if found and found.is_dir():
        shutil.rmtree(found)
    elif found:
        found.unlink(missing_ok=True)


def record(path: Path) -> None:
    """Write down the checksum of a finished result, or of each file of a folder; nothing for other files."""
    for file in filter(Path.is_file, path.rglob("*") if path.is_dir() else [path]):
        if found := record_of(file):
            found.parent.mkdir(parents=True, exist_ok=True)
            found.write_text(f"{digest_of(file)}\n", encoding="ascii")


def read_recorded(path: Path, results: Path | None = None) -> str | None:
    """The checksum that was recorded of a result; None: none, or none that can be read, as after a power cut."""
    found = record_of(path, results)
    try:
        text = found.read_bytes() if found and found.is_file() else b""
    except OSError:
        return None
    return text.decode().strip() if re.fullmatch(rb"[0-9a-f]{64}\n", text) else None
