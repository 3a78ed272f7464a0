"""Config section `training`: hyper-parameter sets ("runs") of the policies (paper B.3)."""

from pydantic import Field

from stages.contracts.section import Section
from stages.contracts.training_run import HandleConfig, NetworkConfig, TrainingRun

PAPER_NETWORK = NetworkConfig(
    points=1024,
    cloud_frame="robot",
    standardise=False,
    pointnet_width=512,
    rnn_hidden=512,
    mlp=[512, 512],
    gmm_min_std=1e-4,
)
PAPER = TrainingRun(
    network=PAPER_NETWORK,
    steps=300_000,
    batch_size=32,
    learning_rate=1e-3,
    schedule="linear",
    weight_decay=0.0,
    log_every=500,
    save_every=5000,
    keep=10,
)

# What a policy needs to go by the handle, chosen on validation assets (docs/policies.md).
LITE_HANDLE = TrainingRun(
    let_go=False,
    handle=HandleConfig(
        flag=True, keep=True, middle=True, front_probability=0.8, scale=(0.2, 1.5), hide=0.5, grip=0.012
    ),
)


class TrainingConfig(Section):
    """How policies are trained."""

    runs: dict[str, TrainingRun] = Field(
        {"lite": TrainingRun(), "lite_handle": LITE_HANDLE, "paper": PAPER},
        description="Hyper-parameter sets by name; `experiment.runs` says which are trained. Keys that a set of your "
        "own does not name have the values of `lite`. `lite_handle` goes by the handle, `paper` is for a "
        "GPU.",
    )
