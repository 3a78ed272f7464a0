"""What the network learns: class, way to the centre, radius, and which pixels are of one thing."""

import torch
from torch import Tensor
from torch.nn import functional

from plugins.segmenter.network import NEIGHBOURS, THING
from plugins.segmenter.training.batches import Batch
from plugins.segmenter.training.pictures import NOTHING

USUAL = 800.0  # pixels of a thing whose pixels count once; those of smaller ones count more, of larger ones less
WEIGHTS = {"class": 1.0, "same": 2.0, "offset": 1.0, "radius": 0.3}


def losses(outputs: Tensor, batch: Batch) -> dict[str, Tensor]:
    """The parts of the loss by name; `outputs` (B, OUTPUTS, h, w)."""
    owner = batch.owner
    weight = (USUAL / batch.area).sqrt().clamp(0.3, 3.0)
    real = owner != NOTHING
    classes = functional.cross_entropy(outputs[:, :3], owner.clamp(max=THING), reduction="none")
    thing = (owner >= THING) & real
    held = weight * thing
    total = held.sum().clamp(min=1.0)
    gap = (outputs[:, 3:6] - batch.offset) / batch.radius[:, None]
    away = functional.smooth_l1_loss(gap, torch.zeros_like(gap), beta=0.2, reduction="none").sum(dim=1).clamp(max=10.0)
    radius = (outputs[:, 6] - batch.radius.log()).abs()
    lit = held * batch.known
    return {
        "class": (classes * weight * real).sum() / (weight * real).sum().clamp(min=1.0),
        "same": same_loss(outputs[:, 7:], owner, weight),
        "offset": (away * lit).sum() / lit.sum().clamp(min=1.0),
        "radius": (radius * held).sum() / total,
    }


def same_loss(logits: Tensor, owner: Tensor, weight: Tensor) -> Tensor:
    """Binary cross-entropy of `logits` (B, len(NEIGHBOURS), h, w), over pairs of pixels of which one shows a thing."""
    losses, weights = [], []
    for channel, (rows, columns) in enumerate(NEIGHBOURS):
        here, there = pair(owner, rows, columns)
        counts = (here != NOTHING) & (there != NOTHING) & ((here >= THING) | (there >= THING))
        one, other = pair(weight, rows, columns)
        each = torch.maximum(one, other) * counts
        predicted, _ = pair(logits[:, channel], rows, columns)
        loss = functional.binary_cross_entropy_with_logits(predicted, (here == there).float(), reduction="none")
        losses.append((loss * each).sum())
        weights.append(each.sum())
    return torch.stack(losses).sum() / torch.stack(weights).sum().clamp(min=1.0)


def pair(values: Tensor, rows: int, columns: int) -> tuple[Tensor, Tensor]:
    """Values (B, h, w) at pixels, and at those so many rows below and columns beside them, where both are inside."""
    height, width = values.shape[-2:]
    left, right = max(0, -columns), min(width, width - columns)
    return values[:, : height - rows, left:right], values[:, rows:, left + columns : right + columns]
