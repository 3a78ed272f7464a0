"""Command `viewer`: the script by which pages turn a scene."""

from importlib.resources import files
from pathlib import Path

from roomkin.stages.contracts.files import write_text


def run(*, out: Path) -> None:
    """Write three.min.js, to which pages about scenes link.

    Args:
        out: the file.
    """
    write_text(out, (files("roomkin.plugins.report.page.three") / "three.min.js").read_text(encoding="utf-8"))
