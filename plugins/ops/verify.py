"""Command `verify`: is every finished file what the run recorded of it?"""

import base64
import json
import re
import shlex
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from stages.contracts.__main__ import parse
from stages.contracts.checksums import digest_of, read_recorded
from stages.contracts.errors import InputError
from stages.contracts.kinds import KINDS

METADATA = Path(".snakemake/metadata")  # beside results/: what Snakemake knows of each output
CHECK = re.compile(r"python -m stages\.contracts --refuse ([^&|)]+)")


def run(*, results: Path = Path("results")) -> None:
    """Hold finished files against the checksums that were recorded when they were written, and those that have none
    against their contracts. Prints what is broken and the command that makes it anew.

    Args:
        results: the folder `results` of a run.

    Raises:
        InputError: something is broken, or there is nothing to look at.
    """
    known = dict(sorted(read_metadata(results.parent / METADATA)))
    files = sorted(path for path in results.rglob("*") if path.is_file() and is_result(path, results))
    if not files:
        raise InputError(results, "holds no finished file.", "--results: the folder of a run", code="E-FILE-MISSING")
    recorded = {path: read_recorded(path, results) for path in files}
    unrecorded = {path for path, digest in recorded.items() if digest is None}
    faults = {path: "differs from its checksum" for path in files if recorded[path] not in (None, digest_of(path))}
    faults |= check_contracts(known.values(), unrecorded, results.parent)
    gone = [name for name in known if not (results.parent / name).exists()]
    notes = [f"{results}: {len(files) - len(unrecorded)} files with a checksum, {len(unrecorded)} without"]
    if unrecorded:
        names = ", ".join(path.relative_to(results).as_posix() for path in sorted(unrecorded))
        notes.append(f"note: without a checksum, so a change may go unseen: {names}")
    if gone:
        notes.append(f"note: no longer there, so a run makes them again where it needs them: {', '.join(gone)}")
    print("\n".join(notes), file=sys.stderr)
    if faults:
        lines = "".join(f"\n  {path}: {what}" for path, what in faults.items())
        outputs = shlex.join(dict.fromkeys(find_output(path.relative_to(results.parent), known) for path in faults))
        fix = f"snakemake --cores 2 --force {outputs}   (with the --configfile of the run), then the run again"
        raise InputError(results, f"{len(faults)} broken:{lines}", fix, code="E-RESULT-CHANGED")


def is_result(path: Path, results: Path) -> bool:
    """Whether a file is one that a run left: no checksum, nothing half-written, nothing set aside."""
    return not any(part.startswith(".") for part in path.relative_to(results).parts) and path.suffix != ".refused"


def read_metadata(folder: Path) -> Iterator[tuple[str, str]]:
    """Outputs, below the folder of a run, and the command lines that made them, as Snakemake keeps them."""
    for path in folder.rglob("*"):
        if path.is_file():  # long names are cut into folders that begin with @
            name = "".join(part.removeprefix("@") for part in path.relative_to(folder).parts)
            kept = json.loads(path.read_text(encoding="utf-8"))
            yield base64.urlsafe_b64decode(name).decode(), kept.get("shellcmd") or ""


def check_contracts(lines: Iterable[str], unrecorded: set[Path], folder: Path) -> dict[Path, str]:
    """What is wrong with files without a checksum, by the checks that their rules run; `folder`: that of the run."""
    faults = {}
    pairs = [pair for line in lines for words in CHECK.findall(line) for pair in parse(shlex.split(words))]
    for kind, name in dict.fromkeys(pairs):
        path = folder / name
        if not unrecorded.isdisjoint(KINDS[kind].files(path)):
            try:
                KINDS[kind].check(path)
            except InputError as error:
                faults[path] = str(error)
    return faults


def find_output(path: Path, known: dict[str, str]) -> str:
    """What Snakemake calls the output that a file belongs to: itself, its folder, or the file that it lies beside."""
    names = [path.as_posix(), *(parent.as_posix() for parent in path.parents)]
    beside = [name for name in known if Path(name).parent == path.parent]
    return next((name for name in names if name in known), beside[0] if beside else names[0])
