"""Sections `demonstrations` (paper A.4, A.5) and `training` (B.3), and the words of tables for what they make."""

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from roomkin.stages.config.evaluation import PolicyAbout, PolicyTables, SensingOptions
from roomkin.stages.contracts.policy_config import PolicyConfig, has_eyes
from roomkin.stages.contracts.section import Range, Section
from roomkin.stages.plugins import find_options, parse_kwargs, shorten_name

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


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
    randomise: RandomiseOptions = Field(
        RandomiseOptions(),
        description="Ranges of training sets that end in _randomised, log-uniform but for the extents; after OpenAI et "
        "al., Learning Dexterous In-Hand Manipulation, Table 1.",
    )
    max_attempts_factor: float = Field(3.0, ge=1, description="attempts allowed per wanted episode")


# What a policy needs to go by the handle, chosen on validation assets (docs/policies.md).
LITE_HANDLE = PolicyConfig(release_included=False, handle=True)


class TrainingSection(Section):
    """How policies are trained."""

    configs: dict[str, PolicyConfig] = Field(
        {"lite": PolicyConfig(), "lite_handle": LITE_HANDLE},
        description="Policy configs by name; `experiment.policies` says which are trained. Keys that one of your own "
        "does not name have the values of `lite`. `lite_handle` goes by the handle; config/paper/policies.yaml has the "
        "paper's, for a GPU. The options of each kind of policy, `kwargs`, are at the end of docs/config.md.",
    )


# Keys of `evaluation` that notes under tables state.
SENSING = ("simulator", "robot_init_noise", "depth_noise", "camera_error")
PAPERS = ("bc_rnn_gmm", False, True)  # kind of the paper's policies, whatever their size


def list_traits(config: PolicyConfig) -> tuple[str, bool, bool]:
    """The keys that make it another kind of policy, not the same with other hyper-parameters."""
    return config.policy, config.handle, has_eyes(config)


def kind_in_words(config: PolicyConfig) -> str:
    """The kind of policy that a config makes, in words: how it differs from the paper's."""
    traits = [] if config.policy == "bc_rnn_gmm" else [shorten_name(config.policy)]
    traits += ["handle flagged"] if config.handle else []
    traits += [] if has_eyes(config) else ["no cloud"]
    if traits:
        return ", ".join(traits)
    options = parse_kwargs(find_options("policies", config.policy), config.kwargs).model_dump()
    return f"{options['pointnet_width']}-wide network of the paper's kind"


def about_policies(config: "Config") -> dict[str, PolicyAbout]:
    """The policies of a run that open something."""
    experiment, found = config.experiment, {}
    for name in experiment.policies:
        plan, best = experiment.plan(name), experiment.best_configs if experiment.needs_choice(name) else None
        found[name] = PolicyAbout(configs=plan.configs, best=best, targets=plan.targets)
    return {name: about for name, about in found.items() if about.targets}


def policy_tables(config: "Config") -> PolicyTables:
    """The section `tables`, and what its commands about policies read of the others."""
    experiment, policies = config.experiment, about_policies(config)
    trained = {name: config.training.configs[about.configs[0]] for name, about in policies.items()}
    tasks = map(config.task_of, experiment.targets)
    sensing = {key: getattr(config.evaluation, key) for key in SENSING}
    return PolicyTables.model_construct(
        **dict(config.tables),
        policies=policies,
        pools=experiment.pools,
        kinds={name: kind_in_words(each) for name, each in trained.items()},
        papers=[name for name, each in trained.items() if list_traits(each) == PAPERS],
        encoder=shorten_name(config.matching_of(experiment.policy_variant).encoder),
        sensing=SensingOptions.model_construct(**sensing),
        starts=sorted({(task.base_xy, task.base_z) for task in tasks}),
    )
