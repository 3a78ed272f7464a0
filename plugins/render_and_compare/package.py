"""The package as the core knows it."""

from pydantic import Field

from plugins.render_and_compare.config import GeometryConfig
from stages.config.packages import Package

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
    draws={"matching": "plugins.render_and_compare.in_place"},
)
