"""Success over sets of unseen assets: what is compared with what, by handle, in Figure 4; names of rows; roles."""

from pathlib import Path

import pandas as pd
import pytest

from roomkin.plugins.claims import assets, more
from roomkin.plugins.claims.more import make_panels
from roomkin.plugins.claims.tables import assets_table, by_handle_table
from roomkin.plugins.report.roles import lists_table, role_title, roles_table
from roomkin.stages.config.evaluation import PolicyTables, TablesConfig
from roomkin.stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from roomkin.stages.tables import table3
from roomkin.stages.tables.figures import figure4
from roomkin.stages.tables.policy_tables import join_published
from roomkin.stages.tables.rows import published_policies, row_title, set_key, target_title, title
from roomkin.stages.tables.text import TextTable, markdown
from tests.unit.tables_results import ABOUT, UNSEEN, over_assets, rollout

PUBLISHED = Path(__file__).resolve().parents[3] / "report" / "published"
OPTIONS = TablesConfig(bootstrap_samples=400)
KINDS = {"lite": "64-wide network", "lite_handle": "handle flagged"}
FIRST = {"door": "lite"}


def frame(rows: list[Rollout]) -> pd.DataFrame:
    return pd.DataFrame([row.model_dump() for row in rows])


@pytest.fixture(scope="module")
def rows() -> pd.DataFrame:
    """Two kinds of policies, two training sets, the skill; and a role that is none of it."""
    return frame([*over_assets(UNSEEN), *(rollout(n, test_asset="cousin_2") for n in range(4))])


@pytest.fixture(scope="module")
def table(rows: pd.DataFrame) -> pd.DataFrame:
    return assets.build(rows, OPTIONS, FIRST).set_index(["policy", "training_set"])


def texts(shown: TextTable) -> list[list[str]]:
    return [[cell.split("\n")[0] for cell in row] for row in shown.rows]


def test_every_kind_of_policy_is_compared_with_its_twin_and_with_the_papers_network(table: pd.DataFrame) -> None:
    assert list(table.index) == list(UNSEEN) and set(table["test_asset"]) == {"test"}
    assert table["mean"].tolist() == pytest.approx([1 / 2, 2 / 3, 5 / 6, 5 / 6, 1])
    assert set(table["assets"]) == {24} and set(table["families"]) == {12} and set(table["places"]) == {48}
    assert table["runs"].tolist() == [2, 2, 2, 2, 1]
    gains = table["twin_difference"]
    assert gains[("lite", "cousins_4")] == pytest.approx(1 / 6) and gains[("lite_handle", "cousins_4")] == 0
    gains = table["network_difference"]
    assert gains[("lite_handle", "twin")] == pytest.approx(1 / 3)
    assert gains[("lite_handle", "cousins_4")] == pytest.approx(1 / 6)
    assert table["twin_difference"].isna().sum() == 3 and table["network_difference"].isna().sum() == 3
    assert table.loc[("lite_handle", "twin"), "network_low"] > 0 > table.loc[("lite", "cousins_4"), "twin_low"]


def test_table_of_assets(table: pd.DataFrame) -> None:
    shown = assets_table(table.reset_index(), OPTIONS, KINDS, ["the mask of the target"])
    assert shown.columns[2:] == ["twin", "4 cousins"]
    assert {row[0] for row in texts(shown)} == {"Door opening, unseen assets"}
    assert [row[1:] for row in texts(shown)] == [
        ["64-wide network", "50 ± 0 %", "67 ± 0 %"],
        ["handle flagged", "83 ± 0 %", "83 ± 0 %"],
        ["64-wide network, minus the twin's", "", "+17 points"],
        ["handle flagged, minus the twin's", "", "0 points"],
        ["handle flagged, minus 64-wide network", "+33 points", "+17 points"],
        ["scripted skill: 100 %", "", ""],
    ]
    assert shown.rows[0][0].endswith("\n24 assets of 12 families, 48 initial states")
    assert shown.rows[0][2].endswith("] 24 assets, 2 runs") and "48/48" in shown.rows[-1][1]
    assert "the mask of the target" in markdown(shown) and "nan" not in markdown(shown)


def test_by_kind_and_length_of_the_handle(rows: pd.DataFrame) -> None:
    found = assets.by_handle(rows, OPTIONS)
    door = found[(found["policy"] == "lite") & (found["training_set"] == "twin")].set_index("handle")
    assert list(door.index) == ["arch", "bar", "edge", "knob", *assets.BINS] and set(door["assets"]) == {6}
    assert door["mean"].tolist() == pytest.approx([1 / 3, 1 / 3, 1, 1 / 3, 1 / 3, 1 / 3, 1 / 3, 1])
    shown = by_handle_table(found, OPTIONS)
    assert shown.columns[2:] == ["twin", "4 cousins", "scripted skill"] and len(shown.rows) == 16
    assert shown.rows[0][1].endswith("\nn = 6") and texts(shown)[1][1:] == ["bar", "33 ± 0 %", "100 ± 0 %", "100 %"]


def test_table3_holds_roles_of_policies_alone(rows: pd.DataFrame) -> None:
    assert table3.cells(rows, OPTIONS)["test_asset"].tolist() == ["cousin_2"]
    published = join_published(published_policies(PUBLISHED), rows, PolicyTables())
    assert set(table3.build(rows, published, OPTIONS)["training_set"]) == {
        "twin", "cousins_2", "cousins_4", "cousins_8", "all",
    }  # fmt: skip
    roles = frame([rollout()])
    assert assets.build(roles, OPTIONS, FIRST).empty and assets.by_handle(roles, OPTIONS).empty


def test_figure_4_has_a_point_per_asset_and_thirds_of_the_assets(rows: pd.DataFrame) -> None:
    both = [*over_assets(UNSEEN, split="validation"), *over_assets(UNSEEN)]
    points, thirds = more.spread_points(frame(both)), more.tabulate_thirds(frame(both), OPTIONS)
    assert len(points) == 4 * 24 and set(thirds["target"]) == {"door"}
    lengths = thirds[(thirds["axis"] == "handle_length") & (thirds["policy"] == "lite")]
    assert sorted(lengths["assets"].unique()) == [6, 12]  # handles that are alike stay in one third
    figure = figure4(
        table3.cells(rows, OPTIONS),
        join_published(published_policies(PUBLISHED), rows, PolicyTables()),
        make_panels(frame(both), PolicyTables(bootstrap_samples=400)),
    )
    panels = figure.axes
    assert [panel.get_xlabel() for panel in panels[:2]] == [
        "distance from the twin, 24 assets", "length of the handle (m), 24 assets",
    ]  # fmt: skip
    assert len(panels) == 8 and panels[4].get_title(loc="left") == "Door opening, lite_handle"
    assert [panel.get_visible() for panel in panels] == [True] * 7 + [False]  # the paper has no such policy


def test_names_of_rows_and_sets() -> None:
    targets = [("door", "door"), ("door_room_1", "door"), ("fridge_handle", "door"), ("bowl", "put_away_bowl")]
    assert [target_title(*names) for names in [*targets, ("touch", "touch"), ("my_touch", "touch")]] == [
        "Door opening", "Door opening, room 1", "Door opening, fridge handle", "Putting away bowl", "Touch",
        "Touch, my touch",
    ]  # fmt: skip
    assert row_title({"target": "door_1", "task": "door", "policy": "lite"}) == "Door opening, 1, lite"
    sets = ["skill", "all", "random_8", "cover_8", "cousins_8_randomised", "cousins_8", "twin_randomised", "twin"]
    assert sorted(sets, key=set_key) == sets[::-1]
    assert [title(name) for name in sets[2:7]] == [
        "8 random assets", "8 covering assets", "8 cousins, randomised", "8 cousins", "twin, randomised",
    ]  # fmt: skip
    roles = ["random_3", "cover_19", "random_17_randomised", "cousin_2_randomised", "twin", "all_randomised"]
    assert [role_title(role) for role in roles] == [
        "random 3", "cover 3 of draw 2", "random 1 of draw 2, randomised", "cousin 2, randomised", "twin",
        "all assets, randomised",
    ]  # fmt: skip


def chosen() -> TaskAssets:
    """A twin, a cousin, two assets drawn by chance and three to test on."""

    def asset(role: str, number: int, **changes: object) -> TaskAsset:
        about = {"asset": f"cabinet_{number}", "family": "cabinet_00", "category": "cabinet", "joint": "door"}
        about |= {"size": (1, 1, 1)}
        return TaskAsset.model_validate(ABOUT | about | {"role": role, "distance": number} | changes)

    return TaskAssets(
        task="door", scene="room_1", object="cabinet_1", encoder="hog",
        assets=[asset("twin", 0), asset("cousin_1", 1), asset("dissimilar", 9, handle="edge", family="f_9")],
        draws=2,
        random_assets=[asset("random", 2, handle="knob"), asset("random", 3)],
        cover_assets=[asset("cover", 3), asset("cover", 2)],
        test_assets=[asset("test", n, handle=handle, handle_length=n / 100, family=f"f_{n // 2}")
                     for n, handle in ((4, "knob"), (5, "bar"), (6, "knob"))],
    )  # fmt: skip


def test_roles_tell_families_handles_and_what_was_demonstrated() -> None:
    demonstrated = ["twin", "twin_randomised", "random_1", "cover_17_randomised"]
    shown = roles_table(chosen(), demonstrated, "roles", "")
    assert [[row[0], row[6], row[7]] for row in texts(shown)] == [
        ["twin", "yes, randomised", "yes"], ["cousin 1", "no", "yes"], ["dissimilar", "no", "no"],
        ["random 1", "yes", "yes"], ["cover 1 of draw 2", "randomised", "yes"],
    ]  # fmt: skip
    assert shown.rows[0][2] == "cabinet_00"
    assert shown.rows[0][4].endswith("\n12 cm, at 50 % of the front")
    (lists,) = lists_table(chosen(), "lists", "")
    assert texts(lists) == [["random assets", "2", "1", "bar 1, knob 1", "12-12 cm"],
                            ["covering assets", "2", "1", "bar 2", "12-12 cm"],
                            ["test", "3", "2", "bar 1, knob 2", "4-6 cm"]]  # fmt: skip
