"""The words of tables for policies, by the config: their kinds in words, what is pooled, how they see test assets."""

from typing import TYPE_CHECKING

from roomkin.stages.config.evaluation import SensingOptions
from roomkin.stages.config.tables import PolicyAbout, PolicyTables
from roomkin.stages.contracts.policy_config import PolicyConfig, has_eyes
from roomkin.stages.plugins import find_options, parse_kwargs, shorten_name

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config

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
    return ", ".join(traits) or f"{read_width(config)}-wide network of the paper's kind"


def read_width(config: PolicyConfig) -> int:
    """How wide the PointNet of a policy of the paper's kind is."""
    width: int = parse_kwargs(find_options("policies", config.policy), config.kwargs).model_dump()["pointnet_width"]
    return width


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
