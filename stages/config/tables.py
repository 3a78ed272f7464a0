"""Config section `tables`: tables, figures and the report page."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from roomkin.stages.config.evaluation import SensingOptions
from roomkin.stages.contracts.section import Section, Seed


class TablesConfig(Section):
    """How rows of `evaluation` become the paper's tables."""

    scenes: dict[str, Annotated[int, Field(ge=1, le=8)]] = Field(
        {f"room_{k}": k for k in range(1, 9)},
        description="Scenes of Table 2 and the published scene (1 ... 8, in the paper's order) shown beside each. "
        "Every one gets its rows, 'not run' where nothing was computed.",
    )
    variants: dict[str, Literal["a", "b", "c", "d"]] = Field(
        {"a": "a", "b": "b", "c": "c", "d": "d"},
        description="Variants of Table 2 and the published variant (a-d) shown beside each.",
    )
    # Level of every interval.
    confidence: ClassVar[float] = 0.95
    bootstrap_samples: int = Field(
        10_000,
        ge=100,
        description="Resamples (of assets, initial states and runs) behind the intervals of policies.",
    )
    # Seed of the resamples.
    seed: ClassVar[Seed] = 0
    # Largest width of a picture in the report page, pixels.
    picture_width: ClassVar[int] = 1100
    # WebP quality of the pictures in the report page.
    picture_quality: ClassVar[int] = 80


class PolicyAbout(Section):
    """A policy of the experiment.

    best: how many of its configs are chosen, to be pooled; None: there is one. targets: what it opens.
    """

    configs: list[str]
    best: int | None = None
    targets: list[str]


class MethodTables(TablesConfig):
    """Policies and pools of targets by their names, as far as they are known."""

    policies: dict[str, PolicyAbout] = {}
    pools: dict[str, list[str]] = {}


class PolicyTables(MethodTables):
    """Facts about the policies for the tables, as far as they are known.

    kinds: policy -> its kind in words. papers: policies of the paper's kind. encoder: that whose features give the
    distance from the twin. sensing: how policies see the test assets. starts: per target, how far the robot starts off
    its place before the handle, along and up, metres.
    """

    kinds: dict[str, str] = {}
    papers: list[str] = []
    encoder: str = ""
    sensing: SensingOptions | None = None
    starts: list[tuple[float, float]] = []
