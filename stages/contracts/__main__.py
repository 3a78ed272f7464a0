"""Check files against their contracts: `roomkin contracts [--refuse] KIND FILE... [KIND FILE...]`.

The workflow runs it after every stage, so that a stage replaced by the user's own command is held to the
same contract; the files beside a file that belong to its contract are checked too. Exit code 1 and one line
naming file and field if a file breaks it. With `--refuse` all files of the command are then renamed to
`<name>.refused`: they are no result, but they are not lost either; of files that keep it the checksums are recorded,
as the user's own command does not.
"""

import sys
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import forget, record
from roomkin.stages.contracts.kinds import KINDS
from roomkin.stages.contracts.system import line_of

REFUSED = ".refused"


def parse(arguments: list[str]) -> list[tuple[str, Path]]:
    """Pairs of kind and file; a kind holds for all files up to the next kind.

    Raises:
        ValueError: a file comes before any kind, or a kind without a file.
    """
    kind, pairs = None, []
    for argument in arguments:
        if argument in KINDS:
            if kind and (not pairs or pairs[-1][0] != kind):
                break
            kind = argument
        elif kind is None:
            raise ValueError(f"'{argument}' is no kind of file. Known kinds: {', '.join(KINDS)}")
        else:
            pairs.append((kind, Path(argument)))
    if not pairs or pairs[-1][0] != kind:
        raise ValueError(f"'{kind}' comes without a file." if kind else "name a kind of file, then files.")
    return pairs


def list_files(pairs: list[tuple[str, Path]]) -> dict[Path, None]:
    """The files and their companions, each once."""
    return dict.fromkeys(path for kind, file in pairs for path in KINDS[kind].files(file))


def set_aside(pairs: list[tuple[str, Path]]) -> list[Path]:
    """Rename the files and their companions; returns the new paths."""
    kept = []
    for path in list_files(pairs):
        forget(path)
        kept.append(path.replace(path.with_name(path.name + REFUSED)))
    return kept


def main(arguments: list[str]) -> int:
    """Check every file named; returns the exit code."""
    refuse = "--refuse" in arguments
    try:
        pairs = parse([argument for argument in arguments if argument != "--refuse"])
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    try:
        for kind, path in pairs:
            KINDS[kind].check(path)
        for path in list_files(pairs) if refuse else []:
            record(path)
    except OSError as error:
        print(f"error: {line_of(error)}", file=sys.stderr)
        return 1
    except InputError as error:
        try:
            kept = set_aside(pairs) if refuse else []
        except OSError as refused:
            kept = []
            print(f"error: {line_of(refused)}", file=sys.stderr)
        where = f" Kept as {kept[0]}" + (f" and {len(kept) - 1} more *{REFUSED}" if kept[1:] else "") if kept else ""
        print(f"error: {error}{where} [{error.code}]", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
