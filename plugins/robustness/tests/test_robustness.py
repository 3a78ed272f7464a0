"""The companion of Table 2, and the models that matching does without."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.plugins.robustness import leave_out
from roomkin.plugins.robustness import table as robustness
from roomkin.plugins.robustness.table import robustness_table, run
from roomkin.stages.contracts import LeftOut, read_json, write_json
from roomkin.stages.contracts.library_folder import write_part
from tests.unit.tables_results import score, write_rows
from tests.unit.test_score import TRUTH, true
from tests.unit.test_tables import cell, frame, scene_cells


def test_robustness_variants_of_rooms_stand_in_the_companion_alone() -> None:
    rows = [score(number=1), score(number=2, model_correct=False)]
    for draw, distance in ((1, 2.0), (2, 4.0)):
        met = {"protocol": "noise", "draw": draw, "l2_cm": distance, "shift_cm": 0.1, "chamfer": 0.02}
        rows += [score(number=1, **met), score(number=2, **met | {"model_correct": draw == 1, "stable": False})]
    assert cell(scene_cells(rows), scene="room_1", variant="b")["n_objects"] == 2
    table = robustness.build(frame(rows))
    first, noise = (cell(table, protocol=name) for name in ("as shipped", "noise"))
    assert (first["n_draws"], first["model_correct_mean"]) == (1, 1) and np.isnan(first["model_correct_std"])
    assert (noise["n_draws"], noise["n_objects"], noise["fallen_mean"]) == (2, 2, 1)
    assert (noise["model_correct_mean"], noise["l2_cm_mean"]) == (1.5, 3.0)
    assert noise["l2_cm_std"] == pytest.approx(np.sqrt(2))
    text = robustness_table(table).rows[1]
    assert text[:6] == ["noise", "(b)", "", "2 × 2", "2.0 ± 0.0 of 2", "1.5 ± 0.7 of 2"]
    assert robustness.build(frame(rows[:2])).empty
    untested = [score(number=n, protocol="noise", draw=1, stable=None) for n in (1, 2)]
    assert cell(robustness.build(frame(rows[:2] + untested)), protocol="noise")["fallen_mean"] == 0


def test_the_worst_room_is_that_with_the_largest_mean_over_its_things() -> None:
    met = {"protocol": "noise", "draw": 1}
    rows = [score("room_1", 1, l2_cm=1, **met), score("room_1", 2, l2_cm=9, **met), score("room_2", 1, l2_cm=6, **met)]
    assert robustness.build(frame(rows))["worst_room_l2_cm_mean"].tolist() == [6.0]  # one thing is farther off


def test_the_companion_says_what_is_given_and_what_a_judge_is_read_against() -> None:
    for baseline in (False, True):
        rows = [score(), score(protocol="noise", draw=1)]
        rows += [score(variant="no-image"), score(variant="no-image", protocol="noise", draw=1)] if baseline else []
        shown = robustness_table(robustness.build(frame(rows)))
        assert any("given the true label" in note for note in shown.notes)
        assert any("sees no picture" in note for note in shown.notes) == baseline


def test_the_companion_has_its_columns_with_and_without_rows(tmp_path: Path) -> None:
    scored = write_rows(tmp_path / "scores.csv", [score(), score(protocol="noise", draw=1)])
    for name, files, count in (("some", (scored,), 2), ("none", (), 0)):
        run(out=tmp_path / name, scores=files)
        table = pd.read_csv(tmp_path / name / "table2_robustness.csv")
        assert list(table) == robustness.COLUMNS and len(table) == count
        assert sorted(path.suffix for path in (tmp_path / name).iterdir()) == [".csv", ".html", ".tex"]


@pytest.mark.parametrize("shown", ["cabinet_0", "cabinet_2"])
def test_true_models_are_left_out_with_all_their_relatives(tmp_path: Path, shown: str) -> None:
    templates = {"cabinet_0": None, "cabinet_1": None, "cabinet_2": "cabinet_0", "cabinet_3": "cabinet_1"}
    for name, template in {**templates, "cabinet_4": "cabinet_0", "mine_0": None}.items():
        asset = build(sample("box", 0, 0), None, tmp_path / name, name, "cabinet")
        recipe = (
            None if name == "mine_0" else asset.recipe and asset.recipe.model_copy(update={"variation_of": template})
        )
        write_json(tmp_path / name / "asset.json", asset.model_copy(update={"recipe": recipe}))
    write_part(tmp_path / "library.json", tmp_path)
    objects = [true(1, shown, (0, 0, 0)), true(2, "mine_0", (1, 0, 0)), true(3, "gone_0", (2, 0, 0))]
    write_json(tmp_path / "truth.json", TRUTH.model_copy(update={"objects": objects}))
    leave_out.run(truth=tmp_path / "truth.json", library=tmp_path / "library.json", out=tmp_path / "out.json")
    assert read_json(LeftOut, tmp_path / "out.json").assets == ["cabinet_0", "cabinet_2", "cabinet_4", "mine_0"]
