"""Train the network on pictures of random rooms. One thread: the same weights every time."""

import json
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import save
from torch import nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from plugins.segmenter.network import Segmenter
from plugins.segmenter.training.batches import Batch, draw
from plugins.segmenter.training.loss import WEIGHTS, losses
from plugins.segmenter.training.options import TrainingOptions
from plugins.segmenter.training.pictures import LARGE, SMALL, make_pool
from stages.cli import progress
from stages.contracts.files import write_atomically

STATE = "state.pt"
AVERAGED = 0.98  # what is written is the moving average of the weights: about the last fifty steps
LOG_EVERY = 10
Line = dict[str, float]


@dataclass
class Run:
    """All that changes as training goes on; `about` names options and seed."""

    about: str
    network: Segmenter
    average: AveragedModel
    optimiser: torch.optim.Optimizer
    step: int = 0
    lines: list[Line] = field(default_factory=list)


def train(out: Path, config: TrainingOptions, seed: int) -> None:
    """Write segmenter.safetensors (fp16) and metrics.jsonl; an interrupted run goes on from state.pt.

    Args:
        out: folder.
        config: rooms and optimisation.
        seed: of the models, the rooms, and the initial weights.
    """
    torch.set_num_threads(1)
    out.mkdir(parents=True, exist_ok=True)
    pool = make_pool(config.models, seed)
    training = start_run(json.dumps([asdict(replace(config, save_every=0)), seed]), config, seed)
    resume(training, out / STATE)
    steps = config.small_steps + config.large_steps
    for step in progress(range(training.step, steps), "steps", steps - training.step):
        size, count = (SMALL, config.batch) if step < config.small_steps else (LARGE, config.batch // 4)
        update(training, draw(pool, step, size, count, config.views, seed), config)
        if training.step % config.save_every == 0 and training.step < steps:
            save_state(training, out / STATE)
            save_weights(training.average.module, out / "segmenter.safetensors")
    save_weights(training.average.module, out / "segmenter.safetensors")
    with write_atomically(out / "metrics.jsonl") as temporary:
        temporary.write_text("".join(json.dumps(line) + "\n" for line in training.lines), encoding="utf-8")


def start_run(about: str, config: TrainingOptions, seed: int) -> Run:
    """A run before its first step."""
    torch.manual_seed(seed)
    network = Segmenter().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = AveragedModel(network, multi_avg_fn=get_ema_multi_avg_fn(AVERAGED), use_buffers=True)
    rate, decay = config.learning_rate, config.weight_decay
    return Run(about, network, average, torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=decay))


def update(training: Run, batch: Batch, config: TrainingOptions) -> None:
    """One step of the optimiser."""
    start = time.process_time()
    for group in training.optimiser.param_groups:
        group["lr"] = learning_rate(training.step, config)
    parts = losses(training.network(batch.inputs), batch)
    training.optimiser.zero_grad()
    torch.stack([WEIGHTS[name] * part for name, part in parts.items()]).sum().backward()
    torch.nn.utils.clip_grad_norm_(training.network.parameters(), 2.0)
    training.optimiser.step()
    training.average.update_parameters(training.network)
    training.step += 1
    if training.step % LOG_EVERY == 0:
        line: Line = {"step": training.step} | {name: round(part.item(), 4) for name, part in parts.items()}
        training.lines.append(line)
        print(line, f"{time.process_time() - start:.2f} s", flush=True)


def learning_rate(step: int, config: TrainingOptions) -> float:
    """Of update `step` (from 0): rises over `warm_up` steps, then falls as a cosine."""
    share = (step + 1) / (config.small_steps + config.large_steps)
    fallen = 0.02 + 0.98 * float(np.cos(share * np.pi / 2)) ** 2
    return config.learning_rate * min(1.0, (step + 1) / config.warm_up) * fallen


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


def save_weights(network: nn.Module, path: Path) -> None:
    """The weights and the statistics of batch normalisation as fp16 safetensors."""
    kept = {name: value for name, value in network.state_dict().items() if value.is_floating_point()}
    with write_atomically(path) as temporary:
        temporary.write_bytes(save({name: value.half().contiguous() for name, value in sorted(kept.items())}))
