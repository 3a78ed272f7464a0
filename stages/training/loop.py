"""The optimisation: a step is a function of weights, seed and step number, so that a resumed run equals a whole one."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from stages.cli import progress
from stages.contracts.training_run import TrainingRun
from stages.policies import TrainablePolicy
from stages.policies.checkpoint import save_weights
from stages.policies.marking import load_marker
from stages.training.augment import augment
from stages.training.dataset import Batch, DemonstrationSet, gather, list_windows, split_episodes
from stages.training.logbook import Line
from stages.training.state import TrainingState

LINEAR_STEPS, LINEAR_FLOOR = 10_000, 0.1  # official: 100 epochs of 100 steps


@dataclass(frozen=True)
class Setting:
    """What a training run works on; the frames of `data` are where the network is."""

    run: TrainingRun
    data: DemonstrationSet
    seed: int
    work: Path


def learning_rate(step: int, run: TrainingRun) -> float:
    """Learning rate of update `step` (from 0)."""
    peak = run.learning_rate * min(1.0, (step + 1) / max(1, run.warmup))
    if run.schedule == "cosine":
        return peak * 0.5 * (1 + math.cos(math.pi * step / run.steps))
    if run.schedule == "linear":
        return peak * (1 - (1 - LINEAR_FLOOR) * min(1.0, step / LINEAR_STEPS))
    return peak


def generator(*key: int) -> torch.Generator:
    """Random numbers that depend on `key` alone."""
    return torch.Generator().manual_seed(int(np.random.SeedSequence(key).generate_state(1)[0]))


def optimise(policy: TrainablePolicy, state: TrainingState, setting: Setting, log: Callable[[Line], None]) -> None:
    """Train `policy` from `state.step` to the last step; `state` collects the best weights."""
    run, data = setting.run, setting.data
    training, validation = split_episodes(data, run.validation_fraction, setting.seed)
    frames, real = list_windows(data, training, run.rnn_horizon, stride=1)
    held_out = list(validation_batches(setting, validation))
    keep_at = {round(run.steps * (k + 1) / run.keep) for k in range(run.keep)}
    marker = load_marker() if run.handle else None
    losses: list[Tensor] = []
    for step in progress(range(state.step, run.steps), "training", run.steps - state.step):
        for group in state.optimiser.param_groups:
            group["lr"] = learning_rate(step, run)
        random = generator(setting.seed, step)
        chosen = torch.randint(len(frames), (run.batch_size,), generator=random).numpy()
        batch = gather(data, frames[chosen], real[chosen], run.network.points, random, run.handle)
        batch = marker.vary(batch, random) if marker else batch
        clouds, proprio = augment(batch.clouds, batch.proprio, run, random)
        loss, _ = policy.loss(clouds, proprio, batch.actions, batch.weights)
        state.optimiser.zero_grad()
        if loss.requires_grad:
            loss.backward()
        torch.nn.utils.clip_grad_norm_(policy.parameters(), run.gradient_clip)
        state.optimiser.step()
        losses.append(loss.detach())
        state.step = step + 1
        if state.step in keep_at:
            save_weights(setting.work / "checkpoints" / f"step_{state.step}.safetensors", policy.state_dict())
        if state.step % run.log_every == 0 or state.step == run.steps:
            validated = validate(policy, held_out)
            line: Line = {
                "step": state.step,
                "loss": round(torch.stack(losses).mean().item(), 5),
                **validated,
                "learning_rate": learning_rate(step, run),
            }
            log(line)
            state.note(policy, validated.get("validation_loss"), line, run.select)
            if state.step < run.steps and state.is_due(run.save_every):
                state.save(policy, setting.work)
            losses = []


def validation_batches(setting: Setting, episodes: list[int]) -> Iterator[Batch]:
    """The same sequences each time: side by side, not augmented, with a fixed subset of points."""
    if not episodes:
        return
    run = setting.run
    frames, real = list_windows(setting.data, episodes, run.rnn_horizon, stride=run.rnn_horizon)
    random = generator(setting.seed, 2**31)
    for part in np.array_split(np.arange(len(frames)), -(-len(frames) // run.batch_size)):
        yield gather(setting.data, frames[part], real[part], run.network.points, random, run.handle)


@torch.no_grad()
def validate(policy: TrainablePolicy, batches: list[Batch]) -> dict[str, float]:
    """Loss and action error on the validation episodes; empty without any."""
    if not batches:
        return {}
    policy.eval()  # dropout and the like are for training
    results = [torch.stack(policy.loss(batch.clouds, batch.proprio, batch.actions, batch.weights)) for batch in batches]
    policy.train()
    weights = torch.stack([batch.weights.sum() for batch in batches])
    loss, error = (torch.stack(results) * weights[:, None]).sum(0) / weights.sum()
    return {"validation_loss": round(loss.item(), 5), "validation_error": round(error.item(), 5)}
