"""Command `verify`: which finished files are no longer what the run recorded, and what makes them anew."""

import base64
import os
import re
import shlex
import stat
import sys
from collections.abc import Iterable, Mapping
from itertools import accumulate
from pathlib import Path

from pydantic import BaseModel

from roomkin.stages.contracts.__main__ import parse
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.contracts.files import digest_of, read_recorded
from roomkin.stages.contracts.kinds import KINDS
from roomkin.stages.contracts.system import line_of

METADATA = Path(".snakemake/metadata")  # beside results/: what Snakemake knows of each output
MOST = 800_000_000  # bytes that are looked at when a run starts: takes a second
NAMED = 3  # files at most that a line names


class KeptOutput(BaseModel):
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
            found[output] = KeptOutput.model_validate_json(path.read_bytes()).shellcmd or ""
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


CHECK = re.compile(r"python -m (?:roomkin\.)?stages\.contracts --refuse ([^&|)]+)")  # without: of older runs


def run(*, results: Path = Path("results")) -> None:
    """Hold finished files against the checksums that were recorded when they were written, and those that have none
    against their contracts. Prints what is broken and the command that makes it anew.

    Args:
        results: the folder `results` of a run; if it has nothing, that of `make demo` beside it.

    Raises:
        InputError: something is broken, or there is nothing to look at.
    """
    places = results, results.parent / "demo" / results.name
    results = next((place for place in places if any(list_files(place))), results)
    known, lost = read_metadata(results.parent / METADATA)
    files, faults = list_files(results)
    if not files and not faults:
        raise InputError(results, "holds no finished file.", "--results: the folder of a run", code="E-FILE-MISSING")
    recorded = {path: read_recorded(path, results) for path in files}
    unrecorded = {path for path, digest in recorded.items() if digest is None}
    faults |= find_changed(recorded)
    faults |= check_contracts(known.values(), unrecorded, results.parent)
    gone = [name for name in known if not (results.parent / name).exists()]
    notes = [f"{results}: {len(files) - len(unrecorded)} files with a checksum, {len(unrecorded)} without"]
    if unrecorded:
        names = ", ".join(path.relative_to(results).as_posix() for path in sorted(unrecorded))
        notes.append(f"note: without a checksum, so a change may go unseen: {names}")
    if gone:
        notes.append(f"note: no longer there, so a run makes them again where it needs them: {', '.join(gone)}")
    if lost:
        notes.append(f"note: broken, so what made some files is not known; remove them: {', '.join(map(str, lost))}")
    print("\n".join(map(escape_control, notes)), file=sys.stderr)
    if faults:
        lines = "".join(f"\n  {path}: {what}" for path, what in faults.items())
        fix = mend([path.relative_to(results.parent) for path in faults], known)
        raise InputError(results, f"{len(faults)} broken:{lines}", fix, code="E-RESULT-CHANGED")


def check_contracts(lines: Iterable[str], unrecorded: set[Path], folder: Path) -> dict[Path, str]:
    """What is wrong with files without a checksum, by the checks that their rules run; `folder`: that of the run."""
    faults = {}
    for kind, name in dict.fromkeys(pair for line in lines for pair in list_checked(line)):
        path = folder / name
        try:
            if not unrecorded.isdisjoint(KINDS[kind].files(path)):
                KINDS[kind].check(path)
        except InputError as error:
            faults[path] = str(error)
        except OSError as error:
            faults[path] = str(line_of(error))
    return faults


def list_checked(line: str) -> list[tuple[str, Path]]:
    """Kinds and files that a rule's command line checks; none of one that was damaged."""
    try:
        return [pair for words in CHECK.findall(line) for pair in parse(shlex.split(words))]
    except ValueError:
        return []
