"""Check files against their contracts: `python -m stages.contracts KIND FILE... [KIND FILE...]`.

The workflow runs it after every stage, so that a stage replaced by the user's own command is
held to the same contract. Exit code 1 and one line naming file and field if a file breaks it.
"""

import csv
import sys
from collections.abc import Callable
from pathlib import Path

from pydantic import BaseModel, ValidationError

from stages.contracts import (
    Annotations,
    Attempt,
    Camera,
    Cousins,
    GeneratedScene,
    InputError,
    Library,
    Objects,
    Rollout,
    SceneScore,
    SnapshotShard,
    TaskAssets,
    Truth,
)
from stages.contracts.distances import Distances
from stages.contracts.files import first_error, read_json, read_text


def json_file(model: type[BaseModel]) -> Callable[[Path], object]:
    """Checker of a file that is one JSON document."""
    return lambda path: read_json(model, path)


def json_lines(model: type[BaseModel]) -> Callable[[Path], object]:
    """Checker of a file with one JSON document per line."""

    def check(path: Path) -> None:
        for number, line in enumerate(read_text(path).splitlines(), 1):
            try:
                model.model_validate_json(line)
            except ValidationError as error:
                raise InputError(
                    f"{path}:{number}", f"breaks the {model.__name__} contract at {first_error(error)}."
                ) from None

    return check


def csv_file(model: type[BaseModel]) -> Callable[[Path], object]:
    """Checker of a CSV table whose columns are the model's fields; an empty cell is null."""

    def check(path: Path) -> None:
        for number, row in enumerate(csv.DictReader(read_text(path).splitlines()), 2):
            try:
                model.model_validate({key: None if value == "" else value for key, value in row.items()})
            except ValidationError as error:
                raise InputError(
                    f"{path}:{number}", f"breaks the {model.__name__} contract at {first_error(error)}."
                ) from None

    return check


KINDS: dict[str, Callable[[Path], object]] = {
    "library": json_file(Library),
    "snapshots": json_file(SnapshotShard),
    "camera": json_file(Camera),
    "annotations": json_file(Annotations),
    "truth": json_file(Truth),
    "objects": json_file(Objects),
    "cousins": json_file(Cousins),
    "distances": json_file(Distances),
    "generated": json_file(GeneratedScene),
    "task": json_file(TaskAssets),
    "attempts": json_lines(Attempt),
    "rollouts": csv_file(Rollout),
    "scores": csv_file(SceneScore),
}


def main(arguments: list[str]) -> int:
    """Check every file named; returns the exit code."""
    check = None
    for argument in arguments:
        if argument in KINDS:
            check = KINDS[argument]
        elif check is None:
            print(f"error: '{argument}' is no kind of file. Known kinds: {', '.join(KINDS)}", file=sys.stderr)
            return 2
        else:
            try:
                check(Path(argument))
            except InputError as error:
                print(f"error: {error}", file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
