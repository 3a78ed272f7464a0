"""Options of the training of `patchnet`; the defaults made the shipped weights."""

from dataclasses import dataclass
from typing import Literal

HELD_OUT = ("bed", "chair", "mug", "plant_pot", "television")


@dataclass(frozen=True)
class PairOptions:
    """The models and pictures that it is trained on.

    Attributes:
        held_out: categories that it never sees, to measure how it does on new ones.
        models: procedural models per other category, none of the library's.
        assemblies: models put together of random solids.
        views: pictures per model, evenly round it, each beside a snapshot.
    """

    held_out: tuple[str, ...] = HELD_OUT
    models: int = 20
    assemblies: int = 100
    views: int = 12


@dataclass(frozen=True)
class TrainingOptions:
    """The optimisation.

    Attributes:
        steps: AdamW updates.
        batch_models: models per batch.
        batch_views: views of each model in a batch; the loss tells them apart.
        learning_rate: peak, reached after `warm_up` steps and kept for `flat` times as many; then it falls with the
            root of the steps, whatever their number, so that a run can be made longer.
        weight_decay: of AdamW.
        temperature: of both losses.
        owner: weight of the second loss: patches lie nearest to the right snapshot.
        precision: of the network's passes.
        save_every: steps between states that an interrupted run resumes from.
    """

    steps: int = 1200
    batch_models: int = 8
    batch_views: int = 4
    learning_rate: float = 1e-3
    warm_up: int = 50
    flat: float = 6
    weight_decay: float = 0.05
    temperature: float = 0.07
    owner: float = 0.5
    precision: Literal["bf16", "fp32"] = "bf16"
    save_every: int = 25
