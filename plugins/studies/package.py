"""The package as the core knows it."""

from collections.abc import Iterator
from typing import Any

from roomkin.plugins.studies.pinned_file import pinned_assets
from roomkin.stages.config.evaluation import MethodTables
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.packages import Package


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Committed assets that are not as targets say; skills under conditions, without the package of skills."""
    yield from pinned_assets(config)
    if not config.packages.get("scripted"):
        what = "is off or not here, and studies roll its skill out under every condition"
        yield Mistake("packages.scripted", what, "packages: {scripted: true}, or {studies: false}, too")


PACKAGE = Package(commands={"conditions": MethodTables, "pinned": None}, section="tables", mistakes=find_mistakes)
