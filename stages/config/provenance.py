"""The provenance of a file, to be kept in it: the same code, options, inputs and seed give the same bytes."""

import hashlib
from collections.abc import Iterable
from pathlib import Path
from zipfile import ZipFile, is_zipfile

from pydantic import BaseModel

from roomkin.stages.config.code import code_digest
from roomkin.stages.contracts.doubt import Provenance


def record_provenance(module: str, options: BaseModel, inputs: Iterable[Path], seed: int | None = None) -> Provenance:
    """Digests of a command's code, options and inputs.

    Args:
        module: the command's, with all that it imports.
        options: as the command takes them, defaults filled in.
        inputs: files that it reads, by content.
        seed: of the random numbers behind it, its own or its inputs'; None: none.
    """
    digest = hashlib.sha256()
    for path in inputs:
        digest.update(hashlib.sha256(content(path)).digest())
    own = hashlib.sha256(options.model_dump_json().encode()).hexdigest()
    return Provenance(seed=seed, options=own[:12], inputs=digest.hexdigest()[:12], code=code_digest(module))


def content(path: Path) -> bytes:
    """A file's bytes; of NumPy's archives those of the arrays, as their headers are of Python's own version."""
    if path.suffix != ".npz" or not is_zipfile(path):
        return path.read_bytes()
    with ZipFile(path) as archive:
        return b"".join(name.encode() + archive.read(name) for name in archive.namelist())
