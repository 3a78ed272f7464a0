"""Config section `containers`: one table of images."""

from pydantic import Field

from stages.config.base import Section


class ContainersConfig(Section):
    """Images, one per environment family; every rule names one of them."""

    simulation: str = Field("images/simulation-0.1.0.sif", description="Rules that render or simulate.")
    learning: str = Field("images/learning-0.1.0.sif", description="Rules that train or match.")
    report: str = Field("images/report-0.1.0.sif", description="Rules that only make tables and pages.")
