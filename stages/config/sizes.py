"""Defaults that follow the size of the library: `null` in `assets.shards` and `matching`."""

from typing import Any

from roomkin.stages.config.model import Config

LARGE = 2_000  # models: beyond, features are compressed and candidates shortlisted (docs/matching.md)
DIMENSIONS, SHORTLIST = 72, 100
PER_SHARD = 300  # models: 780 MB of features as they are


def fill_counts(config: Config, models: int) -> Config:
    """The config with numbers where it says null, for a library of so many models."""
    procedural = sum(config.assets.counts.values())
    large = models > LARGE
    assets = _fill_section(config.assets, shards=max(2, -(-procedural // PER_SHARD)))
    matching = _fill_section(config.matching, dimensions=DIMENSIONS * large, shortlist=SHORTLIST * large)
    return config.model_copy(update={"assets": assets, "matching": matching})


def _fill_section(section: Any, **numbers: int) -> Any:
    """A section with these numbers under those of their keys that are null."""
    return section.model_copy(update={key: value for key, value in numbers.items() if getattr(section, key) is None})
