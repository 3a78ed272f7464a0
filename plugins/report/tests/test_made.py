"""A run names the pages that it made, or why jobs failed."""

import os
from pathlib import Path

from roomkin.plugins.report.made import list_causes, name_pages


def test_new_pages_are_named_and_the_report_stands_for_all(tmp_path: Path) -> None:
    scenes = tmp_path / "results/report/scenes"
    scenes.mkdir(parents=True)
    assert name_pages(tmp_path, 0) == ""
    for name in "abcd":
        (scenes / f"{name}.html").write_text("")
    os.utime(scenes / "a.html", (5, 5))
    assert name_pages(tmp_path, 10) == f"Open {scenes / 'b.html'}, {scenes / 'c.html'}, {scenes / 'd.html'}"
    assert name_pages(tmp_path, 0).endswith("c.html and 1 more beside")
    report = tmp_path / "results/report/index.html"
    report.write_text("")
    assert name_pages(tmp_path, 10) == f"Open {report}"
    os.utime(report, (5, 5))
    assert str(report) not in name_pages(tmp_path, 10)


def test_of_a_run_without_a_page_the_new_tables_are_named(tmp_path: Path) -> None:
    tables, scenes = tmp_path / "results/tables", tmp_path / "results/report/scenes"
    tables.mkdir(parents=True)
    for name in ("table2.html", "table2.csv", "trainings.html"):
        (tables / name).write_text("")
    os.utime(tables / "trainings.html", (5, 5))
    assert name_pages(tmp_path, 10) == f"Open {tables / 'table2.html'}"
    scenes.mkdir(parents=True)
    (scenes / "a.html").write_text("")
    assert name_pages(tmp_path, 10) == f"Open {scenes / 'a.html'}"


def test_the_causes_of_a_failed_run_are_the_last_errors_of_its_jobs_logs(tmp_path: Path) -> None:
    line = "=" * 47
    shown = [
        "Error in rule a:",
        *("Logfile logs/a.log:", line, "12 models", "error: a.png: is broken. Fix: mend it [E-A]", "make: ***", line),
        *("Logfile logs/b.log:", line, "Traceback", "ZeroDivisionError: division by zero", "", line),
        *("Logfile logs/c.log:", line, "error: a.png: is broken. Fix: mend it [E-A]", line),
        *("Logfile logs/d.log:", line, "", line),
        "Exiting because a job execution failed.",
    ]
    (tmp_path / "log").write_text("\n".join(shown))
    causes = ["error: a.png: is broken. Fix: mend it [E-A]", "ZeroDivisionError: division by zero"]
    assert list_causes([str(tmp_path / "log")]) == causes
