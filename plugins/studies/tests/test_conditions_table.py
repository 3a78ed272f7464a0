"""Success under other conditions beside the usual one, by the same policies at the same places."""

from pathlib import Path

import pandas as pd
import pytest

from roomkin.plugins.studies import conditions
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.files import read_rows
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.evaluation.states import write_rows
from roomkin.stages.tables.intervals import difference_interval, side_of
from tests.refusals import refused
from tests.unit.tables_results import rollout


def episodes(successes: list[bool], **changes: object) -> list[Rollout]:
    """One state each on as many assets of the test split."""
    return [
        rollout(n, success, test_asset="test", asset=f"a_{n}", family=f"a_{n}", initial_state=2**31 + n, **changes)
        for n, success in enumerate(successes)
    ]


@pytest.fixture
def table(tmp_path: Path) -> list[dict[str, str]]:
    here, there = tmp_path / "here.csv", tmp_path / "conditions" / "mujoco" / "door" / "rollouts.csv"
    there.parent.mkdir(parents=True)
    write_rows(here, episodes([True] * 8 + [False] * 2))
    write_rows(there, episodes([True] * 4 + [False] * 6))
    conditions.run(out=tmp_path, rollouts=(here,), elsewhere=(there,), names=("mujoco",))
    lines = (tmp_path / "conditions.csv").read_text().splitlines()
    assert (tmp_path / "conditions.html").is_file() and (tmp_path / "conditions.tex").is_file()
    return [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]


def test_a_row_for_each_condition_the_usual_one_first(table: list[dict[str, str]]) -> None:
    assert [row["condition"] for row in table] == ["usual", "mujoco"]
    assert [float(row["mean"]) for row in table] == [0.8, 0.4]
    assert [row["episodes"] for row in table] == ["10", "10"]


def test_differences_are_paired_with_the_usual_condition(table: list[dict[str, str]]) -> None:
    usual, there = table
    assert usual["difference"] == ""
    assert float(there["difference"]) == pytest.approx(-0.4)
    assert float(there["difference_low"]) < -0.4 < float(there["difference_high"]) < 0.05


def test_a_policy_that_has_not_met_the_condition_is_not_compared() -> None:
    usual = [*episodes([True] * 6 + [False] * 4, seed=0), *episodes([True] * 10, seed=1)]
    rows = pd.DataFrame([row.model_dump() for row in usual]).assign(condition="usual")
    there = pd.DataFrame([row.model_dump() for row in episodes([True] * 4 + [False] * 6, seed=0)])
    table = conditions.build(pd.concat([rows, there.assign(condition="mujoco")]), TablesConfig(bootstrap_samples=200))
    found = table.set_index("condition")
    assert found.loc["usual", "mean"] == 0.8 and found.loc["mujoco", "difference"] == pytest.approx(-0.2)


def test_policies_that_all_lose_alike_lose_for_certain() -> None:
    """However they differ among themselves: each is compared with itself."""
    seeds = {seed: 2 * seed + 2 for seed in range(5)}  # of 20 assets
    usual, there = (
        pd.DataFrame([
            row.model_dump()
            for seed, opened in seeds.items()
            for row in episodes([n < opened + more for n in range(20)], seed=seed)
        ])
        for more in (8, 0)
    )  # fmt: skip
    sides = [side_of(rows) for rows in (there, usual)]
    options = TablesConfig(bootstrap_samples=400)
    low, high = difference_interval(*sides, options, same=True)
    apart = difference_interval(*sides, options)
    assert low < -0.4 < high and high - low < apart.high - apart.low


def test_a_file_lies_below_the_folder_of_its_condition(tmp_path: Path) -> None:
    write_rows(tmp_path / "here.csv", episodes([True]))
    assert read_rows(Rollout, tmp_path / "here.csv")
    with refused("E-CONDITIONS-NAMES"):
        here = tmp_path / "here.csv"
        conditions.run(out=tmp_path, rollouts=(here,), elsewhere=(here,), names=("mujoco",))


def test_a_condition_is_told_by_the_folder_below_conditions_alone() -> None:
    path = Path("results/evaluation/conditions/parked/door/twin/lite/seed_0/rollouts.csv")
    assert all(conditions._find_condition(path, ("parked", other)) == "parked" for other in ("door", "twin", "lite"))
