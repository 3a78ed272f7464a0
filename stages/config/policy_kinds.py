"""What tables say of policies, by the config: their kinds in words, what is pooled, how they see test assets."""

from typing import TYPE_CHECKING

from stages.config.evaluation import SensingOptions
from stages.config.tables import PolicyAbout, PolicyTables
from stages.contracts.training_run import TrainingRun
from stages.plugins import shorten_name

if TYPE_CHECKING:
    from stages.config.model import Config

SENSING = ("simulator", "parking", "depth_noise", "camera_error")  # keys of `evaluation` that notes under tables state
PAPERS = TrainingRun().kind  # the paper's network on a cloud, whatever its size


def kind_in_words(run: TrainingRun) -> str:
    """The kind of policy that a hyper-parameter set makes, in words: how it differs from the paper's."""
    traits = [] if run.policy == "bc_rnn_gmm" else [shorten_name(run.policy)]
    traits += ["handle flagged"] if run.handle else []
    traits += [] if run.network.cloud else ["no cloud"]
    return ", ".join(traits) or f"{run.network.pointnet_width}-wide network of the paper's kind"


def about_policies(config: "Config") -> dict[str, PolicyAbout]:
    """The policies of a run that open something."""
    experiment, found = config.experiment, {}
    for name in experiment.policies:
        plan, best = experiment.plan(name), experiment.best_runs if experiment.needs_choice(name) else None
        found[name] = PolicyAbout(runs=plan.runs, best=best, targets=plan.targets)
    return {name: about for name, about in found.items() if about.targets}


def policy_tables(config: "Config") -> PolicyTables:
    """The section `tables`, and what its verbs about policies read of the others."""
    experiment, policies = config.experiment, about_policies(config)
    runs = {name: config.training.runs[about.runs[0]] for name, about in policies.items()}
    tasks = map(config.task_of, experiment.targets)
    sensing = {key: getattr(config.evaluation, key) for key in SENSING}
    return PolicyTables.model_construct(
        **dict(config.tables),
        policies=policies,
        pools=experiment.pools,
        kinds={name: kind_in_words(run) for name, run in runs.items()},
        papers=[name for name, run in runs.items() if run.kind == PAPERS],
        encoder=shorten_name(config.matching_of(experiment.policy_variant).encoder),
        sensing=SensingOptions.model_construct(**sensing),
        starts=sorted({(task.base_xy, task.base_z) for task in tasks}),
    )
