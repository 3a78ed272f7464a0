"""What this package reads of the config section `photo`."""

from stages.contracts.section import Section


class DrawOptions(Section):
    """Of one photograph: degrees over its width, calibration of its lens, heights that are known, metres, by label."""

    field_of_view: float | None = None
    lens: str | None = None
    heights: dict[str, float] = {}
