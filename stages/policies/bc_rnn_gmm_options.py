"""Options of the policy `bc_rnn_gmm` (paper B.3). The defaults are `lite`: minutes on one core."""

from pydantic import Field

from roomkin.stages.contracts.section import Rank
from roomkin.stages.policies.point_cloud_options import PointCloudOptions


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
