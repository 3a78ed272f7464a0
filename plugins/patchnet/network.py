"""A small convolutional network with a feature pyramid: one unit vector per patch of a crop."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from plugins.pretrained.weights import load_weights

SIZE, GRID = 192, 16  # pixels of a crop and patches of it, per side
COLUMNS = 128  # numbers per patch
WEIGHTS = Path(__file__).with_name("patchnet.safetensors")


def _convolution(inputs: int, outputs: int, kernel: int, stride: int) -> nn.Sequential:
    convolution = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs))


class Residual(nn.Module):
    """Two 3 x 3 convolutions around a shortcut."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.first = _convolution(inputs, outputs, 3, stride)
        self.second = _convolution(outputs, outputs, 3, 1)
        same = inputs == outputs and stride == 1
        self.shortcut = nn.Identity() if same else _convolution(inputs, outputs, 1, stride)

    def forward(self, x: Tensor) -> Tensor:
        """(B, inputs, H, W) -> (B, outputs, H / stride, W / stride)."""
        return functional.relu(self.second(functional.relu(self.first(x))) + self.shortcut(x))


class PatchNet(nn.Module):
    """Crop (B, 4, 192, 192) -> unit vectors (B, 128, 16, 16); see `network_input`.

    Strides 6, 12 and 24, each with residual blocks; the coarser ones, and the mean of the coarsest, are added to the
    patches, so that each knows what it is part of.
    """

    def __init__(self, widths: Sequence[int] = (48, 128, 256), depths: Sequence[int] = (1, 2, 2)) -> None:
        super().__init__()
        self.stem = nn.Sequential(_convolution(4, 32, 7, 3), nn.ReLU(), _convolution(32, widths[0], 3, 2), nn.ReLU())
        self.stages = nn.ModuleList()
        inputs = widths[0]
        for level, (width, depth) in enumerate(zip(widths, depths, strict=True)):
            strides = [2 if level else 1] + [1] * (depth - 1)
            blocks = [Residual(inputs if k == 0 else width, width, stride) for k, stride in enumerate(strides)]
            self.stages.append(nn.Sequential(*blocks))
            inputs = width
        self.lateral = nn.Conv2d(widths[1], COLUMNS, 1)
        self.coarse = nn.Conv2d(widths[2], COLUMNS, 1)
        self.whole = nn.Linear(widths[2], COLUMNS)
        self.head = nn.Conv2d(COLUMNS, COLUMNS, 3, 1, 1)

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        fine = self.stages[1](self.stages[0](self.stem(x)))
        coarse = self.stages[2](fine)
        above = self.coarse(coarse) + self.whole(coarse.mean((2, 3)))[:, :, None, None]
        y = self.lateral(fine) + functional.interpolate(above, scale_factor=2.0, mode="nearest")
        return functional.normalize(self.head(functional.relu(y)).float(), dim=1)


def network_input(pictures: NDArray[np.uint8], coverage: NDArray[np.uint8]) -> Tensor:
    """(B, 4, H, W) float32 of crops (B, H, W, 3), grey outside the mask, and its coverage (B, H, W), 0 to 255."""
    both = np.concatenate([pictures, coverage[..., None]], axis=-1)
    return normalise_crops(torch.from_numpy(both).permute(0, 3, 1, 2).float())


def normalise_crops(x: Tensor) -> Tensor:
    """Bytes (B, 4, H, W) as the network takes them: about -1 to 1, the grey outside the mask near 0."""
    return x.sub(127.5).div(127.5).contiguous(memory_format=torch.channels_last)


def seen_categories(path: Path = WEIGHTS) -> list[str]:
    """Categories of the models that the weights were trained on."""
    from safetensors import safe_open

    with safe_open(path, "pt") as file:
        return str(file.metadata()["seen"]).split()


def load(path: Path = WEIGHTS) -> PatchNet:
    """The network with its weights, ready to be used.

    Raises:
        InputError: the file is not there or holds other weights.
    """
    fix = "python -m plugins.patchnet makes one: results/patchnet/patchnet.safetensors"
    network: PatchNet = load_weights(PatchNet(), path, fix).to(memory_format=torch.channels_last)
    return network
