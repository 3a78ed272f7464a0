"""The package as the core knows it, and its config section `geometry`."""

from typing import ClassVar

from pydantic import Field

from roomkin.stages.config.packages import Package
from roomkin.stages.contracts.section import Section


class GeometryConfig(Section):
    """Weights with which a candidate, rendered in the object's place, is compared with it."""

    nearest: int = Field(30, ge=1, description="So many models, the nearest by distance, are rendered and compared.")
    # Cells along the longer side of the compared pictures.
    resolution: ClassVar[int] = 96
    outline: float = Field(1.0, ge=0, description="Weight of the overlap of the outlines, 0 to 1.")
    depth: float = Field(0.5, ge=0, description="Weight of the agreement of depth, 0 to 1.")
    lines: float = Field(0.5, ge=0, description="Weight of the agreement of lines: doors, drawers, handles; 0 to 1.")
    colour: float = Field(0.0, ge=0, description="Weight of the agreement of colors, 0 to 1.")
    # Taken off for stretching axes unlike: per unit of the logarithms' range.
    proportions: ClassVar[float] = 0.3

    @property
    def perfect(self) -> float:
        """The score where everything agrees."""
        return self.outline + self.depth + self.lines + self.colour


ABOUT = "The judge `geometry`: candidates rendered in place (docs/matching.md)."
PACKAGE = Package(
    judges=True,
    sections={"geometry": (GeometryConfig, Field(GeometryConfig(), description=ABOUT))},
    draws={"matching": "roomkin.plugins.render_and_compare.in_place"},
)
