"""The curves of the forecast are those of the published rollouts."""

import tarfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.forecast import FITTED, error, fit_curve, measure_r_squared, of_sets, predict_left_out, read_pairs
from plugins.studies.coverage import CURVES, ERRORS, Curve

ROOT = Path(__file__).resolve().parents[3]
EXPECTED = {"door": (0.51, 0.46), "drawer": (0.23, 0.15)}  # variance accounted for: families, rooms left out


@pytest.fixture(scope="module")
def rollouts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    with tarfile.open(ROOT / "docs/results/registered/rollouts.tar.xz") as archive:
        for file in archive:
            if (content := archive.extractfile(file)) and "/lite/" in file.name and file.name.split("/")[-4] in FITTED:
                (folder / file.name).parent.mkdir(parents=True, exist_ok=True)
                (folder / file.name).write_bytes(content.read())
    return folder


@pytest.mark.parametrize("task", CURVES)
def test_the_curve_is_fitted_on_the_published_rollouts(task: str, rollouts: Path) -> None:
    pairs = read_pairs(rollouts, ROOT / "config/study/assets/registered", task)
    assert len(pairs) == 360 and pairs.family.nunique() in (36, 39)
    shares = pairs.success.to_numpy()
    assert fit_curve(pairs.distance.to_numpy(), shares) == pytest.approx(CURVES[task], abs=2e-4)
    kept = [measure_r_squared(shares, predict_left_out(pairs, groups)) for groups in (pairs.family, pairs.room)]
    assert kept == pytest.approx(EXPECTED[task], abs=0.005)
    assert error(of_sets(pairs)) == pytest.approx(ERRORS[task], abs=0.005)


def test_a_curve_is_found_again_and_groups_are_left_out() -> None:
    distances = np.linspace(0, 4, 40)
    pairs = pd.DataFrame({"distance": distances, "success": Curve(2, 1.5).predict(distances), "training_set": "twin"})
    assert fit_curve(distances, pairs.success.to_numpy()) == pytest.approx((2, 1.5), abs=1e-3)
    pairs.loc[0, "success"] = 0  # its own group: it is forecast by the others, not by itself
    alone = predict_left_out(pairs, ["odd", *["rest", "more"] * 19, "rest"])
    assert alone[0] == pytest.approx(Curve(2, 1.5).predict(0), abs=1e-3)
    assert measure_r_squared(pairs.success.to_numpy()[1:], Curve(2, 1.5).predict(distances)[1:]) == pytest.approx(1)
