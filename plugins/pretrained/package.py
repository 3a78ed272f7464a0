"""The package as the core knows it."""

from typing import Any

from roomkin.stages.config.packages import Package


def list_needed_files(config: Any) -> list[str]:
    """The weights of the networks that look at pictures without depth."""
    asked = config.experiment.pictures and config.perception.asks_networks()
    return [*config.perception.networks().values()] if asked else []


PACKAGE = Package(outside=list_needed_files)
