"""A run names the pages that it made."""

import os
from pathlib import Path

from plugins.report.made import name_pages


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
