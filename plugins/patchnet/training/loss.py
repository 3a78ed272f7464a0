"""The two losses: a patch's nearest patch is the one that shows the same point, and lies in the right snapshot."""

import torch
from torch import Tensor
from torch.nn import functional

from plugins.patchnet.network import GRID

SAME_TURN = 0.1  # radians by which two snapshots may differ that look the same


def find_same_looks(models: Tensor, yaws: Tensor, periods: Tensor) -> Tensor:
    """(B, B) bool: snapshots of one model that look the same, as its symmetry says. All arguments (B,)."""
    gap = (yaws[:, None] - yaws[None]).abs()
    period = periods[:, None]
    turned = torch.remainder(gap + period / 2, period.clamp(min=1e-6)) - period / 2
    alike = (period == 0) | (turned.abs() < SAME_TURN)
    return (models[:, None] == models[None]) & alike


def neighbours() -> Tensor:
    """(P, 9): each patch of the grid with those around it, which are neither right nor wrong; -1 outside."""
    inside = functional.pad(torch.arange(GRID * GRID).view(GRID, GRID), (1, 1, 1, 1), value=-1)
    rows = [inside[y : y + GRID, x : x + GRID] for y in range(3) for x in range(3)]
    return torch.stack(rows, dim=-1).view(-1, 9)


def losses(
    queries: Tensor, snapshots: Tensor, owners: Tensor, targets: Tensor, visible: Tensor, alike: Tensor, heat: float
) -> tuple[Tensor, Tensor, Tensor]:
    """InfoNCE over the patches, and the log share of a patch's neighbours that lie in its own snapshot.

    Vectors have length 1, so exp(1 / heat) is the largest number and nothing has to be subtracted first.

    Args:
        queries: (Q, D) unit vectors of patches of pictures.
        snapshots: (B, P, D) unit vectors of all patches of the snapshots.
        owners: (Q,) the snapshot that belongs to each query's picture.
        targets: (Q,) the patch of it that shows the same, or -1.
        visible: (B, P) bool, patches of the snapshots that show their model.
        alike: (B, B) of `find_same_looks`.
        heat: temperature.

    Returns:
        Both losses, and the share of queries whose own snapshot has the largest share (without gradient).
    """
    kept = torch.nonzero(visible.flatten())[:, 0]
    column = torch.full((visible.numel(),), -1).index_put((kept,), torch.arange(len(kept))).view(visible.shape)
    weights = (queries @ snapshots.flatten(0, 1)[kept].T / heat).exp()  # (Q, K)
    of_snapshot = functional.one_hot(kept // visible.shape[1], len(visible)).to(weights.dtype)
    each = torch.arange(len(visible))
    wrong = alike[owners] & (each != owners[:, None])  # the same seen again: neither right nor wrong
    by_snapshot = (weights @ of_snapshot).masked_fill(wrong, 0.0)
    total = by_snapshot.sum(1)
    own = torch.arange(len(owners))
    owner = (total / by_snapshot[own, owners].clamp(min=1e-20)).log().mean()

    known = targets >= 0
    around = neighbours()[targets[known]]
    columns = column[owners[known]].gather(1, around.clamp(min=0))
    there = (around >= 0) & (columns >= 0)
    near = (weights[known].gather(1, columns.clamp(min=0)) * there).sum(1)
    right = weights[known].gather(1, column[owners[known], targets[known]][:, None])[:, 0]
    match = ((total[known] - near + right) / right).log().mean()
    with torch.no_grad():
        hit = (by_snapshot.argmax(1) == owners).float().mean()
    return match, owner, hit
