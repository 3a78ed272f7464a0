"""Options of the training of the segmenter; the numbers of steps are not tried yet."""

from dataclasses import dataclass


@dataclass(frozen=True)
class TrainingOptions:
    """Rooms and optimisation.

    Attributes:
        models: solids of each kind that the rooms are furnished with.
        views: pictures of a room, at most.
        small_steps: AdamW updates on pictures of 160 x 120.
        large_steps: further updates on pictures of 320 x 240.
        batch: small pictures of an update; a fourth as many large ones.
        learning_rate: peak; it rises over `warm_up` steps and falls to almost nothing as a cosine.
        warm_up: steps.
        weight_decay: of AdamW.
        save_every: steps between states that an interrupted run goes on from.
    """

    models: int = 12
    views: int = 4
    small_steps: int = 1500
    large_steps: int = 300
    batch: int = 16
    learning_rate: float = 2e-3
    warm_up: int = 60
    weight_decay: float = 0.02
    save_every: int = 25
