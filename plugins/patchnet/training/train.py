"""Train the network on rendered pairs. One thread: the same weights every time."""

import json
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import torch
from safetensors.torch import save
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from plugins.patchnet.network import PatchNet
from plugins.patchnet.training.batches import Batch, Pairs, draw
from plugins.patchnet.training.loss import find_same_looks, losses
from plugins.patchnet.training.options import TrainingOptions
from stages.cli import progress
from stages.contracts.files import write_atomically

STATE = "state.pt"
QUERIES = 1024  # patches of a batch that are compared
AVERAGED = 0.99  # what is written is the moving average of the weights: about the last hundred steps
LOG_EVERY = 10
Line = dict[str, float]


@dataclass
class Run:
    """All that changes as training goes on; `about` names pairs, options and seed."""

    about: str
    network: PatchNet
    average: AveragedModel
    optimiser: torch.optim.Optimizer
    step: int = 0
    lines: list[Line] = field(default_factory=list)


def train(pairs: Path, out: Path, config: TrainingOptions, seed: int) -> None:
    """Write patchnet.safetensors (fp16) and metrics.jsonl; an interrupted run goes on from state.pt.

    Args:
        pairs: what `render` wrote.
        out: folder.
        config: the optimisation.
        seed: of the initial weights and the batches.
    """
    torch.set_num_threads(1)  # with two, oneDNN's backward pass in bf16 spins for ten times as long
    data = Pairs(pairs)
    out.mkdir(parents=True, exist_ok=True)
    about = asdict(replace(config, steps=0, save_every=0))  # a run may be made longer
    training = start_run(json.dumps([about, seed, data.about]), config, seed)
    resume(training, out / STATE)
    for step in progress(range(training.step, config.steps), "steps", config.steps - training.step):
        pick = torch.Generator().manual_seed((seed * 1_000_003 + step) % 2**63)
        update(training, draw(data, step, seed, config), config, pick)
        if training.step % config.save_every == 0 and training.step < config.steps:
            save_state(training, out / STATE)
            save_weights(training.average.module, out / "patchnet.safetensors", data.categories)
    save_weights(training.average.module, out / "patchnet.safetensors", data.categories)
    with write_atomically(out / "metrics.jsonl") as temporary:
        temporary.write_text("".join(json.dumps(line) + "\n" for line in training.lines), encoding="utf-8")


def start_run(about: str, config: TrainingOptions, seed: int) -> Run:
    """A run before its first step."""
    torch.manual_seed(seed)
    network = PatchNet().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = AveragedModel(network, multi_avg_fn=get_ema_multi_avg_fn(AVERAGED), use_buffers=True)
    rate, decay = config.learning_rate, config.weight_decay
    return Run(about, network, average, torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=decay))


def update(training: Run, batch: Batch, config: TrainingOptions, pick: torch.Generator) -> None:
    """One step of the optimiser."""
    start = time.process_time()
    for group in training.optimiser.param_groups:
        group["lr"] = learning_rate(training.step, config)
    with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bf16"):
        features = training.network(batch.crops.flatten(0, 1).contiguous(memory_format=torch.channels_last))
    match, owner, hit = compare(features, batch, pick, config.temperature)
    training.optimiser.zero_grad()
    (match + config.owner * owner).backward()
    torch.nn.utils.clip_grad_norm_(training.network.parameters(), 1.0)
    training.optimiser.step()
    training.average.update_parameters(training.network)
    training.step += 1
    if training.step % LOG_EVERY == 0:
        values = {"match": match, "owner": owner, "hit": hit}
        line: Line = {"step": training.step} | {name: round(value.item(), 4) for name, value in values.items()}
        training.lines.append(line)
        print(line, f"{time.process_time() - start:.2f} s", flush=True)


def compare(features: Tensor, batch: Batch, pick: torch.Generator, heat: float) -> tuple[Tensor, Tensor, Tensor]:
    """The losses of a batch, over QUERIES patches of its pictures."""
    count = len(batch.models)
    rows = features.flatten(2).transpose(1, 2)  # (2 B, P, D)
    pictures, snapshots = rows[:count], rows[count:]
    candidates = torch.nonzero(batch.visible[0].flatten())[:, 0]
    chosen = candidates[torch.randperm(len(candidates), generator=pick)[:QUERIES]].sort().values
    owners = chosen // pictures.shape[1]
    targets = batch.matches.flatten()[chosen]
    targets = torch.where(batch.visible[1][owners, targets.clamp(min=0)], targets, -1)
    alike = find_same_looks(batch.models, batch.yaws, batch.periods)
    return losses(pictures.flatten(0, 1)[chosen], snapshots, owners, targets, batch.visible[1], alike, heat)


def learning_rate(step: int, config: TrainingOptions) -> float:
    """Of update `step` (from 0): rises over `warm_up` steps, then falls with their root, however long it goes on."""
    ratio = (step + 1) / config.warm_up
    return config.learning_rate * (ratio if ratio < 1 else min(1.0, (config.flat / ratio) ** 0.5))


def save_state(training: Run, path: Path) -> None:
    """Write what an interrupted run goes on from, whole or not at all."""
    content = {
        "about": training.about,
        "network": training.network.state_dict(),
        "average": training.average.state_dict(),
        "optimiser": training.optimiser.state_dict(),
        "step": training.step,
        "lines": training.lines,
    }
    with write_atomically(path) as temporary:
        torch.save(content, temporary)


def resume(training: Run, path: Path) -> None:
    """Go on from the state of this very run, if there is one."""
    if not path.is_file():
        return
    content = torch.load(path, weights_only=True)
    if content["about"] != training.about:
        return
    for name in ("network", "average", "optimiser"):
        getattr(training, name).load_state_dict(content[name])
    training.step, training.lines = int(content["step"]), content["lines"]


def save_weights(network: nn.Module, path: Path, categories: list[str]) -> None:
    """The weights and the statistics of batch normalisation as fp16 safetensors, which also tell what was seen."""
    kept = {name: value for name, value in network.state_dict().items() if value.is_floating_point()}
    with write_atomically(path) as temporary:
        content = {name: value.half().contiguous() for name, value in sorted(kept.items())}
        temporary.write_bytes(save(content, {"seen": " ".join(categories)}))
