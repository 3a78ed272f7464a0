"""The package as the core knows it."""

from collections.abc import Iterator
from typing import Any

from roomkin.stages.config.evaluation import PolicyTables, TablesConfig
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.packages import Package


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Pages show what the package `pictures` draws."""
    if not config.packages.get("pictures"):
        what = "is off or not here, and pages of the report show its pictures"
        yield Mistake("packages.pictures", what, "packages: {pictures: true}, or {report: false}, too")


PACKAGE = Package(
    commands={"viewer": None, "report": PolicyTables, "overview": None, "picture": TablesConfig},
    section="tables",
    mistakes=find_mistakes,
)
