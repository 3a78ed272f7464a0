"""Config section `single_view`: one photograph without depth -> a drawing, by lines, outlines and usual sizes."""

from pydantic import Field

from stages.contracts.section import Section


class SingleViewSection(Section):
    """From a photograph to a drawing; how its camera sees is told in section `photo`."""

    heights: dict[str, float] = Field(
        {}, description="Heights that you know, metres: of the `camera`, of things by label: {fridge: 1.8}."
    )


class DrawOptions(SingleViewSection):
    """The section, with degrees over the picture's width and calibration of its lens, of section `photo`."""

    field_of_view: float | None = None
    lens: str | None = None
