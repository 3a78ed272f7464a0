"""How a policy is trained, as `training.configs` of the config and a trained policy hold it (paper B.3)."""

from typing import Any, Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.section import KWARGS, Section


class PolicyConfig(Section):
    """One hyper-parameter set. The defaults are `lite`: minutes on one core."""

    policy: str = Field("bc_rnn_gmm", json_schema_extra={"kind": "policies"}, description="the paper's")
    kwargs: dict[str, Any] = KWARGS
    horizon: int = Field(10, ge=1, description="steps per training sequence; paper: 10")
    points: int = Field(192, ge=16, description="random subset of each cloud that is seen (official: 1024 of 2048)")
    handle: bool = Field(
        False,
        description="the policy goes by the handle: its points, those before the front, are flagged, its middle is an "
        "input, and in training fronts move under their handles (not in the paper; docs/policies.md)",
    )

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

    # Augmentation (paper B.3: random downsampling, translation, jitter)
    translation: float = Field(0.04, ge=0, description="uniform +/- metres per axis (official: 0.04)")
    translation_mode: Literal["sequence", "cloud_only"] = Field(
        "sequence",
        description="sequence: one shift per sequence, of cloud and end-effector position together; cloud_only: one "
        "per step, proprioception stays (official code; it breaks the relation of hand and handle)",
    )
    jitter: float = Field(0.01, ge=0, description="standard deviation per point and axis, metres (official: 0.01)")

    # Data, checkpoints, logs
    release_included: bool = Field(
        True,
        description="false: demonstrations end before the hand opens for the last time. A test is over at success, and "
        "policies that learn to let go do so by where the hand is: wide doors too early (docs/policies.md). Not for "
        "tasks that succeed by letting go, such as put_away_bowl",
    )
    select: Literal["validation", "last"] = Field(
        "validation", description="which checkpoint becomes policy.safetensors: lowest validation loss, or the last"
    )
    num_checkpoints: int = Field(
        0, ge=0, description="evenly spaced checkpoints kept for `evaluation: {checkpoint: rollouts}`"
    )
    log_freq: int = Field(100, ge=1, description="steps between lines of metrics.jsonl and validations")
    wandb: Literal["disabled", "offline", "online"] = Field(
        "disabled", description="Weights & Biases run beside metrics.jsonl, below logs/training/wandb"
    )

    @model_validator(mode="after")
    def _check_cloud(self) -> "PolicyConfig":
        if self.handle and not has_eyes(self):
            raise ValueError("handle: flags points of a cloud, but kwargs.cloud is false")
        return self


def has_eyes(config: PolicyConfig) -> bool:
    """Whether a policy looks at clouds at all."""
    return bool(config.kwargs.get("cloud", True))
