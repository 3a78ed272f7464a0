"""Hyper-parameter sets ("runs") of a policy, as `training` of the config and a trained policy hold them (paper B.3)."""

from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from stages.contracts.section import OWN, Rank, Section


class NetworkConfig(Section):
    """Sizes of the policy network: PointNet, LSTM, MLP, Gaussian mixture."""

    cloud: bool = Field(True, description="false: a policy without eyes, by proprioception alone (a baseline)")
    points: int = Field(192, ge=16, description="random subset of each cloud that is seen (official: 1024 of 2048)")
    cloud_frame: Literal["robot", "gripper"] = Field(
        "gripper", description="origin of the cloud: robot base (paper), or the end-effector, axes kept"
    )
    standardise: bool = Field(True, description="shift and scale clouds to unit variance (official: raw metres)")
    standardise_floor: float = Field(
        0.0,
        ge=0,
        description="of the median spread of pooled features: those that vary by less are scaled as if they varied by "
        "so much; 0.5 kept long tasks from collapsing (docs/results/policies.md)",
    )
    pointnet_width: int = Field(64, ge=8, description="paper: 512")
    pointnet_layers: int = Field(2, ge=2, description="linear layers before the max-pool; paper: 2, official code: 3")
    # Learned embedding of the finger flag; paper: 128
    flag_embedding: ClassVar[int] = 128
    rnn_hidden: int = Field(128, ge=8, description="LSTM state; paper: 512")
    mlp: list[Rank] = Field([128], description="hidden layers behind the LSTM; official code: [512, 512]")
    gmm_modes: int = Field(5, ge=1, description="official code: 5")
    gmm_min_std: float = Field(
        0.1,
        gt=0,
        description="added to every standard deviation (official: 1e-4); docs/results/policies.md says why so large",
    )
    start_at_actions: bool = Field(
        True,
        description="training starts at the mean and the deviation of the demonstrated actions (official: at random); "
        "without it some trainings get stuck (docs/results/policies.md)",
    )


class TrainingRun(Section):
    """One hyper-parameter set. The defaults are `lite`: minutes on one core."""

    policy: str = Field("bc_rnn_gmm", json_schema_extra={"kind": "policies"}, description="the paper's")
    network: NetworkConfig = Field(NetworkConfig(), description="Sizes of the policy network.")
    rnn_horizon: int = Field(10, ge=1, description="steps per training sequence; paper: 10")

    # Optimisation
    steps: int = Field(2500, ge=1, description="AdamW updates; official code: 300000")
    batch_size: int = Field(16, ge=1, description="sequences per update; official code: 32")
    learning_rate: float = Field(2e-3, gt=0, description="peak; official code: 1e-3")
    schedule: Literal["linear", "cosine", "constant"] = Field(
        "cosine",
        description="cosine: to zero at the last step; linear: to a tenth over 10000 steps, then flat (official)",
    )
    warmup: int = Field(
        100, ge=0, description="first updates, over which the learning rate rises to its schedule; official code: 0"
    )
    weight_decay: float = Field(1e-4, ge=0, description="of AdamW; official code: 0")
    # Largest norm of the gradient; official code: none
    gradient_clip: ClassVar[float] = 1.0
    precision: Literal["fp32", "bf16"] = Field(
        "fp32", description="of the PointNet; bf16 needs AMX or a GPU to be faster"
    )

    # Augmentation (paper B.3: random downsampling, translation, jitter)
    translation: float = Field(0.04, ge=0, description="uniform +/- metres per axis (official: 0.04)")
    # Official: 0.4
    translation_probability: ClassVar[float] = 0.4
    translation_mode: Literal["sequence", "cloud_only"] = Field(
        "sequence",
        description="sequence: one shift per sequence, of cloud and end-effector position together; cloud_only: one "
        "per step, proprioception stays (official code; it breaks the relation of hand and handle)",
    )
    jitter: float = Field(0.01, ge=0, description="standard deviation per point and axis, metres (official: 0.01)")
    # Largest jitter, metres (official: 0.015)
    jitter_clip: ClassVar[float] = 0.015
    # Per sequence (official: 0.1, switched off)
    jitter_probability: ClassVar[float] = 0.1
    handle: bool = Field(
        False,
        description="the policy goes by the handle: its points, those before the front, are flagged, its middle is an "
        "input, and in training fronts move under their handles (not in the paper; docs/policies.md)",
    )

    # Data, checkpoints, logs
    let_go: bool = Field(
        True,
        description="false: demonstrations end before the hand opens for the last time. A test is over at success, and "
        "policies that learn to let go do so by where the hand is: wide doors too early (docs/policies.md). Not for "
        "tasks that succeed by letting go, such as put_away_bowl",
    )
    # Episodes kept for validation (official: 0.1)
    validation_fraction: ClassVar[float] = 0.1
    select: Literal["validation", "last"] = Field(
        "validation", description="which checkpoint becomes policy.safetensors: lowest validation loss, or the last"
    )
    keep: int = Field(0, ge=0, description="evenly spaced checkpoints kept for `evaluation: {checkpoint: rollouts}`")
    log_every: int = Field(100, ge=1, description="steps between lines of metrics.jsonl and validations")
    # Steps between states that an interrupted run resumes from
    save_every: ClassVar[int] = 1000
    wandb: Literal["disabled", "offline", "online"] = Field(
        "disabled", description="Weights & Biases run beside metrics.jsonl, below logs/training/wandb"
    )
    own: dict[str, dict[str, Any]] = OWN

    @property
    def kind(self) -> tuple[str, bool, bool]:
        """What makes it another kind of policy, not the same with other hyper-parameters."""
        return self.policy, self.handle, self.network.cloud

    @model_validator(mode="after")
    def _check_cloud(self) -> "TrainingRun":
        if self.handle and not self.network.cloud:
            raise ValueError("handle: marks points of a cloud, but network.cloud is false")
        return self
