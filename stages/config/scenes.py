"""Config section `scenes`: the sim-to-sim rooms (paper B.1, Table 2)."""

from pydantic import Field

from stages.contracts.section import Section


class ScenesConfig(Section):
    """Photographs of the rooms."""

    width: int = Field(800, ge=64, description="Width of the photograph in pixels.")
    height: int = Field(600, ge=48, description="Height of the photograph in pixels.")
    supersampling: int = Field(2, ge=1, le=4, description="Colours are rendered so many times larger and averaged.")
    shadows: bool = Field(True, description="Whether the key light casts shadows.")
    margin: float = Field(
        0.06,
        ge=0,
        lt=0.4,
        description="Share of the picture left free at each border; extraction uses 90 %.",
    )
