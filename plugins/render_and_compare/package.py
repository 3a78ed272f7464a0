"""The package as the core knows it."""

from pydantic import Field

from roomkin.plugins.render_and_compare.config import GeometryConfig
from roomkin.stages.config.packages import Package

PACKAGE = Package(
    judges=True,
    sections={
        "geometry": (
            GeometryConfig,
            Field(
                GeometryConfig(), description="The judge `geometry`: candidates rendered in place (docs/matching.md)."
            ),
        )
    },
    draws={"matching": "roomkin.plugins.render_and_compare.in_place"},
)
