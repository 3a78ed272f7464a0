"""The network that names shapes: a PointNet of neighbourhoods (PointNet++, Qi et al. 2017) and of what is around."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from roomkin.stages.contracts import InputError

NUMBERS = 8  # that are told of a shape beside its points
CENTERS, NEIGHBOURS = 64, 16  # neighbourhoods of a shape, and points of each; chosen
SCALE = 2.0  # by which metres are multiplied
SPREAD = (2.0, 0.6, *[0.4] * 4, 0.3, 0.2)  # of `Shape.numbers`, about; and their middle
MIDDLE = (2.5, 1.4, *[0.2] * 4, 0.8, 0.7)


class ShapeNetwork(nn.Module):
    """points (B, N, 3), around (B, M, 3), numbers (B, NUMBERS) -> logits (B, names)."""

    middle: Tensor
    spread: Tensor

    def __init__(self, names: int) -> None:
        super().__init__()
        self.near = _layers(6, 32, 64)
        self.beside = _layers(3, 32, 32)
        self.points = _layers(64 + 32 + 3, 128, 256)
        self.around = _layers(3, 32, 96)
        self.numbers = _layers(NUMBERS + 8, 64)
        self.head = nn.Sequential(*_layers(2 * 256 + 96 + 64, 192), nn.Dropout(0.3), nn.Linear(192, names))
        self.register_buffer("middle", torch.tensor(MIDDLE), persistent=False)
        self.register_buffer("spread", torch.tensor(SPREAD), persistent=False)

    def forward(self, points: Tensor, around: Tensor, numbers: Tensor) -> Tensor:
        """See the class."""
        box = measure_box(points)
        points, around = SCALE * points, SCALE * around
        centers = points[:, :CENTERS]  # points come in no order: the first are as good as any
        near, beside = (find_nearest(centers, each, NEIGHBOURS) for each in (points, around))
        local = self.near(torch.cat([4 * near, near + centers[:, :, None]], dim=-1)).amax(dim=2)
        touching = self.beside(4 * beside.clamp(-1, 1)).amax(dim=2)
        whole = self.points(torch.cat([local, touching, centers], dim=-1))
        told = torch.cat([(numbers - self.middle) / self.spread, box], dim=-1)
        parts = [whole.amax(dim=1), whole.mean(dim=1), self.around(around).amax(dim=1), self.numbers(told)]
        logits: Tensor = self.head(torch.cat(parts, dim=-1))
        return logits


def find_nearest(centers: Tensor, points: Tensor, count: int) -> Tensor:
    """From each of some centers (B, C, 3) to its nearest points of (B, N, 3): (B, C, count, 3)."""
    nearest = torch.cdist(centers, points).topk(count, largest=False).indices
    found = points.gather(1, nearest.flatten(1)[..., None].expand(-1, -1, 3))
    return found.unflatten(1, nearest.shape[1:]) - centers[:, :, None]


def measure_box(points: Tensor) -> Tensor:
    """Logarithms of the extents (3) of points (B, N, 3), heights of their foot and top (2), and spreads (3): (B, 8)."""
    low, high = torch.quantile(points, torch.tensor([0.02, 0.98], device=points.device), dim=1)
    extents, spreads = (high - low).clamp(min=0.01).log() + 0.7, points.std(dim=1).clamp(min=0.003).log() + 2
    return torch.cat([extents, low[:, 2:], high[:, 2:], spreads], dim=-1)


def _layers(*widths: int) -> nn.Sequential:
    """Linear layers with ReLU, each with its inputs normalised by layer."""
    return nn.Sequential(*(one for a, b in pairwise(widths) for one in (nn.Linear(a, b), nn.LayerNorm(b), nn.ReLU())))


def load_weights(network: Any, path: Path, fix: str) -> Any:
    """A network of ours with the weights of a safetensors file, ready to be used.

    Raises:
        InputError: the file is not there or holds other weights.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    try:
        weights = {name: value.float() for name, value in load_file(path).items()}
    except (OSError, SafetensorError) as error:
        raise InputError(path, f"cannot be read: {error}.", fix, code="E-WEIGHTS-UNREADABLE") from None
    try:
        missing, unexpected = network.load_state_dict(weights, strict=False)
    except RuntimeError:
        raise InputError(path, "holds weights of other sizes.", fix, code="E-WEIGHTS-OTHER") from None
    lacking = [name for name in missing if not name.endswith("num_batches_tracked")]
    if lacking or unexpected:
        raise InputError(path, f"holds other weights, e.g. {[*lacking, *unexpected][0]}.", fix, code="E-WEIGHTS-OTHER")
    return network.eval()
