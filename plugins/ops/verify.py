"""Command `verify`: is every finished file what the run recorded of it?"""

import re
import shlex
import sys
from collections.abc import Iterable
from pathlib import Path

from roomkin.plugins.ops.finished import METADATA, find_changed, list_files, mend, read_metadata
from roomkin.stages.contracts.__main__ import parse
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.contracts.files import read_recorded
from roomkin.stages.contracts.kinds import KINDS
from roomkin.stages.contracts.system import line_of

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
