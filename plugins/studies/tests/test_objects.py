"""Differences over objects, of made-up rollouts and of made-up studies."""

from pathlib import Path

import pandas as pd
import pytest

from roomkin.plugins.studies import objects
from tests.refusals import refused
from tests.unit.tables_results import rollout, write_rows


def put(folder: Path, target: str, name: str, opened: int) -> None:
    """Rollouts on ten unseen assets, so many of which are opened, and on the twin, which nobody counts."""
    rows = [
        rollout(n, n < opened, target=target, training_set=name, test_asset="test", asset=f"a_{n}") for n in range(10)
    ]
    rows += [rollout(0, True, target=target, training_set=name)]
    path = folder / "results/evaluation/policies" / target / "lite" / name / "rollouts.csv"
    path.parent.mkdir(parents=True)
    write_rows(path, rows)


def test_an_object_of_each_library_is_a_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for folder, gain in (("one", 2), ("two", 4)):
        put(tmp_path / folder, "door_1", "twin", 3)
        put(tmp_path / folder, "door_1", "cousins_8", 3 + gain)
    put(tmp_path / "two", "door_2", "twin", 1)
    folders = (tmp_path / "one/results", tmp_path / "two/results")
    found = objects.compare(objects.read_rates(folders), "cousins_8", "twin")
    assert found.to_dict() == pytest.approx({"one/door_1": 0.2, "two/door_1": 0.4})
    objects.run(results=folders)
    said = capsys.readouterr().out
    assert "cousins_8 minus twin, two/door_1: +40 points" in said
    assert "cousins_8 minus twin: +30.0 points [-97, 157], 2 objects" in said


def test_without_rollouts_it_says_so(tmp_path: Path) -> None:
    with refused("E-ROLLOUTS-MISSING"):
        objects.read_rates((tmp_path,))


def test_a_forecast_says_yes_where_much_is_there_and_hardly_where_nothing_is() -> None:
    (many, _), (few, _), (none, _) = (
        objects.forecast(gain, count, 20, tries=300) for gain, count in ((0.25, 16), (0.25, 3), (0.0, 16))
    )
    assert many > 0.95 and few < 0.4 and none < 0.06


def test_nothing_shared_is_no_difference() -> None:
    assert objects.compare(pd.DataFrame({"twin": {"a": 0.5}}), "cousins_8", "twin").empty
