"""Finished files of a run: which there are, which are no longer what was written, and what makes them anew."""

import base64
import os
import shlex
import stat
import sys
from collections.abc import Iterable, Mapping
from itertools import accumulate
from pathlib import Path

from pydantic import BaseModel

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import digest_of, read_recorded

METADATA = Path(".snakemake/metadata")  # beside results/: what Snakemake knows of each output
MOST = 800_000_000  # bytes that are looked at when a run starts: takes a second
NAMED = 3  # files at most that a line names


class Kept(BaseModel):
    """What Snakemake keeps of an output, as far as it is read here."""

    shellcmd: str | None = None


def list_files(folder: Path) -> tuple[dict[Path, int], dict[Path, str]]:
    """The files that a run left in a folder, by name, with their sizes; and what in there cannot be looked at, and why.

    Nothing hidden, as checksums are, nothing half-written, nothing set aside.
    """
    found, unread = dict[Path, int](), dict[Path, str]()

    def note(error: OSError) -> None:
        if not isinstance(error, FileNotFoundError):
            unread[Path(error.filename)] = _explain(error)

    for place, folders, names in os.walk(folder, onerror=note):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for path in (Path(place, name) for name in names if not name.startswith(".") and not name.endswith(".refused")):
            try:
                status = path.stat()
            except OSError as error:
                note(error)
                continue
            if stat.S_ISREG(status.st_mode):
                found[path] = status.st_size
    return dict(sorted(found.items())), unread


def _explain(error: OSError) -> str:
    return f"cannot be read ({error.strerror})"


def find_changed(recorded: Mapping[Path, str | None]) -> dict[Path, str]:
    """What is wrong with files, held against their checksums; None: it has none."""
    known = {path: digest for path, digest in recorded.items() if digest is not None}
    return {path: fault for path, digest in known.items() if (fault := _fault_of(path, digest))}


def _fault_of(path: Path, recorded: str) -> str:
    try:
        return "" if digest_of(path) == recorded else "differs from its checksum"
    except FileNotFoundError:
        return ""  # Snakemake sees what is gone
    except OSError as error:
        return _explain(error)


def read_metadata(folder: Path) -> tuple[dict[str, str], list[Path]]:
    """Outputs, below the folder of a run, with the command lines that made them, as Snakemake keeps them; and the files
    of it that cannot be read, as a power cut leaves them."""
    files, unread = list_files(folder)
    found, broken = dict[str, str](), list(unread)
    for path in files:
        try:  # long names are cut into folders that begin with @
            name = "".join(part.removeprefix("@") for part in path.relative_to(folder).parts)
            output = base64.b64decode(name, altchars=b"-_", validate=True).decode()
            found[output] = Kept.model_validate_json(path.read_bytes()).shellcmd or ""
        except (OSError, ValueError):
            broken.append(path)
    return dict(sorted(found.items())), broken


def mend(paths: Iterable[Path], known: Mapping[str, str]) -> str:
    """The command that makes files anew, by their paths from the folder of the run; `known`: of `read_metadata`."""
    outputs = dict.fromkeys(_find_output(path, known) for path in paths)
    return f"snakemake --cores 2 --force {shlex.join(outputs)}   (with the --configfile of the run), then the run again"


def _find_output(path: Path, known: Mapping[str, str]) -> str:
    """What Snakemake calls the output that a file belongs to: itself, its folder, or the file that it lies beside."""
    names = [path.as_posix(), *(parent.as_posix() for parent in path.parents)]
    beside = [name for name in known if Path(name).parent == path.parent]
    return next((name for name in names if name in known), beside[0] if beside else names[0])


def list_for_run(results: Path) -> list[Path]:
    """The finished files that are looked at when a run starts, so that it takes a second: where all are more than
    `MOST` bytes the largest are left out, at which `verify` looks, too."""
    sizes = dict(sorted(list_files(results)[0].items(), key=lambda each: each[1]))
    return [path for path, so_far in zip(sizes, accumulate(sizes.values()), strict=True) if so_far <= MOST]


def warn_of_changed(files: Iterable[Path], results: Path) -> list[Path]:
    """Say in one line which finished files are no longer what was written, since Snakemake compares times alone."""
    changed = sorted(find_changed({path: read_recorded(path, results) for path in files}))
    if changed:
        named = [path.relative_to(results.parent) for path in changed[:NAMED]]
        more = f" and {len(changed) - NAMED} more, which `make verify` names" if changed[NAMED:] else ""
        what = f"no longer what was written: {', '.join(map(str, named))}{more}."
        fix = mend(named, read_metadata(results.parent / METADATA)[0])
        error = InputError(results, what, fix, code="E-RESULT-CHANGED")
        print(f"warning: {error} [{error.code}]", file=sys.stderr)
    return changed
