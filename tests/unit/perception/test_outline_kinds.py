"""What an outline shows, by MobileSAM's features of it."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from safetensors.numpy import save_file

from roomkin.stages.contracts import InputError
from roomkin.stages.perception.layout import things as kinds
from roomkin.stages.perception.segmentation.choosing import Outlined


def test_an_outline_is_its_features_inside_and_around_and_its_place() -> None:
    features = np.zeros((256, 64, 64), np.float32)
    features[0, :, :32], features[0, :, 32:] = 1, 3
    mask = np.zeros((768, 1024), bool)
    mask[128:256, 512:768] = True
    found = kinds.measure_outline(features, mask)
    assert found[0] == pytest.approx(3) and found[512] == pytest.approx(0, abs=1e-3), "mean and spread inside"
    assert 1 < found[256] < 3, "around it both halves"
    features[0, 8:16, 32:48] = 50  # what it covers
    assert kinds.measure_outline(features, mask)[256] == pytest.approx(found[256]), "it is not around itself"
    left, right, top, bottom, side, fill, form, *touches = found[768:]
    assert [left, top] == [0.5, pytest.approx(1 / 6)] and right == pytest.approx(0.75, abs=0.01)
    assert bottom == pytest.approx(1 / 3, abs=0.01) and side == pytest.approx((128 * 256 / mask.size) ** 0.5)
    assert fill == 1 and form == pytest.approx(np.log(2)) and touches == [0, 0, 0, 0]
    mask[:, 700:] = True
    assert kinds.measure_outline(features, mask)[-4:].tolist() == [0, 1, 1, 1]


def test_what_lies_outside_of_the_picture_is_not_around_an_outline() -> None:
    features = np.ones((256, 64, 64), np.float32)
    features[:, 48:] = 9  # the padding below a picture of 4:3
    mask = np.zeros((768, 1024), bool)
    mask[600:, 100:300] = True
    assert kinds.measure_outline(features, mask)[256:512] == pytest.approx(1)


def test_kinds_are_probabilities_by_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    weights = np.zeros((kinds.COLUMNS, 6))
    weights[0, 3] = 1
    monkeypatch.setattr(kinds, "read_weights", lambda: (weights, np.zeros(6)))
    mask = np.zeros((48, 64), bool)
    mask[10:20, 10:30] = True
    told = kinds.tell_kinds(np.full((256, 64, 64), np.log(5), np.float32), [mask, ~mask])
    assert told == pytest.approx(np.array([[0.1, 0.1, 0.1, 0.5, 0.1, 0.1]] * 2), abs=1e-4)
    assert kinds.tell_kinds(np.ones((256, 64, 64), np.float32), []).shape == (0, 6)


def test_an_outline_that_cannot_be_measured_shows_nothing() -> None:
    mask = np.zeros((48, 64), bool)
    mask[10:20, 10:30] = True
    view = SimpleNamespace(embedded=SimpleNamespace(features=np.ones((256, 64, 64), np.float32)))
    found = [Outlined(one, 0.9, "mobile_sam", {}, False) for one in (mask, np.zeros_like(mask))]
    told = kinds.tell_outlines(view, found)  # type: ignore[arg-type]
    assert told[0] == pytest.approx(kinds.tell_kinds(view.embedded.features, [mask])[0])
    assert told[1].tolist() == [kind == kinds.NOTHING for kind in kinds.KINDS]


def test_other_weights_are_refused(tmp_path: Path) -> None:
    save_file({"weights": np.zeros((3, 6), np.float32), "bias": np.zeros(6, np.float32)}, tmp_path / "w.safetensors")
    with pytest.raises(InputError, match="other weights"):
        kinds.read_weights(tmp_path / "w.safetensors")
