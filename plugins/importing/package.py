"""The package as the core knows it."""

from collections.abc import Mapping
from typing import Any

from roomkin.stages.config.assets import AssetsConfig, OwnOptions
from roomkin.stages.config.packages import Package


def shards_of(config: AssetsConfig) -> Mapping[str, Any]:
    """The models of `assets.folders` in shards, by name."""
    if not config.folders:
        return {}
    from roomkin.plugins.importing.shards import own_shards  # takes two seconds

    return own_shards(config)


PACKAGE = Package(commands={"own": OwnOptions}, section="assets", shards=shards_of)
