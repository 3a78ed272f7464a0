"""Targets that are one task in several rooms, as one row of the tables."""

from pathlib import Path

import pandas as pd
import pytest

from roomkin.plugins.claims import assets
from roomkin.plugins.claims.more import target_tables
from roomkin.plugins.studies import conditions
from roomkin.plugins.studies.study import policy_file, progress_table
from roomkin.stages.config.evaluation import PolicyTables
from roomkin.stages.config.model import Config, load
from roomkin.stages.config.targets import Cell
from roomkin.stages.config.training import policy_tables
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.tables.policy_tables import kinds_of, pool_rollouts
from tests.unit.tables_results import over_assets

DOOR = {"task": "door", "room": "room_1", "object": "cabinet_1"}
SETS = ("twin", "twin_randomised", "cousins_8")


@pytest.fixture(scope="module")
def config() -> Config:
    """Two rooms with doors, a pool, and one with a drawer."""
    targets = {
        "door_room_1": DOOR,
        "door_room_2": DOOR | {"room": "room_2", "object": "sideboard_1"},
        "drawer_room_1": DOOR | {"task": "drawer", "room": "room_2", "object": "chest_of_drawers_1"},
    }
    experiment = {"targets": targets, "pools": {"door": ["door_room_1", "door_room_2"]}, "seeds": [0, 1]}
    return load({"experiment": experiment, "tables": {"bootstrap_samples": 200}})


@pytest.fixture(scope="module")
def options(config: Config) -> PolicyTables:
    return policy_tables(config)


def rows(lengths: dict[str, float], lacking: tuple[str, int] = ("", 0), policy: str = "lite") -> pd.DataFrame:
    """Rollouts of the doors of two rooms; `lacking`: room and seed of a policy of 8 cousins that was not run."""
    made: list[Rollout] = []
    for room in ("door_room_1", "door_room_2"):
        policies = {(policy, name): length for name, length in lengths.items()} | {("skill", "skill"): 0.0}
        found = over_assets(policies, 12, target=room)
        made += [row for row in found if (row.target, row.seed, row.training_set) != (*lacking, "cousins_8")]
    return pd.DataFrame([row.model_dump() for row in made])


def built(found: pd.DataFrame, options: PolicyTables) -> pd.DataFrame:
    return assets.build(found, options, {"door": "lite"}).set_index("training_set")


def test_an_asset_counts_in_every_room_and_its_family_once(options: PolicyTables) -> None:
    given = rows({"twin": 0.2, "twin_randomised": 0.1, "cousins_8": 0.05})
    found = pool_rollouts(given, options)
    assert len(found) == len(given) and set(found["target"]) == {"door"}
    table = built(found, options)
    assert set(table["assets"]) == {24} and set(table["families"]) == {6} and set(table["places"]) == {48}
    assert table["runs"].tolist() == [2, 2, 2, 1]
    each = assets.build(given, options, {}).set_index(["target", "training_set"])["mean"]
    for name in SETS:
        assert table.loc[name, "mean"] == pytest.approx((each["door_room_1", name] + each["door_room_2", name]) / 2)
    gained = table.loc["cousins_8"]
    assert gained["randomised_difference"] == pytest.approx(gained["mean"] - table.loc["twin_randomised", "mean"])
    assert gained["randomised_low"] < gained["randomised_difference"] < gained["randomised_high"]
    assert pd.isna(table.loc["twin_randomised", "randomised_difference"])


def test_what_is_in_no_pool_stays_as_it_is(options: PolicyTables) -> None:
    given = pd.DataFrame([row.model_dump() for row in over_assets({("lite", "twin"): 0.1}, 4, target="drawer_room_1")])
    pd.testing.assert_frame_equal(pool_rollouts(given, options), given)
    pd.testing.assert_frame_equal(pool_rollouts(given, PolicyTables()), given)


def test_two_kinds_of_policy_are_never_one_row(options: PolicyTables) -> None:
    lengths = {"twin": 0.2}
    both = pd.concat([rows(lengths), rows(lengths, policy="lite_handle")], ignore_index=True).drop_duplicates()
    table = assets.build(pool_rollouts(both, options), options, {"door": "lite"}).set_index(["target", "policy"])
    assert list(table.index) == [("door", "lite"), ("door", "lite_handle"), ("door", "skill")]
    assert table.loc[("door", "lite_handle"), "network_difference"] == 0


def test_a_seed_that_lacks_a_room_is_left_out(options: PolicyTables) -> None:
    table = built(
        pool_rollouts(rows({"twin_randomised": 0.1, "cousins_8": 0.05}, ("door_room_2", 1)), options), options
    )
    assert table.loc["cousins_8", "runs"] == 1 and table.loc["twin_randomised", "runs"] == 2
    assert table.loc["cousins_8", "assets"] == 24


def test_the_targets_of_a_pool_stand_alone_in_a_table_of_their_own(options: PolicyTables) -> None:
    (table,) = target_tables(rows({"twin": 0.2}), options, kinds_of(options))
    assert {row[0].split("\n")[0] for row in table.rows} == {
        "Door opening, room 1, unseen assets", "Door opening, room 2, unseen assets",
    }  # fmt: skip
    assert not target_tables(rows({"twin": 0.2}), PolicyTables(bootstrap_samples=200), {})


def test_a_policy_is_there_when_it_has_met_every_room(config: Config, tmp_path: Path) -> None:
    for room, seed in (("door_room_1", 0), ("door_room_1", 1), ("door_room_2", 0)):
        path = policy_file(tmp_path, "", Cell(room, "lite", "twin"), "lite", seed)
        path.parent.mkdir(parents=True)
        path.touch()
    table = progress_table(config, tmp_path)
    (row,) = (row for row in table.rows if row[0] == "Door opening, lite")
    assert row[table.columns.index("twin")] == "1 of 2"


def test_what_a_set_gains_is_told_under_every_condition(options: PolicyTables) -> None:
    usual, noisy = (
        pool_rollouts(rows({"twin_randomised": length, "cousins_8": 0.05}), options) for length in (0.1, 0.2)
    )
    both = pd.concat([usual.assign(condition="usual"), noisy.assign(condition="noisy")], ignore_index=True)
    gains = conditions.against_baselines(both, options)
    found = gains.set_index(["training_set", "condition"])["difference"]
    assert (
        set(gains["baseline"]) == {"twin_randomised"} and found["cousins_8", "noisy"] > found["cousins_8", "usual"] > 0
    )
    shown = conditions.baselines_table(gains)
    assert {row[3] for row in shown.rows} == {"twin, randomised"} and len(shown.rows) == 2
