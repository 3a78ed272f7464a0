"""Rows of `evaluation` on disk."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from stages.contracts.files import write_atomically
from stages.contracts.policies import Rollout


def write_rows(path: Path, rows: Sequence[Rollout]) -> None:
    """Write rows as a CSV table."""
    with write_atomically(path) as temporary:
        pd.DataFrame([row.model_dump() for row in rows]).to_csv(temporary, index=False)
