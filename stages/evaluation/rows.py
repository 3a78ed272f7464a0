"""Rows of `evaluation` on disk."""

import csv
from collections.abc import Sequence
from pathlib import Path

from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.policies import Rollout


def write_rows(path: Path, rows: Sequence[Rollout]) -> None:
    """Write rows as a CSV table."""
    with write_atomically(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, Rollout.model_fields, lineterminator="\n")
        table.writeheader()
        table.writerows(row.model_dump() for row in rows)
