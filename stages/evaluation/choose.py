"""Command `choose`: the policy configs that are trained with all seeds, by their rollouts on the twin (paper B.4)."""

import sys
from collections.abc import Sequence
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_rows, write_json
from roomkin.stages.contracts.policies import ChosenRuns, Rollout, RunScore


def best_checkpoint(rows: Sequence[Rollout]) -> RunScore:
    """The checkpoint with most successes; of equals the later one."""
    scores: dict[str, list[bool]] = {}
    for row in rows:
        scores.setdefault(row.checkpoint, []).append(row.success)
    best = max(reversed(scores), key=lambda name: sum(scores[name]))
    return RunScore(run=rows[0].run, checkpoint=best, successes=sum(scores[best]), episodes=len(scores[best]))


def run(*, rollouts: tuple[Path, ...], count: int, out: Path) -> None:
    """Name the best policy configs of one cell; of equals those given first.

    Args:
        rollouts: rollouts.csv of every candidate's selection rollouts, all from the same initial states.
        count: how many to choose.
        out: chosen.json (contract ChosenRuns).
    """
    rows = {path: read_rows(Rollout, path, "run `evaluation selection-rollout` again") for path in rollouts}
    about = {(row.target, row.policy, row.training_set) for each in rows.values() for row in each}
    states = {tuple(dict.fromkeys(row.initial_state for row in each)) for each in rows.values()}
    if len(about) != 1 or len(states) != 1:
        what = "are not of one target, policy and training set from the same states."
        raise InputError("--rollouts", what, "run them again", code="E-SELECTION-MIXED")
    scores = [best_checkpoint(each) for each in rows.values()]
    best = sorted(scores, key=lambda score: -score.successes)[:count]
    for score in scores:
        mark = "chosen" if score in best else "left"
        print(f"evaluation: {score.run} {score.successes}/{score.episodes}, {mark}", file=sys.stderr)
    ((target, policy, training_set),) = about
    runs = [score.run for score in best]
    write_json(out, ChosenRuns(target=target, policy=policy, training_set=training_set, runs=runs, scores=scores))
