"""The optimisation: a step is a function of weights, seed and step number, so that a resumed run equals a whole one."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from roomkin.stages.cli import progress
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import TrainablePolicy
from roomkin.stages.policies.checkpoint import save_weights
from roomkin.stages.training.augment import augment
from roomkin.stages.training.batches import Batch, list_windows, make_batch
from roomkin.stages.training.dataset import DemonstrationSet, split_episodes
from roomkin.stages.training.handle_augmentation import vary_handles
from roomkin.stages.training.logbook import Line
from roomkin.stages.training.state import TrainingState

LINEAR_STEPS, LINEAR_FLOOR = 10_000, 0.1  # official: 100 epochs of 100 steps
GRADIENT_CLIP = 1.0  # largest norm of the gradient; official code: none
SAVE_FREQ = 1000  # steps between states that an interrupted run resumes from


@dataclass(frozen=True)
class Setting:
    """What a training run works on; the frames of `data` are where the network is."""

    config: PolicyConfig
    data: DemonstrationSet
    seed: int
    work: Path


def learning_rate(step: int, config: PolicyConfig) -> float:
    """Learning rate of update `step` (from 0)."""
    peak = config.learning_rate * min(1.0, (step + 1) / max(1, config.warmup))
    if config.schedule == "cosine":
        return peak * 0.5 * (1 + math.cos(math.pi * step / config.steps))
    if config.schedule == "linear":
        return peak * (1 - (1 - LINEAR_FLOOR) * min(1.0, step / LINEAR_STEPS))
    return peak


def generator(*key: int) -> torch.Generator:
    """Random numbers that depend on `key` alone."""
    return torch.Generator().manual_seed(int(np.random.SeedSequence(key).generate_state(1)[0]))


def optimise(policy: TrainablePolicy, state: TrainingState, setting: Setting, log: Callable[[Line], None]) -> None:
    """Train `policy` from `state.step` to the last step; `state` collects the best weights."""
    config, data = setting.config, setting.data
    training, validation = split_episodes(data, setting.seed)
    frames, real = list_windows(data, training, config.horizon, stride=1)
    held_out = list(validation_batches(setting, validation))
    keep_at = {round(config.steps * (k + 1) / config.num_checkpoints) for k in range(config.num_checkpoints)}
    losses: list[Tensor] = []
    for step in progress(range(state.step, config.steps), "training", config.steps - state.step):
        for group in state.optimiser.param_groups:
            group["lr"] = learning_rate(step, config)
        random = generator(setting.seed, step)
        chosen = torch.randint(len(frames), (config.batch_size,), generator=random).numpy()
        batch = make_batch(data, frames[chosen], real[chosen], config.points, random, config.handle)
        batch = vary_handles(batch, random) if config.handle else batch
        clouds, proprio = augment(batch.clouds, batch.proprio, config, random)
        loss, _ = policy.loss(clouds, proprio, batch.actions, batch.weights)
        state.optimiser.zero_grad()
        if loss.requires_grad:
            loss.backward()
        torch.nn.utils.clip_grad_norm_(policy.parameters(), GRADIENT_CLIP)
        state.optimiser.step()
        losses.append(loss.detach())
        state.step = step + 1
        if state.step in keep_at:
            save_weights(setting.work / "checkpoints" / f"step_{state.step}.safetensors", policy.state_dict())
        if state.step % config.log_freq == 0 or state.step == config.steps:
            validated = validate(policy, held_out)
            line: Line = {
                "step": state.step,
                "loss": round(torch.stack(losses).mean().item(), 5),
                **validated,
                "learning_rate": learning_rate(step, config),
            }
            log(line)
            state.note(policy, validated.get("validation_loss"), line, config.select)
            if state.step < config.steps and state.is_due(SAVE_FREQ):
                state.save(policy, setting.work)
            losses = []


def validation_batches(setting: Setting, episodes: list[int]) -> Iterator[Batch]:
    """The same sequences each time: side by side, not augmented, with a fixed subset of points."""
    if not episodes:
        return
    config = setting.config
    frames, real = list_windows(setting.data, episodes, config.horizon, stride=config.horizon)
    random = generator(setting.seed, 2**31)
    for part in np.array_split(np.arange(len(frames)), -(-len(frames) // config.batch_size)):
        yield make_batch(setting.data, frames[part], real[part], config.points, random, config.handle)


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
