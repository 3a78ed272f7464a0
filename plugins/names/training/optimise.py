"""Train the network of shapes on examples: each time stretched, turned, mirrored and jittered anew."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from plugins.names.network import ShapeNetwork
from plugins.names.shape import FAR
from plugins.names.training.draw import Examples

STRETCH, STRETCH_SIDE, TURN, JITTER, RAISE = 0.08, 0.06, 0.15, 0.004, 0.015  # log, log, radians, metres, metres; chosen
SMOOTHING = 0.05  # of labels; chosen


@dataclass(frozen=True)
class Options:
    """epochs over the examples; examples of an update; AdamW's peak rate, which rises and falls (one cycle)."""

    epochs: int = 20
    batch: int = 512
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2


def train(examples: Examples, names: int, seed: int, options: Options, device: str) -> ShapeNetwork:
    """The network after so many epochs, on the CPU; one thread of it gives the same weights every time."""
    torch.manual_seed(seed)
    data = [torch.from_numpy(each).to(device) for each in examples]
    network = ShapeNetwork(names).to(device)
    # Logits are of names that are all as likely before (logit adjustment, Menon et al. 2021).
    common = (torch.bincount(data[3], minlength=names) + 1.0).log()
    optimiser = torch.optim.AdamW(network.parameters(), options.learning_rate, weight_decay=options.weight_decay)
    steps = max(1, len(data[3]) // options.batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, options.learning_rate, steps * options.epochs + 1)
    for epoch in range(options.epochs):
        total = torch.zeros((), device=device)
        for some in torch.randperm(len(data[3]), device=device).split(options.batch)[:steps]:
            points, around, numbers, name = (each[some] for each in data)
            logits = network(*vary(points.float(), around.float(), numbers))
            loss = functional.cross_entropy(logits + common, name, label_smoothing=SMOOTHING)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total += loss.detach()
        print(f"epoch {epoch + 1}: loss {float(total) / steps:.3f}", flush=True)
    return network.cpu().eval()


def vary(points: Tensor, around: Tensor, numbers: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Shapes stretched as a whole and along each side, turned a little, half of them mirrored, raised, jittered."""
    sides, middle = points[:, :1], points[:, 0, 0]
    scale = torch.exp(STRETCH * torch.randn_like(sides[..., :1]) + STRETCH_SIDE * torch.randn_like(sides))
    angle = TURN * torch.randn_like(middle)
    c, s, nil, one = angle.cos(), angle.sin(), torch.zeros_like(angle), torch.ones_like(angle)
    turn = torch.stack([c, -s, nil, s, c, nil, nil, nil, one], dim=-1).view(-1, 3, 3)
    flip, up = torch.ones_like(sides), torch.zeros_like(sides)
    flip[:, 0, 1] = torch.where(torch.rand_like(middle) < 0.5, -1.0, 1.0)
    up[:, 0, 2] = RAISE * torch.randn_like(middle)
    moved = [(each @ turn.transpose(1, 2)) * scale * flip + up for each in (points, around)]
    numbers = numbers.clone()
    mirrored = flip[:, 0, 1] < 0
    numbers[mirrored, 4:6] = numbers[mirrored, 4:6].flip(1)  # left and right
    around = torch.where(around == FAR, around, moved[1])
    return moved[0] + JITTER * torch.randn_like(points), around, numbers
