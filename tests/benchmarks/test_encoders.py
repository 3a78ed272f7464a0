"""What row (b) is changed by, what is kept, and what is read of another run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.encoders import Change, KeptRows, drain, read_rivals, to_unit
from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.matching.encoders import EXTRA_COLUMNS, make_encoder
from tests.unit.matching_data import view_of_box


def test_a_picture_without_color_has_one_channel_three_times() -> None:
    view = view_of_box(0.4)
    red = drain(replace(view, rgb=np.full_like(view.rgb, (255, 0, 0))))
    assert (red.rgb == 76).all() and red.mask is view.mask


def test_features_become_unit_vectors_and_places_stay() -> None:
    rows = np.arange(1, 2 * (3 + EXTRA_COLUMNS) + 1, dtype=np.float16).reshape(2, -1)
    changed = to_unit(rows)
    assert np.linalg.norm(changed[:, :3], axis=1) == pytest.approx(1)
    assert (changed[:, 3:] == rows[:, 3:]).all()


def test_a_picture_is_encoded_once(tmp_path: Path) -> None:
    kept = KeptRows(make_encoder(EncoderOptions()), tmp_path, Change(position=0.5))
    first = kept.rows("one", lambda: view_of_box(0.4))
    again = kept.rows("one", lambda: pytest.fail("it was read again"))
    assert (first == again).all() and kept.encoded == 1
    weights = kept.weights(depth=False)
    assert weights[-EXTRA_COLUMNS : 2 - EXTRA_COLUMNS].tolist() == [0.5, 0.5]


def test_the_models_of_another_run_are_read(tmp_path: Path) -> None:
    line = "| room_1 | cabinet_1 | bottom_cabinet | bottom_cabinet_02 | sideboard | sideboard_02 |"
    (tmp_path / "run.md").write_text(
        f"| room | object | a | b | c | d |\n|---|---|---|---|---|---|\n{line}\n\n1 object\n"
    )
    assert read_rivals(tmp_path / "run.md") == {("room_1", "cabinet_1"): "sideboard_02"}
