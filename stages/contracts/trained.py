"""Contract of the `training` stage: `config.json` beside the weights of a policy."""

from pydantic import Field, RootModel, model_validator

from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.task_options import TaskConfig
from roomkin.stages.contracts.types import Count, Finite, Id, RelativePath, Seed, Text

LATE = 0.25  # of the steps; healthy trainings took at most 0.16 (of 83)


class TrainingStore(Contract):
    """The episodes of one store that training used."""

    file: Text = Field(description="the last three names of its path, wherever results/ lies")
    asset: Id
    episodes: Count
    frames: Count


class TrainedPolicy(Document):
    """`config.json`. Beside it: `policy.safetensors` (best), `last.safetensors`, `metrics.jsonl`.

    The weights hold the normaliser too (`proprio_mean`, `proprio_std`, `cloud_mean`, `cloud_std`).
    """

    task: Id
    task_options: TaskConfig = Field(description="environment of the demonstrations; evaluation uses the same")
    config: PolicyConfig = Field(description="hyper-parameters")
    seed: Seed
    stores: list[TrainingStore] = Field(min_length=1)
    data_digest: str = Field(description="sha256 over the episodes used")
    training_episodes: Count
    validation_episodes: Count
    parameters: Count = Field(description="learned numbers of the network")
    best_step: Count
    best_loss: Finite | None = Field(description="validation loss of policy.safetensors; null: no validation")
    best_error: Finite | None = Field(None, description="RMS error of its actions on the validation episodes")
    constant_error: Finite | None = Field(
        None, description="the same of one constant action, the mean of the training episodes"
    )
    plateau: Count | None = Field(
        None, description="last step of metrics.jsonl before its error fell below that for the first time; 0: none"
    )
    checkpoints: list[RelativePath] = Field(
        [], description="weights kept for selection by rollouts, in checkpoints.zip"
    )

    @property
    def learned(self) -> bool:
        """Whether its actions are nearer than a constant one, as far as it is known."""
        return self.best_error is None or self.constant_error is None or self.best_error < self.constant_error

    @property
    def late(self) -> bool:
        """Whether much of its training passed before it learned anything."""
        return self.learned and self.plateau is not None and self.plateau > LATE * self.config.steps


class MetricsLine(RootModel[dict[Text, Finite | None]]):
    """A line of `metrics.jsonl`: the step and what was measured there."""

    @model_validator(mode="after")
    def _has_step(self) -> "MetricsLine":
        if self.root.get("step") is None:
            raise ValueError("step: Field required")
        return self
