"""Tables 2 and 3: statistics, what counts, what is pooled, what is shown as not run."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from roomkin.stages.config.evaluation import PolicyTables, TablesConfig
from roomkin.stages.contracts.policies import Rollout, SceneScore
from roomkin.stages.tables import policies, policy_tables, scenes, table2, table3
from roomkin.stages.tables.figures import draw_rates, figure9
from roomkin.stages.tables.intervals import t_interval, wilson
from roomkin.stages.tables.policy_tables import join_published
from roomkin.stages.tables.rows import (
    ONE_SCENE,
    published_policies,
    published_scenes,
    read_rows,
    set_key,
    sort_key,
    variant_key,
)
from roomkin.stages.tables.text import TextTable, html, latex, markdown, percent, points, span
from roomkin.stages.tables.text import cell as text_cell
from tests.refusals import refused
from tests.unit.tables_results import rollout, rollouts, score, write_rows

PUBLISHED = Path(__file__).parents[2] / "report" / "published"
OPTIONS = TablesConfig(bootstrap_samples=400)
REST = "a,a,True,True,1,1,1,1,1,True,,,,,,,,,0,,"  # of a score, after its status


def frame(rows: list) -> pd.DataFrame:
    return pd.DataFrame([row.model_dump() for row in rows])


def cell(table: pd.DataFrame, **keys: object) -> pd.Series:
    found = table[np.logical_and.reduce([table[name] == value for name, value in keys.items()])]
    assert len(found) == 1
    return found.iloc[0]


def scene_cells(rows: list) -> pd.DataFrame:
    return table2.build(frame(rows), published_scenes(PUBLISHED), OPTIONS)


# Known answers of the statistics -------------------------------------------------------------------------------------


def test_wilson_interval_of_a_published_example() -> None:
    low, high = wilson(8, 10, 0.95)
    assert (low, high) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert wilson(0, 10, 0.95).low == 0


def test_a_bar_reaches_from_the_low_end_to_the_high_one() -> None:
    axes = Figure().subplots()
    draw_rates(axes, [1.0], pd.DataFrame({"mean": [0.5], "low": [0.2], "high": [0.6]}), "twin")
    (bar,) = axes.collections[0].get_segments()  # type: ignore[attr-defined]
    assert np.asarray(bar) == pytest.approx(np.array([[1, 20], [1, 60]]))


def test_t_interval_and_sample_deviation() -> None:
    low, high = t_interval(pd.Series([1, 2, 3, None]), 0.95)
    assert (low, high) == pytest.approx((2 - 2.4841, 2 + 2.4841), abs=1e-3)
    assert np.isnan(t_interval(pd.Series([4.0]), 0.95).low)


def test_order_of_names() -> None:
    assert sorted(["room_10", "room_2"], key=sort_key) == ["room_2", "room_10"]
    assert sorted(["all", "cousins_8", "cousins_2", "twin"], key=set_key) == ["twin", "cousins_2", "cousins_8", "all"]
    assert sorted(["dissimilar", "cousin_6", "cousin_2", "twin"], key=set_key)[-1] == "dissimilar"


# The paper's values --------------------------------------------------------------------------------------------------


def test_published_scenes_add_up_to_the_paper() -> None:
    table = published_scenes(PUBLISHED)
    assert len(table) == 32 and table["oriented_iou_mean"].isna().all()
    by_variant = table.groupby("variant")[["n_objects", "category_correct", "model_correct"]].sum()
    assert by_variant.loc["b"].tolist() == [63, 62, 39]
    assert by_variant.loc["d"].tolist() == [63, 62, 56]
    assert table.loc[(8, "d"), ["scale_m", "l2_cm_mean", "iou_std"]].tolist() == [10.23, 17.09, 0.21]


def test_published_policies() -> None:
    table = published_policies(PUBLISHED)
    assert len(table) == 48 and set(table["runs"]) == {5, 6}
    door = cell(table, task="door", test_asset="cousin_6", training_set="cousins_8")
    assert door["mean"] == pytest.approx(0.9333, abs=1e-4)
    assert cell(table, task="put_away_bowl", test_asset="twin", training_set="twin")["mean"] == pytest.approx(0.162)


# Table 2 -------------------------------------------------------------------------------------------------------------


def test_table2_counts_lost_objects_as_wrong_and_leaves_them_out_of_means() -> None:
    lost = {"status": "missed", "category_correct": False, "model_correct": False, "asset": ""}
    nothing = dict.fromkeys(["l2_cm", "orientation_rad", "orientation_paper_rad", "iou", "oriented_iou", "stable"])
    other_rank = score(number=4, rank=2, l2_cm=500)
    invented = score(number=5, true_asset="", l2_cm=900)
    table = scene_cells([score(number=1), score(number=3), score(number=9, **lost, **nothing), other_rank, invented])
    row = cell(table, scene="room_1", variant="b")
    assert [row[name] for name in ("n_objects", "category_correct", "model_correct", "n_placed")] == [3, 2, 2, 2]
    assert (row["l2_cm_mean"], row["l2_cm_std"]) == pytest.approx((6.0, np.sqrt(2)))
    assert row["l2_cm_low"] == 0  # the t interval reaches below zero, a distance does not
    assert row["published_l2_cm_mean"] == 5.27 and row["status"] == "run"


def test_table2_counts_orientation_twice_modulo_the_period_and_as_the_paper() -> None:
    scores = [
        score(number=1, orientation_rad=0.3, orientation_paper_rad=0.3),
        score(number=2, orientation_rad=0.1, orientation_paper_rad=None),
        score(number=3, orientation_rad=None, orientation_paper_rad=None),
    ]
    row = cell(scene_cells(scores), scene="room_1", variant="b")
    assert row["orientation_rad_mean"] == pytest.approx(0.2) and row["n_oriented"] == 2
    assert row["orientation_paper_rad_mean"] == pytest.approx(0.3) and row["n_oriented_paper"] == 1
    assert row["published_orientation_paper_rad_mean"] == pytest.approx(0.07)


def test_table2_counts_what_a_cousin_is_for() -> None:
    opens = {"panels_correct": True, "handle_correct": False, "hinge_correct": True}
    scores = [
        score(number=1, shape_iou=0.8, **opens),
        score(number=2, shape_iou=0.6, **opens | {"hinge_correct": False}),
        score(number=3, shape_iou=None),
    ]
    table = scene_cells(scores)
    row = cell(table, scene="room_1", variant="b")
    assert [row[name] for name in table2.COUSINS] == [pytest.approx(0.7), pytest.approx(0.02**0.5), 2, 2, 0, 1, 2]
    shown = table2.scenes_table(table, OPTIONS)
    assert next(each for each in shown.rows if each[1] == "(b)")[-1] == "0.70 ± 0.14\n2, 0, 1 of 2"


def test_table2_total_pools_objects_and_compares_with_the_same_scenes() -> None:
    rows = [score("room_1", n, l2_cm=1) for n in (1, 2, 3)] + [score("room_2", 1, l2_cm=5)]
    row = cell(scene_cells(rows), scene="total")
    assert row["l2_cm_mean"] == pytest.approx(2.0)  # over objects; the mean of the scenes' means would be 3
    assert [row["n_objects"], row["n_scenes"], row["published_n_objects"], row["published_model_correct"]] == [
        4,
        2,
        11,
        9,
    ]
    assert row["published_l2_cm_mean"] == pytest.approx((5 * 5.27 + 6 * 4.85) / 11)


def test_table2_says_not_run_and_knows_other_scenes_and_variants() -> None:
    table = scene_cells([score(), score("kitchen", variant="dinov2")])
    assert cell(table, scene="room_8", variant="d")["status"] == "not run"
    assert pd.isna(cell(table, scene="room_8", variant="d")["n_objects"])
    own = cell(table, scene="kitchen", variant="dinov2")
    assert own["status"] == "run" and pd.isna(own["published_n_objects"])
    assert table["variant"].unique().tolist() == ["a", "b", "c", "d", "dinov2"]
    assert not ((table["scene"] == "kitchen") & (table["status"] == "not run")).any()


def test_the_default_runs_row_comes_first_and_is_none_of_the_papers() -> None:
    table = scene_cells([score(variant=name) for name in ("default", "c-local")])
    assert table["variant"].unique().tolist() == ["default", "a", "b", "c", "d", "c-local"]
    ours = table[table["variant"] == "default"]
    assert ours["status"].tolist() == ["run", "run"] and ours["published_n_objects"].isna().all()
    assert cell(table, scene="room_1", variant="b")["published_n_objects"] == 5
    assert sorted(["c-local", "fine_10", "default", "fine_2"], key=variant_key)[0] == "default"


def test_table2_says_what_is_given_and_what_a_judge_is_read_against() -> None:
    rows = [score(), score(protocol="noise", draw=1)]
    for baseline in (False, True):
        rows += [score(variant="no-image"), score(variant="no-image", protocol="noise", draw=1)] if baseline else []
        shown = table2.scenes_table(scene_cells(rows), OPTIONS)
        assert any("given the true label" in note for note in shown.notes)
        assert any("sees no picture" in note for note in shown.notes) == baseline


@pytest.mark.parametrize("judge", ["geometry", "geometry, no language model"])
def test_table2_says_what_a_stand_in_can_tell(judge: str) -> None:
    shown = table2.scenes_table(scene_cells([score(model_judge=judge)]), OPTIONS)
    assert any("cannot tell what a language model" in note for note in shown.notes) == (judge != "geometry")


def test_table2_names_the_judge_of_every_row() -> None:
    rows = [score(number=n, variant="d", model_judge="vlm toy", orientation_judge="distance") for n in (1, 2)]
    lost = score(number=4, variant="d", status="failed")  # nobody judged it
    rows += [lost, score(number=3, variant="d", model_judge="distance", orientation_judge="distance")]
    rows += [score("room_2", variant="c", model_judge="vlm toy", orientation_judge="vlm toy"), score("room_3")]
    table = scene_cells(rows)
    mixed = "vlm toy 2/3, distance 1/3; orientation: distance"
    for scene in ("room_1", "total"):
        assert cell(table, scene=scene, variant="d")["judge"] == mixed
    assert cell(table, scene="room_2", variant="c")["judge"] == "vlm toy"
    assert cell(table, scene="room_3", variant="b")["judge"] == ""
    shown = table2.scenes_table(table, OPTIONS)
    judges = {row[2] for row in shown.rows}
    assert judges == {mixed, "vlm toy", ""}  # rows that were not run have none


# Table 3 -------------------------------------------------------------------------------------------------------------


def papers(ours: pd.DataFrame) -> pd.DataFrame:
    """The paper's cells, beside ours."""
    return join_published(published_policies(PUBLISHED), ours, PolicyTables())


def policy_cells(rows: list) -> pd.DataFrame:
    return table3.build(frame(rows), papers(frame(rows)), OPTIONS)


def test_table3_has_a_row_per_run_and_pools_over_runs() -> None:
    rows = [rollout(n, n < 8, seed=0) for n in range(10)] + [rollout(n, n < 4, seed=1) for n in range(10)]
    table = policy_cells(rows)
    first = cell(table, status="run", seed=0)
    assert [first["episodes"], first["successes"], first["success_rate"]] == [10, 8, 0.8]
    assert (first["wilson_low"], first["wilson_high"]) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    (pooled,) = table3.cells(frame(rows), OPTIONS).to_dict("records")
    assert [pooled["runs"], pooled["places"], pooled["episodes"], pooled["successes"]] == [2, 10, 20, 12]
    assert (pooled["mean"], pooled["std"]) == pytest.approx((0.6, np.sqrt(0.08)))
    assert (table["status"] == "not run").sum() == 47


def test_table3_differences_compare_shared_initial_states_only() -> None:
    twin = [rollout(n, False) for n in range(5)]
    cousins = [rollout(n, n != 9, training_set="cousins_4") for n in range(10)]  # states 1005-1009 are theirs alone
    (row,) = table3.differences(frame(twin + cousins), OPTIONS).to_dict("records")
    assert (row["places"], row["assets"], row["difference"]) == (5, 1, 1.0)
    assert 0.3 < row["low"] < 0.5 and row["high"] == 1.0
    assert table3.differences(frame(cousins), OPTIONS).empty


def test_table3_pools_what_the_twin_is_not_as_unseen() -> None:
    roles = ("twin", "cousin_2", "dissimilar")
    rows = [rollout(n, role == "twin", test_asset=role) for n in range(4) for role in roles]
    rows += [rollout(n, role != "twin", training_set="cousins_4", test_asset=role) for n in range(4) for role in roles]
    rows += [rollout(n, True, test_asset="trained") for n in range(4)]  # on what each was trained on: nothing to pair
    rows += [rollout(n, False, training_set="cousins_4", test_asset="trained") for n in range(4)]
    table = table3.differences(frame(rows), OPTIONS)
    assert table["test_asset"].tolist() == [*roles, "unseen"]
    unseen = cell(table, test_asset="unseen")
    assert (unseen["assets"], unseen["places"], unseen["difference"]) == (2, 8, 1.0)
    assert cell(table, test_asset="twin")["difference"] == -1


def test_figure9_names_the_training_sets_above_its_first_row_alone() -> None:
    rows = [rollout(n, n < 8, policy=policy) for policy in ("lite", "other") for n in range(10)]
    ours = table3.cells(frame(rows), OPTIONS)
    axes = np.reshape(figure9(ours, papers(frame(rows))).axes, (-1, ours["training_set"].nunique()))
    assert len(axes) > 1 and all(panel.get_title() for panel in axes[0])
    assert not any(panel.get_title() for panel in axes[1:].ravel())


# Files ---------------------------------------------------------------------------------------------------------------


def test_command_writes_the_tables_with_fixed_columns_and_the_same_bytes(tmp_path: Path) -> None:
    scored = write_rows(tmp_path / "scores.csv", [score(number=1), score(number=2, orientation_rad=None)])
    episodes = write_rows(tmp_path / "rollouts.csv", rollouts())
    for out in ("one", "two"):
        scenes.run(out=tmp_path / out, scores=(scored,), published=PUBLISHED)
        policies.run(out=tmp_path / out, rollouts=(episodes,), published=PUBLISHED)
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == sorted(
        [f"{name}.{s}" for name in ("table2", "table3") for s in ("csv", "html", "tex")]
        + [f"figure{number}.{suffix}" for number in (4, 6, 9) for suffix in ("png", "svg")]
        + [f"table3_{what}.csv" for what in ("cells", "differences")]
    )
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    for name, columns in (("table2.csv", table2.COLUMNS), ("table3.csv", table3.COLUMNS)):
        head = (tmp_path / "one" / name).read_text().splitlines()[0].split(",")
        assert head[: len(columns)] == columns and head[-1] == "status"
    page = (tmp_path / "one" / "table3.html").read_text()
    assert "not run" in page and "paper 90 ± 4 %" in page and "http" not in page


def test_command_without_any_rows_says_not_run(tmp_path: Path) -> None:
    scenes.run(out=tmp_path, published=PUBLISHED)
    table = pd.read_csv(tmp_path / "table2.csv")
    assert set(table["status"]) == {"not run"} and len(table) == 32
    assert "total" not in set(table["scene"])


@pytest.mark.parametrize(
    ("text", "code", "named"),
    [
        ("", "E-TABLE-COLUMNS", "scores.csv"),
        ("HEADER\nroom_1,b,one,3.68,o,ok,REST\n", "E-CONTRACT-BROKEN", "at rank"),
        ("HEADER\nroom_1,b,1,3.68,o,lost,REST\n", "E-CONTRACT-BROKEN", "scores.csv:2: "),
        ("HEADER\nroom_1,b,1,3.68,o,ok,REST,9,9\n", "E-TABLE-COLUMNS", "scores.csv:2"),
    ],
)
def test_bad_rows_are_named_by_file_line_and_field(tmp_path: Path, text: str, code: str, named: str) -> None:
    path = tmp_path / "scores.csv"
    path.write_text(text.replace("HEADER", ",".join(SceneScore.model_fields)).replace("REST", REST))
    with refused(code, named) as error:
        read_rows(SceneScore, [path], ONE_SCENE)
    assert "\n" not in str(error.value)


def test_rows_given_twice_are_refused(tmp_path: Path) -> None:
    path = write_rows(tmp_path / "scores.csv", [score()])
    with refused("E-ROWS-TWICE"):
        read_rows(SceneScore, [path, path], ONE_SCENE)
    with refused("E-FILE-MISSING"):
        read_rows(Rollout, [tmp_path / "none.csv"], [])


def test_broken_published_values_leave_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "table2.csv").write_text("scene,variant\n1,a\n")
    (tmp_path / "table3.csv").write_text((PUBLISHED / "table3.csv").read_text())
    with refused("E-TABLE-COLUMN"):
        scenes.run(out=tmp_path / "out", published=tmp_path)
    assert not (tmp_path / "out").exists()


# Markup --------------------------------------------------------------------------------------------------------------


def test_markup_escapes() -> None:
    table = TextTable("t", "50 cm & <b>", ["a_b"], [[text_cell("<i>", "x_1 | −3 %", "±")]])
    assert "&lt;i&gt;" in html([table], "t") and "<i>" not in html([table], "t")
    text = latex([table])
    assert r"a\_b" in text and r"<i> x\_1 | -3 \% paper ±" in text and r"\toprule" in text
    assert markdown(table).splitlines()[-1] == r"| <i><br>x_1 \| −3 %<br>*paper ±* |"
    assert percent(0.916, 0.04) == "92 ± 4 %" and percent(0.5) == "50 %" and percent(float("nan")) == ""


def test_rows_and_columns_that_were_not_run_are_left_out() -> None:
    skill = ["scripted skill: 100 %", "", "", ""]  # its value is in its name
    rows = [["twin", "9 %", "not run", ""], ["all", "not run", "paper 7 %", "not run\npaper 1 %"], skill]
    table = TextTable("t", "", ["asset", "a", "b", "c"], rows)
    assert (table.drop_empty().columns, table.drop_empty().rows) == (["asset", "a"], [["twin", "9 %"], skill[:2]])


def test_rows_that_begin_alike_stand_under_one_heading() -> None:
    rows = [["door", "twin", "9 %"], ["door", "all", "8 %"], ["bowl", "twin", "7 %"]]
    table = TextTable("t", "", ["task", "asset", "a"], rows, headers=2)
    assert table.groups == [("door", [["twin", "9 %"], ["all", "8 %"]]), ("bowl", [["twin", "7 %"]])]
    page = html([table], "t")
    assert (
        page.count(">door<") == page.count('colspan="2"') / 2 == 1 and 'data-label="a"' in page and "task" not in page
    )
    assert TextTable("t", "", table.columns, rows[1:], headers=2).groups == [("", rows[1:])]


@pytest.mark.parametrize(
    ("rate", "text"),
    [
        (320 / 321, "99.7 %"),
        (1 / 321, "0.3 %"),
        (1.0, "100 %"),
        (0.0, "0 %"),
        (0.99996, "> 99.9 %"),
        (0.0001, "< 0.1 %"),
    ],
)
def test_percent_says_100_and_0_of_nothing_else(rate: float, text: str) -> None:
    assert percent(rate) == text


def test_intervals_are_rounded_outwards() -> None:
    assert span(0.4902, 0.9433) == "49–95" and span(0, 0.1936) == "0–20" and span(-0.012, 0.3) == "−2 to +30"
    assert [points(value) for value in (0.125, -0.5625, 0.0)] == ["+12 points", "−56 points", "0 points"]


def test_layouts_show_ours_beside_the_paper() -> None:
    shown = policy_tables.policies_table(table3.cells(frame(rollouts()), OPTIONS), papers(frame(rollouts())), OPTIONS)
    first = shown.rows[0]
    assert first[0].startswith("Door opening\n") and first[1] == "twin"
    assert first[3].endswith("paper 90 ± 4 %") and "2 runs" in first[3]
    assert first[4] == "not run\npaper 91 ± 9 %"
    bowl = next(row for row in shown.rows if row[0] == "Putting away bowl")
    assert bowl not in shown.drop_empty().rows and bowl[4] == ""  # the paper has no such cell either


def test_table_3_tells_the_steps_of_the_episodes_that_succeed() -> None:
    rows = [rollout(n, n < 3, steps=steps) for n, steps in enumerate((20, 30, 70, 200))]
    (cell,) = table3.cells(frame(rows), OPTIONS).to_dict("records")
    assert cell["steps"] == 40 and table3.build(frame(rows), papers(frame(rows)), OPTIONS)["steps"].iloc[0] == 40
    shown = markdown(policy_tables.policies_table(table3.cells(frame(rows), OPTIONS), papers(frame(rows)), OPTIONS))
    assert "3/4, 1 run, official 75 %, 40 steps" in shown
    never = table3.cells(frame([rollout(0, False)]), OPTIONS)
    assert "steps" not in markdown(policy_tables.policies_table(never, papers(frame(rows)), OPTIONS))
