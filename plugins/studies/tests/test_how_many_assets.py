"""`benchmarks.how_many_assets`: draws of small studies, where their error comes from, the paper's table by assets."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import how_many_assets
from benchmarks.how_many_assets import draw_effects, errors, papers_table, successes, summarise_effects, variances
from tests.unit.tables_results import rollout, write_rows

PUBLISHED = Path(__file__).parents[3] / "report" / "published"
SIZES = {"object": 0.2, "asset": 0.4, "run": 0.1, "asset x run": 0.15, "start": 0.3, "rollout": 0.25}


def effects(objects: int = 40, assets: int = 30, starts: int = 4, runs: int = 5) -> np.ndarray:
    """Effects (objects, assets, starts, runs) with a deviation of `SIZES` for every source."""
    random = np.random.default_rng(3)
    shapes = [(objects, 1, 1, 1), (objects, assets, 1, 1), (objects, 1, 1, runs), (objects, assets, 1, runs)]
    shapes += [(objects, assets, starts, 1), (objects, assets, starts, runs)]
    parts = [size * random.normal(size=shape) for size, shape in zip(SIZES.values(), shapes, strict=True)]
    return 0.1 + sum(parts)


def test_every_source_of_error_is_found() -> None:
    found = variances(effects())
    assert set(found) == set(SIZES)
    for name, size in SIZES.items():
        assert found[name] ** 0.5 == pytest.approx(size, rel=0.25), name


def test_the_error_of_a_mean_falls_with_what_there_is_more_of() -> None:
    found = {name: size**2 for name, size in SIZES.items()}
    once = errors(found, 1, 1, 1, 1)
    assert once == pytest.approx(SIZES)
    assert errors(found, 4, 9, 1, 1)["asset"] == pytest.approx(0.4 / 6)
    assert errors(found, 4, 9, 1, 1)["object"] == errors(found, 4, 1, 1, 25)["object"] == pytest.approx(0.1)
    assert errors(found, 1, 1, 4, 25)["rollout"] == pytest.approx(0.025)


def test_small_studies_read_the_effect_on_average_and_more_assets_narrow_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(how_many_assets, "DRAWS", 4000)
    ours, theirs = np.zeros((2, 3, 8, 4, 2))
    ours[0, :4], ours[1, :6], ours[2, :2] = 1, 1, 1  # objects of which a half, three quarters, a quarter gain
    few, many = (draw_effects(ours, theirs, 1, assets, 2) for assets in (1, 40))
    assert few.mean() == pytest.approx(0.5, abs=0.03) and many.mean() == pytest.approx(0.5, abs=0.03)
    assert set(few) == {0, 1} and (few <= 0).mean() == pytest.approx(0.5, abs=0.03)
    assert (many <= 0).mean() == 0 and many.std() == pytest.approx(0.2, abs=0.03)  # what is left is the object
    assert draw_effects(ours, theirs, 3, 40, 2).std() == pytest.approx(many.std() / 3**0.5, abs=0.02)
    assert summarise_effects(few).startswith("0 to +100, ") and summarise_effects(many).endswith(", 0 %")


def test_successes_are_laid_out_by_object_asset_start_and_run(tmp_path: Path) -> None:
    for room in (1, 2):
        for seed in (0, 1):
            rows = [
                rollout(4 * asset + start, asset > start and seed == 1, target=f"door_room_{room}", seed=seed,
                        test_asset="test", asset=f"cabinet_{asset}", initial_state=start)
                for asset in (2, 0, 1) for start in (0, 1)
            ]  # fmt: skip
            rows.append(rollout(99, True, target=f"door_room_{room}", seed=seed))  # on the twin: does not count
            write_rows(tmp_path / f"door_room_{room}/lite/twin/lite/seed_{seed}/rollouts.csv", list(rows))
    found = successes(tmp_path, "door", "twin")
    assert found.shape == (2, 3, 2, 2)
    assert found[1, :, :, 1].tolist() == [[0, 0], [1, 0], [1, 1]] and not found[..., 0].any()


def test_the_papers_table_with_three_assets_as_units() -> None:
    lines = {(task, name): line for task, name, *line in papers_table(PUBLISHED)}
    assert lines["door", "cousins_8"] == ["+12", "+26", "+12", "+16 [-4, 37]"]
    assert lines["drawer", "cousins_8"] == ["+6", "+14", "+51", "+24 [-37, 84]"]
    assert len(lines) == 9 and not any(name == "twin" for _, name in lines)
