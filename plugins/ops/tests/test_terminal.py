"""What a run says: a line when a job starts, one when it has ended; all of a job is in Snakemake's own log."""

import re
from pathlib import Path

import pytest

from stages import cli
from tests.workflow.workspace import dry_run, make, snakemake

SCRIPT = "results/report/three.min.js"


def test_a_job_has_two_lines_and_its_whole_story_is_in_the_log(tmp_path: Path) -> None:
    folder = make(tmp_path / "clone")
    done = snakemake(folder, SCRIPT)
    assert done.returncode == 0, done.stdout
    lines = done.stdout.splitlines()
    said = [line.partition("] ")[2] for line in lines if re.match(r"\[\d\d:\d\d:\d\d\] ", line)]
    assert said == ["viewer, log: logs/tables/viewer.log", f"1 of 1 steps (100%) done: viewer -> {SCRIPT}"]
    assert len(lines) < 20, done.stdout
    log = next((folder / ".snakemake/log").glob("*.log")).read_text()
    for word in ("reason: Missing output files", "resources: ", "jobid: ", f"output: {SCRIPT}", "Finished jobid"):
        assert word in log and word not in done.stdout


def test_why_a_job_runs_again_is_said(tmp_path: Path) -> None:
    folder = make(tmp_path / "clone")
    (folder / SCRIPT).parent.mkdir(parents=True)
    (folder / SCRIPT).touch()
    done = snakemake(folder, SCRIPT, "--forcerun", "viewer")
    assert "] viewer, log: logs/tables/viewer.log, because: Forced execution" in done.stdout, done.stdout


def test_a_dry_run_says_all_of_a_job(tmp_path: Path) -> None:
    told = dry_run(make(tmp_path / "clone"), SCRIPT).stdout
    assert "reason: Missing output files" in told and f"output: {SCRIPT}" in told and "resources: " in told


def test_a_job_that_fails_is_told_at_length(tmp_path: Path) -> None:
    folder = make(tmp_path / "clone")
    (folder / "mine.yaml").write_text(
        "stages: {report: {viewer: {command: 'echo error: no ink >&2; false', code: []}}}"
    )
    done = snakemake(folder, SCRIPT, "--configfile", "mine.yaml")
    assert done.returncode == 1 and "Error in rule viewer:" in done.stdout, done.stdout
    assert "Logfile logs/tables/viewer.log:" in done.stdout and "error: no ink" in done.stdout


def test_progress_is_told_now_and_then(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(0, 1000, 2))  # two seconds a look
    monkeypatch.setattr("stages.cli.time.monotonic", lambda: float(next(clock)))
    assert list(cli.progress(range(6), "models", 6)) == [*range(6)]
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2 and told[0].startswith("models: 3/6 [00:")
