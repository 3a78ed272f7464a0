"""Verb `train`: random rooms of procedural models, and the network that learns from them."""

from pathlib import Path

from plugins.segmenter.training.options import TrainingOptions


def run(
    *,
    out: Path = Path("results/segmenter"),
    seed: int = 0,
    training: TrainingOptions = TrainingOptions(),  # noqa: B008 frozen
) -> None:
    """Write segmenter.safetensors and metrics.jsonl; an interrupted run is resumed.

    Args:
        out: the folder.
        seed: of the models, the rooms and the weights.
        training: rooms and optimisation.
    """
    from plugins.segmenter.training.train import train

    train(out, training, seed)
