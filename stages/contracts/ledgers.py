"""Files with one JSON document per line: attempts.jsonl of demonstrations, metrics.jsonl of training."""

from itertools import pairwise
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_lines
from roomkin.stages.contracts.policies import Attempt
from roomkin.stages.contracts.trained import MetricsLine

COLLECT, TRAIN = "collect the demonstrations again", "train the policy again"


def read_attempts(path: Path) -> list[Attempt]:
    """attempts.jsonl: numbered from 0 without gaps, and so are the episodes that were kept.

    Raises:
        InputError: it is missing or empty, or a line is broken or out of order.
    """
    attempts = read_lines(Attempt, path, COLLECT)
    kept = 0
    for number, attempt in enumerate(attempts):
        if attempt.attempt != number:
            raise InputError(
                f"{path}:{number + 1}", f"attempt: is {attempt.attempt}, not {number}.", COLLECT, code="E-LEDGER-ORDER"
            )
        if attempt.episode is not None:
            if attempt.episode != kept or not attempt.success:
                why = f"{kept} successes were kept before" if attempt.success else "the attempt did not succeed"
                what = f"episode: is {attempt.episode}, but {why}."
                raise InputError(f"{path}:{number + 1}", what, COLLECT, code="E-LEDGER-ORDER")
            kept += 1
    return attempts


def read_metrics(path: Path) -> list[dict[str, float | None]]:
    """The lines of metrics.jsonl: finite numbers by name, among them a growing `step`.

    Raises:
        InputError: it is missing or empty, or a line is broken (file and line named).
    """
    lines = [line.root for line in read_lines(MetricsLine, path, TRAIN)]
    for number, (one, next) in enumerate(pairwise(lines), 2):
        if next["step"] <= one["step"]:  # type: ignore[operator]
            raise InputError(
                f"{path}:{number}", f"step: {next['step']} comes after {one['step']}.", TRAIN, code="E-LEDGER-ORDER"
            )
    return lines
