"""The benchmark of all encoders, on three models."""

import sys

import pytest

from plugins.patchnet import benchmark


def test_the_benchmark_of_encoders_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    given = "--models 1 --queries 1 --categories stool bottle chair --encoders hog patchnet"
    monkeypatch.setattr(sys, "argv", ["benchmark", *given.split()])
    benchmark.main()
    printed = capsys.readouterr().out
    assert "3 models in 3 categories, 3 pictures" in printed and "never saw (1)" in printed
    rows = [line.split("|") for line in printed.splitlines() if line.startswith("| patchnet, depth")]
    assert len(rows) == 3 and all(0 <= float(row[2]) <= 100 for row in rows)
