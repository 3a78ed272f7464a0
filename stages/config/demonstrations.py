"""Config section `demonstrations`: the Open skill and the collection of its successes (paper A.4, A.5)."""

from typing import Annotated

from pydantic import Field

from stages.config.base import Section

Share = Annotated[float, Field(gt=0, le=1)]


class DemonstrationsConfig(Section):
    """How the scripted skill moves, and how long collection tries."""

    goal_margin: float = Field(
        0.2, ge=0, le=0.5, description="open this fraction of the range further than success needs, then let go"
    )
    pregrasp: float = Field(0.1, gt=0, description="where Approach ends and Converge begins, metres (official: 0.13)")
    approach_lookahead: float = Field(0.06, gt=0, description="how far ahead on its path the hand aims, metres")
    articulate_lookahead: float = Field(0.04, gt=0, description="the same while it holds the handle, metres")
    noise: float = Field(
        0.005,
        ge=0,
        description="standard deviation of the noise on executed actions, metres per step; the recorded action is "
        "the clean one, so that policies see how to recover (DART, Laskey et al. 2017)",
    )
    recovery: float = Field(
        0.25,
        ge=0,
        le=1,
        description="share of attempts in which the hand is pushed off its path, or closes before it is at the handle, "
        "and has to come again; recorded is what the skill asks for meanwhile, not what is executed",
    )
    approach_speed: tuple[Share, Share] = Field(
        (1.0, 1.0), description="between these shares of a full step the approach advances, drawn per attempt"
    )
    max_attempts_factor: float = Field(3.0, ge=1, description="attempts allowed per wanted episode")
    film_episodes: int = Field(1, ge=1, description="successes that are filmed")
