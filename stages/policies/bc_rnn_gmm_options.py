"""Options of policies that see clouds by the paper's PointNet, and of `bc_rnn_gmm` (B.3); the defaults are `lite`."""

from typing import Literal

from pydantic import Field

from roomkin.stages.contracts.section import Rank, Section

FLAG_EMBEDDING = 128  # learned embedding of the finger flag (paper)


class PointCloudOptions(Section):
    """How clouds are normalised and encoded."""

    cloud: bool = Field(True, description="false: a policy without eyes, by proprioception alone (a baseline)")
    cloud_frame: Literal["robot", "gripper"] = Field(
        "gripper", description="origin of the cloud: robot base (paper), or the end-effector, axes kept"
    )
    standardise: bool = Field(True, description="shift and scale clouds to unit variance (official: raw metres)")
    min_std: float = Field(
        0.0,
        ge=0,
        description="of the median spread of pooled features: those that vary by less are scaled as if they varied by "
        "so much; 0.5 kept long tasks from collapsing (docs/results/policies.md)",
    )
    pointnet_width: int = Field(64, ge=8, description="paper: 512")
    pointnet_layers: int = Field(2, ge=2, description="linear layers before the max-pool; paper: 2, official code: 3")
    precision: Literal["fp32", "bf16"] = Field(
        "fp32", description="of the PointNet; bf16 needs AMX or a GPU to be faster"
    )


class Options(PointCloudOptions):
    """Sizes of PointNet, LSTM, MLP and Gaussian mixture."""

    rnn_hidden: int = Field(128, ge=8, description="LSTM state; paper: 512")
    mlp: list[Rank] = Field([128], description="hidden layers behind the LSTM; official code: [512, 512]")
    gmm_modes: int = Field(5, ge=1, description="official code: 5")
    gmm_min_std: float = Field(
        0.1,
        gt=0,
        description="added to every standard deviation (official: 1e-4); docs/results/policies.md says why so large",
    )
    init_from_action_stats: bool = Field(
        True,
        description="training starts at the mean and the deviation of the demonstrated actions (official: at random); "
        "without it some trainings get stuck (docs/results/policies.md)",
    )
