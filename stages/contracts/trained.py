"""Contract of the `training` stage: `config.json` beside the weights of a policy."""

from typing import Literal

from pydantic import Field

from stages.config.task import TaskConfig
from stages.config.training import TrainingRun
from stages.contracts.files import Contract


class TrainingStore(Contract):
    """What was used of one episode store."""

    file: str
    asset: str
    episodes: int
    frames: int


class TrainedPolicy(Contract):
    """`config.json`. Beside it: `policy.safetensors` (best), `last.safetensors`, `metrics.jsonl`.

    The weights hold the normaliser too (`proprio_mean`, `proprio_std`, `cloud_mean`, `cloud_std`).
    """

    version: Literal[1] = 1
    task: str
    task_options: TaskConfig = Field(description="environment of the demonstrations; evaluation uses the same")
    run: TrainingRun = Field(description="hyper-parameters")
    seed: int
    stores: list[TrainingStore]
    data_digest: str = Field(description="sha256 over the episodes used")
    training_episodes: int
    validation_episodes: int
    parameters: int = Field(description="learned numbers of the network")
    best_step: int
    best_loss: float | None = Field(description="validation loss of policy.safetensors; null: no validation")
    checkpoints: list[str] = Field([], description="further weights kept for selection by rollouts")
