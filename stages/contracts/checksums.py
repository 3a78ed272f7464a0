"""Checksums of finished results: what `python -m plugins.ops verify` holds them against.

One small file for each, in a tree of its own: results/.checksums/<path below results>.
"""

import hashlib
import re
import shutil
from pathlib import Path

RESULTS = Path("results")  # of the working directory, which is that of the workflow in its jobs
CHECKSUMS = ".checksums"


def digest_of(path: Path) -> str:
    """SHA-256 of a file, as hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def record_of(path: Path, results: Path = RESULTS) -> Path | None:
    """Where the checksum of a result is; None: the path is no result, or not yet one."""
    results = results.absolute()
    path = path.absolute()
    if not path.is_relative_to(results) or any(part.startswith(".") for part in path.relative_to(results).parts):
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


def read_recorded(path: Path, results: Path = RESULTS) -> str | None:
    """The checksum that was recorded of a result; None: none, or only a part of one, as after a power cut."""
    found = record_of(path, results)
    text = found.read_bytes() if found and found.is_file() else b""
    return text.decode().strip() if re.fullmatch(rb"[0-9a-f]{64}\n", text) else None
