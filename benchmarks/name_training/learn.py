"""Command `learn`: draw shapes from random rooms of our own models, and train the network that names them."""

from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors.torch import save
from torch import Tensor, set_num_threads
from torch.nn import functional

from benchmarks.name_training.draw import Examples, draw_examples, list_names
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.perception.classification.network import ShapeNetwork
from roomkin.stages.perception.classification.propose import FAR, NETWORK

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


def write_network(out: Path, network: ShapeNetwork, names: list[str]) -> None:
    """The weights as fp16 safetensors, the names of the outputs beside them."""
    weights = {name: value.half().contiguous() for name, value in sorted(network.state_dict().items())}
    with write_atomically(out) as temporary:
        temporary.write_bytes(save(weights, {"names": " ".join(names)}))


def run(
    *,
    out: Path = NETWORK,
    rooms: int = 4581,
    models: int = 24,
    epochs: int = 20,
    seed: int = 1,
    processes: int = 1,
    device: str = "cpu",
    packs: Path | None = None,
) -> None:
    """Write the network. On the CPU the same numbers write the same bytes, by however many processes rooms are drawn.

    Args:
        out: the file.
        rooms: about forty shapes are drawn from each.
        models: of a category.
        epochs: times that every shape is learnt from.
        seed: of models, rooms and initial weights.
        processes: that draw.
        device: of PyTorch, that trains: cpu or cuda.
        packs: folder of `benchmarks.open_rooms fetch`: models of the half `work` stand in the rooms, too.
    """
    set_num_threads(1)
    names = list_names()
    examples = draw_examples(rooms, models, seed, processes, packs)
    print(f"{len(examples.name)} shapes of {len(names)} names", flush=True)
    write_network(out, train(examples, len(names), seed, Options(epochs=epochs), device), names)
