"""Which unseen assets are opened: coverage by the training set, and rank correlations."""

import numpy as np
import pandas as pd
import pytest

from roomkin.plugins.studies.associations import ShownAssets, _correlation, associations_table, build, traits
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.policies import TaskAsset
from tests.unit.tables_results import ABOUT, UNSEEN, over_assets

OPTIONS = TablesConfig(bootstrap_samples=300)


def asset(name: str, panel: tuple[float, float], length: float, height: float) -> TaskAsset:
    about = ABOUT | {"panel_size": panel, "handle_length": length, "handle_height": height}
    same = {
        "role": "test",
        "category": "cabinet",
        "family": name,
        "joint": "door",
        "size": (0.4, 0.5, 0.6),
        "distance": 1,
    }
    return TaskAsset.model_validate(about | same | {"asset": name})


def test_coverage_is_the_share_of_figures_within_what_was_shown() -> None:
    twin, cousin = asset("a", (0.4, 0.4), 0.1, 0.5), asset("b", (0.8, 0.4), 0.2, 0.5)
    small = asset("c", (0.31, 0.31), 0.08, 0.5)  # within 0.75 of the twin's
    assert ShownAssets([twin], (0.75, 1.25)).coverage(small) == 1
    assert ShownAssets([twin], (1.0, 1.0)).coverage(small) == 0.25  # only the height of its handle
    for height in (0.4, 0.6):  # which no demonstration stretches
        assert ShownAssets([twin], (0.75, 1.25)).coverage(asset("e", (0.4, 0.4), 0.1, height)) == 0.75
    assert ShownAssets([twin, cousin], (1.0, 1.0)).coverage(asset("d", (0.6, 0.4), 0.15, 0.6)) == 0.75
    found = traits(
        [small], {("twin", 0): ShownAssets([twin], (0.75, 1.25)), ("cousins_2", 0): ShownAssets([cousin], (0.75, 1.25))}
    )
    assert found.set_index("training_set")["coverage"].to_dict() == {"twin": 1, "cousins_2": 0.5}
    assert set(found["handle_height"]) == {0.5}
    by_seed = {("random_1", seed): ShownAssets([shown], (0.75, 1.25)) for seed, shown in enumerate((twin, cousin))}
    drawn = traits([small], by_seed)
    assert drawn.set_index("seed")["coverage"].to_dict() == {0: 1, 1: 0.5}, "each seed was shown what it drew"


def test_success_follows_what_decides_it_and_nothing_else() -> None:
    rows = pd.DataFrame([row.model_dump() for row in over_assets(UNSEEN)])  # long handles are easy
    rng = np.random.default_rng(0)
    chance = dict(zip(sorted(set(rows["asset"])), rng.random(rows["asset"].nunique()), strict=True))
    rows = rows.assign(handle_height=rows["asset"].map(chance), coverage=1.0)
    table = build(rows, OPTIONS).set_index(["policy", "training_set", "trait"])
    twin = table.loc[("lite", "twin")]
    assert twin.loc["handle_length", "low"] > 0.3 and twin.loc["handle_length", "correlation"] > 0.6
    assert twin.loc["handle_height", "low"] < 0 < twin.loc["handle_height", "high"]
    assert tuple(twin.loc["coverage", ["correlation", "low", "high"]]) == (0, 0, 0)  # it does not vary
    assert set(table["assets"]) == {24} and set(table["families"]) == {12}
    assert "skill" not in table.index.get_level_values("training_set")
    each = rows[(rows["policy"] == "lite") & (rows["training_set"] == "twin")].groupby("asset")
    expected = each["success"].mean().corr(each["handle_length"].first(), method="spearman")
    assert twin.loc["handle_length", "correlation"] == pytest.approx(expected)


def test_a_resample_is_a_table_in_which_assets_stand_as_often_as_they_weigh() -> None:
    pairs, times = np.array([[1.0, 2.0], [2.0, 1.0], [3.0, 5.0], [4.0, 3.0]]), np.array([5, 1, 0, 2])
    (found,) = _correlation(pairs, times[None].astype(float))
    assert found == pytest.approx(np.corrcoef(np.repeat(pairs, times, axis=0).T)[0, 1])


def test_table_of_associations() -> None:
    rows = pd.DataFrame([row.model_dump() for row in over_assets(UNSEEN)]).assign(handle_height=0.5, coverage=1.0)
    shown = associations_table(build(rows, OPTIONS))
    assert shown.columns[2:] == ["twin", "4 cousins"] and len(shown.rows) == 2 * 4
    assert shown.rows[1][:2] == ["Door opening, lite", "length of the handle"] and "24 assets" in shown.rows[1][2]
