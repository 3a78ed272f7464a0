"""Config section `demonstrations`: the Open skill and the collection of its successes (paper A.4, A.5)."""

from typing import Annotated, ClassVar

from pydantic import Field

from roomkin.stages.contracts.section import Range, Section

Share = Annotated[float, Field(gt=0, le=1)]


class MotionOptions(Section):
    """How the scripted skill moves."""

    goal_margin: float = Field(
        0.2, ge=0, le=0.5, description="open this fraction of the range further than success needs, then let go"
    )
    # Where Approach ends and Converge begins, metres (official: 0.13)
    pregrasp: ClassVar[float] = 0.1
    # How far ahead on its path the hand aims, metres
    approach_lookahead: ClassVar[float] = 0.06
    # The same while it holds the handle, metres
    articulate_lookahead: ClassVar[float] = 0.04


class RandomiseOptions(Section):
    """What training sets that end in _randomised draw anew per attempt (the physics after OpenAI et al. 2018)."""

    extents: Range = Field((0.6, 1.5), description="factor per axis on the asset's size, in place of task.scale_range")
    friction: Range = Field(
        (0.7, 1.3), description="factor on the friction of its surfaces, so of handle and fingers (OpenAI: 0.7 to 1.3)"
    )
    mass: Range = Field((0.5, 2.0), description="factor on the mass of its links (OpenAI: 0.5 to 1.5)")
    joint_friction: Range = Field(
        (0.3, 3.0), description="factor on friction and damping of its joints (OpenAI: damping 0.3 to 3)"
    )


class DemonstrationsConfig(MotionOptions):
    """How the scripted skill moves, and how long collection tries."""

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
        (1.0, 1.0),
        description="between these shares of a full step the approach advances, drawn per attempt: [0.5, 1] keeps "
        "policies from counting steps",
    )
    randomise: RandomiseOptions = Field(
        RandomiseOptions(),
        description="Ranges of training sets that end in _randomised, log-uniform but for the extents; after OpenAI et "
        "al., Learning Dexterous In-Hand Manipulation, Table 1.",
    )
    max_attempts_factor: float = Field(3.0, ge=1, description="attempts allowed per wanted episode")
