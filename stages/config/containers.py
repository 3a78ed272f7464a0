"""Config sections `stages` (whole-stage replacement) and `containers` (one table of images)."""

from typing import Literal

from pydantic import Field

from stages.config.base import Section

StageName = Literal[
    "assets",
    "scenes",
    "extraction",
    "matching",
    "generation",
    "demonstrations",
    "training",
    "evaluation",
    "tables",
]


class StageCommand(Section):
    """Replaces a whole stage by a command of yours, in any language."""

    command: str = Field(
        description="Called as `<command> <verb> --flags ...` with the flags of the stage's page in docs/; "
        "what it writes is checked against the contract before the workflow goes on."
    )


class ContainersConfig(Section):
    """Images, one per environment family; every rule names one of them."""

    simulation: str = Field("images/simulation-0.1.0.sif", description="Rules that render or simulate.")
    learning: str = Field("images/learning-0.1.0.sif", description="Rules that train or match.")
    report: str = Field("images/report-0.1.0.sif", description="Rules that only make tables and pages.")
