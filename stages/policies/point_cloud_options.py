"""Options of all policies that see clouds by the paper's PointNet (B.3)."""

from typing import Literal

from pydantic import Field

from roomkin.stages.contracts.section import Section

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
