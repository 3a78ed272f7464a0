"""Config section `training`: how policies are trained (paper B.3)."""

from pydantic import Field

from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.section import Section

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
