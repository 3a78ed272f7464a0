"""`python -m plugins.patchnet`: photograph models, train the network on them."""

import sys
from pathlib import Path

import tyro

from plugins.patchnet.training.options import PairOptions, TrainingOptions
from stages.contracts.errors import InputError


def run(
    out: Path = Path("results/patchnet"),
    seed: int = 0,
    pairs: PairOptions = PairOptions(),  # noqa: B008 frozen
    training: TrainingOptions = TrainingOptions(),  # noqa: B008 frozen
) -> None:
    """Write pairs.h5, patchnet.safetensors and metrics.jsonl into a folder; what was interrupted goes on.

    Args:
        out: the folder.
        seed: of the models, the pictures and the weights.
        pairs: what is photographed.
        training: how the network is trained.
    """
    from plugins.patchnet.training.render import render
    from plugins.patchnet.training.train import train

    render(out / "pairs.h5", pairs, seed)
    train(out / "pairs.h5", out, training, seed)


if __name__ == "__main__":
    try:
        tyro.cli(run, prog="python -m plugins.patchnet")
    except InputError as error:
        sys.exit(f"error: {error} [{error.code}]")
