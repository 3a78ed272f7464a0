"""Config section `training`: hyper-parameter sets ("runs") of the policies (paper B.3)."""

from pydantic import Field

from stages.contracts.section import Section
from stages.contracts.training_run import TrainingRun
from stages.plugins import qualify_module

# What a policy needs to go by the handle, chosen on validation assets (docs/policies.md).
LITE_HANDLE = TrainingRun(let_go=False, handle=True)


class TrainingConfig(Section):
    """How policies are trained."""

    runs: dict[str, TrainingRun] = Field(
        {"lite": TrainingRun(), "lite_handle": LITE_HANDLE},
        description="Hyper-parameter sets by name; `experiment.runs` says which are trained. Keys that a set of your "
        "own does not name have the values of `lite`. `lite_handle` goes by the handle; config/paper/policies.yaml has "
        "the paper's, for a GPU.",
    )


def list_policy_modules(run: TrainingRun) -> list[str]:
    """Modules of the code behind the kind of policy that a hyper-parameter set makes."""
    return [qualify_module("policies", run.policy), *[qualify_module("markers", "handle")] * run.handle]
