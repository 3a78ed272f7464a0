"""What the tables of policies must know of a run: which policies are one method, and what policies are told."""

from typing import TYPE_CHECKING

from stages.config.evaluation import SensingOptions
from stages.config.tables import PolicyRow, PolicyTables
from stages.contracts.training_run import TrainingRun
from stages.plugins import short

if TYPE_CHECKING:
    from stages.config.model import Config

TOLD = ("simulator", "parking", "depth_noise", "camera_error")  # of how test assets are met


def described(run: TrainingRun) -> str:
    """The kind of policy that a hyper-parameter set makes, for people: what tells it from the paper's."""
    traits = [] if run.policy == "bc_rnn_gmm" else [short(run.policy)]
    traits += ["handle flagged"] if run.handle else []
    traits += [] if run.network.cloud else ["no cloud"]
    return ", ".join(traits) or f"{run.network.pointnet_width}-wide network of the paper's kind"


def policy_rows(config: "Config") -> dict[str, PolicyRow]:
    """The rows of the policy experiment."""
    experiment = config.experiment
    best = {name: experiment.best_runs if experiment.chooses(name) else None for name in experiment.tasks}
    return {name: PolicyRow(runs=experiment.plan(name).runs, best=best[name]) for name in experiment.tasks}


def policy_tables(config: "Config") -> PolicyTables:
    """The section `tables`, and what its verbs about policies read of the others."""
    rows, experiment = policy_rows(config), config.experiment
    tasks = [config.task_of(name) for name in rows]
    runs = dict.fromkeys(run for row in rows.values() for run in row.runs)
    met = {key: getattr(config.evaluation, key) for key in TOLD}
    return PolicyTables.model_construct(
        **dict(config.tables),
        rows=rows,
        kinds={run: described(config.training.runs[run]) for run in runs},
        encoder=short(config.matching_of(experiment.policy_variant).encoder),
        met=SensingOptions.model_construct(**met),
        starts=sorted({(task.base_xy, task.base_z) for task in tasks}),
    )
