"""Rows of the experiment that do one task in several rooms, as one row."""

from pathlib import Path

import pandas as pd
import pytest

from stages.config.model import Config, load
from stages.config.tables import TablesConfig
from stages.contracts.policies import Rollout
from stages.tables import assets, conditions
from stages.tables.pooling import pooled, pools
from stages.tables.progress import policy_file, progress_table
from tests.unit.tables_results import over_assets

OPTIONS = TablesConfig(bootstrap_samples=200)
ROW = {"task": "door", "scene": "room_1", "object": "cabinet_1"}
SETS = ("twin", "twin_randomised", "cousins_8")


@pytest.fixture(scope="module")
def config() -> Config:
    """Two rooms with doors, one with a drawer; handles flagged in both rooms, whole objects in one."""
    tasks = {
        "door": None,
        "door_handle": None,
        "door_room_1": ROW,
        "door_room_2": ROW | {"scene": "room_2", "object": "sideboard_1"},
        "door_room_1_handle": {"assets_of": "door_room_1", "runs": ["lite_handle"]},
        "door_room_2_handle": {"assets_of": "door_room_2", "runs": ["lite_handle"]},
        "door_whole": ROW | {"options": {"cloud": "object"}},
        "drawer_room_1": ROW | {"task": "drawer", "scene": "room_2", "object": "chest_of_drawers_1"},
    }
    return load({"experiment": {"tasks": {name: row for name, row in tasks.items() if row}, "seeds": [0, 1]}})


def rows(lengths: dict[str, float], lacking: tuple[str, int] = ("", 0)) -> pd.DataFrame:
    """Rollouts of the doors of two rooms; `lacking`: room and seed of a policy of 8 cousins that was not run."""
    made: list[Rollout] = []
    for room in ("door_room_1", "door_room_2"):
        policies = {(room, name): length for name, length in lengths.items()} | {(room, "skill"): 0.0}
        found = [row.model_copy(update={"assets_of": room}) for row in over_assets(policies, 12)]
        made += [row for row in found if (row.task, row.seed, row.training_set) != (*lacking, "cousins_8")]
    return pd.DataFrame([row.model_dump() for row in made])


def test_rows_that_do_the_same_in_other_rooms_are_one(config: Config) -> None:
    assert pools(config) == {
        "door_room_1": "door", "door_room_2": "door", "door_room_1_handle": "door_handle",
        "door_room_2_handle": "door_handle", "door_whole": "door_whole", "drawer_room_1": "drawer_room_1",
    }  # fmt: skip


def test_an_asset_counts_in_every_room_and_its_family_once(config: Config) -> None:
    given = rows({"twin": 0.2, "twin_randomised": 0.1, "cousins_8": 0.05})
    found = pooled(given, config)
    assert len(found) == len(given) and set(found["task"]) == set(found["assets_of"]) == {"door"}
    table = assets.build(found, OPTIONS).set_index("training_set")
    assert set(table["assets"]) == {24} and set(table["families"]) == {6} and set(table["places"]) == {48}
    assert table["runs"].tolist() == [2, 2, 2, 1]
    each = assets.build(given, OPTIONS).set_index(["task", "training_set"])["mean"]
    for name in SETS:
        assert table.loc[name, "mean"] == pytest.approx((each["door_room_1", name] + each["door_room_2", name]) / 2)
    gained = table.loc["cousins_8"]
    assert gained["randomised_difference"] == pytest.approx(gained["mean"] - table.loc["twin_randomised", "mean"])
    assert gained["randomised_low"] < gained["randomised_difference"] < gained["randomised_high"]
    assert pd.isna(table.loc["twin_randomised", "randomised_difference"])


def test_a_seed_that_lacks_a_room_is_left_out(config: Config) -> None:
    lengths = {"twin_randomised": 0.1, "cousins_8": 0.05}
    table = assets.build(pooled(rows(lengths, ("door_room_2", 1)), config), OPTIONS).set_index("training_set")
    assert table.loc["cousins_8", "runs"] == 1 and table.loc["twin_randomised", "runs"] == 2
    assert table.loc["cousins_8", "assets"] == 24


def test_a_policy_is_there_when_it_has_met_every_room(config: Config, tmp_path: Path) -> None:
    plan = config.experiment.plan("door_room_1")
    for room, seed in (("door_room_1", 0), ("door_room_1", 1), ("door_room_2", 0)):
        path = policy_file(tmp_path, "", room, "twin", plan.runs[0], seed)
        path.parent.mkdir(parents=True)
        path.touch()
    table = progress_table(config, tmp_path)
    (row,) = (row for row in table.rows if row[0] == "Door opening")
    assert row[table.columns.index("twin")] == f"1 of {2 * len(plan.runs)}"


def test_what_a_set_gains_is_told_under_every_condition(config: Config) -> None:
    usual = rows({"twin_randomised": 0.1, "cousins_8": 0.05}).assign(condition="usual")
    noisy = rows({"twin_randomised": 0.2, "cousins_8": 0.05}).assign(condition="noisy")
    gains = conditions.against_baselines(pooled(pd.concat([usual, noisy], ignore_index=True), config), OPTIONS)
    found = gains.set_index(["training_set", "condition"])["difference"]
    assert (
        set(gains["baseline"]) == {"twin_randomised"} and found["cousins_8", "noisy"] > found["cousins_8", "usual"] > 0
    )
    shown = conditions.baselines_table(gains)
    assert {row[3] for row in shown.rows} == {"twin, randomised"} and len(shown.rows) == 2
