"""Command `merge`: the rollouts of all policies of one training set in one table."""

from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_rows
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.evaluation.states import write_rows


def run(*, rollouts: tuple[Path, ...], out: Path) -> None:
    """Put the rows of several policies one after the other.

    Args:
        rollouts: rollouts.csv of every policy.
        out: the table, of the same columns.
    """
    rows = [row for path in rollouts for row in read_rows(Rollout, path, "run `evaluation rollout` again")]
    if len({(row.target, row.policy, row.training_set) for row in rows}) > 1:
        raise InputError("--rollouts", "are of more than one target, policy and training set.", code="E-ROLLOUTS-MIXED")
    write_rows(out, rows)
