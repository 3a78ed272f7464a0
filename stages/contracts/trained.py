"""Contract of the `training` stage: the folder of a policy, config.json with the weights beside it. Needs no torch."""

import math
from functools import partial
from pathlib import Path

import numpy as np
from pydantic import Field, RootModel, model_validator

from roomkin.stages.contracts.archives import unpack
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document, read_json
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
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


AGAIN = "train the policy first"
NORMALISER = {"proprio_mean": (9,), "proprio_std": (9,), "cloud_mean": (3,), "cloud_std": ()}
NUMPY = {"F64", "F32", "F16", "I64", "I32", "I16", "I8", "U8", "BOOL"}
PAPERS = "bc_rnn_gmm"
CHECKPOINTS = "checkpoints.zip"
Shapes = dict[str, tuple[int, ...]]
wrong_weights = partial(InputError, fix=AGAIN, code="E-POLICY-WEIGHTS")


def weights_of(folder: Path, name: str) -> Path:
    """The file of weights that config.json calls `name`: beside it, or checkpoints/<file> of checkpoints.zip."""
    inside = name.removeprefix("checkpoints/")
    return folder / name if inside == name else unpack(folder / CHECKPOINTS, AGAIN, inside) / inside


def read_config(folder: Path) -> TrainedPolicy:
    """The `config.json` of a training folder."""
    return read_json(TrainedPolicy, folder / "config.json", AGAIN)


def check_weights(path: Path, trained: TrainedPolicy) -> Shapes:
    """Shapes by name of one file of weights; all finite, with the normaliser, and as many as config.json says.

    Raises:
        InputError: it is missing, broken, or another network's.
    """
    from safetensors import safe_open  # the report's image reads policies' configs without it

    shapes: Shapes = {}
    with explain_unreadable(path, "safetensors file", AGAIN), safe_open(path, framework="np") as file:
        for name in file.keys():  # noqa: SIM118 - no mapping
            part = file.get_slice(name)
            shapes[name] = tuple(part.get_shape())
            if part.get_dtype() not in NUMPY:
                continue  # bfloat16 and smaller: numpy has no such numbers
            array = file.get_tensor(name)
            if not np.isfinite(array).all():
                raise wrong_weights(path, f"{name}: holds NaN or infinity.")
            if name in NORMALISER and name.endswith("_std") and array.min() <= 0:
                raise wrong_weights(path, f"{name}: is not positive.")
    if trained.config.policy != PAPERS:
        return shapes  # which numbers another policy keeps is for it to know
    for name, shape in NORMALISER.items():
        if shapes.get(name) != shape:
            raise wrong_weights(path, f"{name}: has shape {shapes.get(name)}, not {shape}.")
    count = sum(math.prod(shape) for name, shape in shapes.items() if name not in NORMALISER)
    if count != trained.parameters:
        raise wrong_weights(path, f"holds {count} numbers, config.json says parameters: {trained.parameters}.")
    return shapes


def check_policy(path: Path) -> None:
    """config.json (or its folder) and all weights that it names."""
    folder = path if path.is_dir() else path.parent
    trained = read_config(folder)
    shapes = check_weights(folder / "policy.safetensors", trained)
    for name in ("last.safetensors", *trained.checkpoints):
        if check_weights(weights_of(folder, name), trained) != shapes:
            raise wrong_weights(folder / name, "has other weights than policy.safetensors.")
