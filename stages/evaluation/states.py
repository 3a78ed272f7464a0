"""The episodes of an evaluation, pairs of an asset and the seed of an initial state, and its rows on disk."""

import csv
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from roomkin.stages.config.evaluation import SkillOptions
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.policies import Rollout, TaskAsset, TaskAssets


def write_rows(path: Path, rows: Sequence[Rollout]) -> None:
    """Write rows as a CSV table."""
    with write_atomically(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, Rollout.model_fields, lineterminator="\n")
        table.writeheader()
        table.writerows(row.model_dump() for row in rows)


Purpose = Literal["roles", "test", "validation", "selection"]
Start = tuple[TaskAsset, int]
FIRST_STATE = 2**31  # demonstrations use seeds below: no policy is tested on a state that it was trained on
TWIN = "twin"
TRAINED = "trained"  # test asset: those that a policy was trained on


def initial_states(purpose: Purpose, seed: int, count: int, place: int = 0) -> list[int]:
    """Seeds of initial states in [2^31, 2^32), the same for every policy.

    Args:
        purpose: what they are for; each has a quarter of the range, so no two share a state.
        seed: of the run of the workflow.
        count: how many; fewer are the first of more.
        place: of the asset in its split, for states of its own.
    """
    quarter = get_args(Purpose).index(purpose)
    offset = int(np.random.SeedSequence((quarter, seed, place)).generate_state(1)[0]) % 2**28
    return [FIRST_STATE + quarter * 2**29 + offset + i for i in range(count)]


def starts_of(
    plan: TaskAssets, where: Path, settings: SkillOptions, trained: Sequence[str], seed: int
) -> dict[str, list[Start]]:
    """The episodes of every test asset, and of the split under its name.

    Args:
        plan: the experiment's assets, read from the file `where`.
        trained: roles that the policy was trained on; none: nothing is rolled out on `trained`.

    Raises:
        InputError: `where` has no asset of a role.
    """
    states = initial_states("roles", seed, settings.rollouts)
    twins = initial_states("roles", seed, settings.twin_rollouts or settings.rollouts)
    starts: dict[str, list[Start]] = {}
    for test_asset in settings.test_assets:
        if test_asset != TRAINED:
            of_role = twins if test_asset == TWIN else states
            starts[test_asset] = [(plan.find_asset(test_asset, where), state) for state in of_role]
        elif trained:
            known = [asset for name in trained for asset in plan.assets_of(name, where)]
            starts[test_asset] = share_states(known, states)
    unseen = list_unseen_starts(plan, settings, seed)
    return starts | {settings.split: unseen} if unseen else starts


def list_unseen_starts(plan: TaskAssets, settings: SkillOptions, seed: int) -> list[Start]:
    """The episodes on the first assets of the split; if there are fewer than asked, a line on stderr says so."""
    found = plan.split(settings.split, settings.assets)
    if len(found) < settings.assets:
        rest = "all are used" if found else "only roles are tested"
        of = f"the {settings.split} split has {len(found)} assets of {settings.assets}"
        print(f"evaluation: {of}: {rest}", file=sys.stderr)
    states = [initial_states(settings.split, seed, settings.asset_rollouts, place) for place in range(len(found))]
    return [(asset, state) for asset, own in zip(found, states, strict=True) for state in own]


def share_states(assets: Sequence[TaskAsset], states: Sequence[int]) -> list[Start]:
    """The states shared evenly by the assets; of more assets than states some are left out, evenly over the list."""
    turns = min(len(assets), len(states))
    return [(assets[number % turns * len(assets) // turns], state) for number, state in enumerate(states)]
