"""The second study as it was registered: its objects, its assets, the forecast of every policy."""

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.forecast_cells import forecast_cells
from stages.config.model import Config, read_files
from stages.contracts import TaskAssets, read_json

ROOT = Path(__file__).resolve().parents[3]
FORECAST = ROOT / "docs/results/second/forecast.csv"


@pytest.fixture(scope="module")
def config() -> Config:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return read_files((Path("config.yaml"), Path("config/study/second.yaml")))


def plans(config: Config) -> dict[str, TaskAssets]:
    return {row: read_json(TaskAssets, ROOT / str(target.assets)) for row, target in config.experiment.targets.items()}


def test_every_object_is_another_model_and_is_tested_on_forty_families_that_nobody_trains_on(config: Config) -> None:
    found = plans(config)
    for task in ("door", "drawer"):
        twins = [plan.assets[0].asset for row, plan in found.items() if row.startswith(task)]
        assert len(twins) == len(set(twins)) == 24
    for row, plan in found.items():
        target = config.experiment.targets[row]
        assert (plan.scene, plan.object) == (target.room, target.object)
        assert len({asset.family for asset in plan.test_assets}) == 40
        assert {asset.hinge for asset in plan.test_assets} == {plan.assets[0].hinge}
    tested = {asset.family for plan in found.values() for asset in plan.test_assets}
    assert len(tested) > 200, "families are many over all objects"


def test_sets_by_chance_are_other_assets_in_the_second_run(config: Config) -> None:
    for plan in plans(config).values():
        assert plan.draws == 2
        for rule in ("random", "cover"):
            first, second = (plan.list_drawn(rule)[k * plan.length(rule) :][:8] for k in (0, 1))
            assert len({asset.family for asset in first}) == len({asset.family for asset in second}) == 8
            assert {asset.asset for asset in first} != {asset.asset for asset in second}


def test_the_forecast_is_that_of_the_committed_assets(config: Config, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    told, again = pd.read_csv(FORECAST), forecast_cells(config)
    pd.testing.assert_frame_equal(told, again, rtol=1e-4)
    assert len(told) == 48 * 4 * 2
