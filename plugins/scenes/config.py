"""Config section `scenes`: the sim-to-sim rooms (paper B.1, Table 2)."""

from pydantic import Field

from roomkin.stages.contracts.section import Section


class ScenesConfig(Section):
    """Photographs of the rooms."""

    width: int = Field(800, ge=64, description="Width of the photograph in pixels.")
    height: int = Field(600, ge=48, description="Height of the photograph in pixels.")
    supersampling: int = Field(2, ge=1, le=4, description="Colors are rendered so many times larger and averaged.")
