"""The optimisation, its curves (metrics.jsonl; Weights & Biases, offline by default), and all that lets it go on.

A step is a function of weights, seed and step number, so that a resumed run equals a whole one.
"""

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from torch import Tensor

from roomkin.stages.cli import progress
from roomkin.stages.contracts.errors import explain
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.system import name_file_in_errors
from roomkin.stages.policies.base import TrainablePolicy, save_weights
from roomkin.stages.training.augment import Batch, augment, list_windows, make_batch, vary_handles
from roomkin.stages.training.dataset import DemonstrationSet, split_episodes

Line = dict[str, float | int | None]
Mode = Literal["disabled", "offline", "online"]


class Logbook:
    """Appends lines to a metrics file; a resumed run goes on behind the lines it had."""

    def __init__(self, path: Path, lines: list[Line], wandb_mode: Mode, folder: Path, config: dict[str, Any]) -> None:
        self.path = path
        with name_file_in_errors(path):
            self.path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        self.run = start_wandb(wandb_mode, folder, config)
        for line in lines:
            self._mirror(line)

    def write(self, line: Line) -> None:
        """Append one line."""
        with name_file_in_errors(self.path), self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        self._mirror(line)

    def close(self) -> None:
        """Finish the Weights & Biases run."""
        if self.run is not None:
            self.run.finish()

    def _mirror(self, line: Line) -> None:
        if self.run is not None:
            self.run.log({name: value for name, value in line.items() if name != "step"}, step=int(line["step"] or 0))


def start_wandb(mode: Mode, folder: Path, config: dict[str, Any]) -> Any:
    """A run that writes below `folder`/wandb, or None where it is switched off or cannot start."""
    if mode == "disabled":
        return None
    try:
        import wandb

        folder.mkdir(parents=True, exist_ok=True)
        off = dict.fromkeys(("x_disable_stats", "x_disable_meta", "disable_git", "disable_code"), True)
        settings = wandb.Settings(silent=True, console="off", **off)
        return wandb.init(project="acdc", mode=mode, dir=folder, config=config, settings=settings)
    except Exception as error:  # a logger must not end a training run, whatever it stumbles over
        print(f"warning: no Weights & Biases run: {error}", file=sys.stderr)
        return None


STATE = "state.pt"
KEPT = ("step", "best_step", "best_loss", "best", "lines")


@dataclass
class TrainingState:
    """The run after `step` updates. `fingerprint` names data, options and seed: another run must not go on from it."""

    optimiser: torch.optim.Optimizer
    fingerprint: str
    step: int = 0
    saved: int = 0
    best_step: int = 0
    best_loss: float | None = None
    best: dict[str, Tensor] = field(default_factory=dict)
    lines: list[Line] = field(default_factory=list)

    def note(self, policy: TrainablePolicy, validation_loss: float | None, line: Line, select: str) -> None:
        """Remember the line, and the weights if they are the best so far (without validation: the last ones)."""
        self.lines.append(line)
        latest = select == "last" or validation_loss is None
        if latest or self.best_loss is None or (validation_loss is not None and validation_loss < self.best_loss):
            self.best_step, self.best_loss = self.step, validation_loss
            self.best = copy_weights(policy.state_dict())

    def is_due(self, every: int) -> bool:
        """Whether `every` steps have passed since the last save."""
        return self.step - self.saved >= every

    def save(self, policy: TrainablePolicy, folder: Path) -> None:
        """Write the state; a crash while writing leaves the last one."""
        self.saved = self.step
        content: dict[str, Any] = {"policy": policy.state_dict(), "optimiser": self.optimiser.state_dict()}
        content |= {name: getattr(self, name) for name in ("fingerprint", *KEPT)}
        with write_atomically(folder / STATE) as temporary:
            torch.save(content, temporary)

    def resume(self, policy: TrainablePolicy, folder: Path) -> bool:
        """Go on from the state in `folder` if there is one of this very run; any other is set aside."""
        path = folder / STATE
        if not path.is_file():
            return False
        try:
            content = torch.load(path, weights_only=True, map_location="cpu")
            reason = self._fault(content, policy)
        except Exception as error:  # torch, zipfile and pickle raise many kinds for a broken file
            reason = f"cannot be read ({explain(error)})"
        if reason:
            refused = path.replace(path.with_name(f"{STATE}.refused"))
            print(f"training: {path} {reason}; kept as {refused.name}, training starts over", file=sys.stderr)
            return False
        policy.load_state_dict(content["policy"])
        self.optimiser.load_state_dict(content["optimiser"])
        for name in KEPT:
            setattr(self, name, content[name])
        self.saved = self.step
        return True

    def _fault(self, content: Any, policy: TrainablePolicy) -> str:
        """Why the content of a state file is of no use; '' if nothing is wrong with it."""
        if not isinstance(content, dict) or not set(content) >= {"policy", "optimiser", "fingerprint", *KEPT}:
            return "is no training state"
        if content["fingerprint"] != self.fingerprint:
            return "is of a run with other data, options, seed or code"
        weights = policy.state_dict()
        for name in ("policy", "best"):
            shapes = {key: tensor.shape for key, tensor in content[name].items()}
            if shapes != {key: tensor.shape for key, tensor in weights.items()} and (name == "policy" or shapes):
                return f"holds other weights ({name})"
        groups = [group["params"] for group in content["optimiser"]["param_groups"]]
        if [len(group) for group in groups] != [len(group["params"]) for group in self.optimiser.param_groups]:
            return "holds another optimiser"
        return ""


def copy_weights(weights: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """A copy that later updates do not touch."""
    return {name: tensor.detach().clone() for name, tensor in weights.items()}


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
            line: Line = {"step": state.step, "loss": round(torch.stack(losses).mean().item(), 5)}
            line |= validated | {"learning_rate": learning_rate(step, config)}
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
