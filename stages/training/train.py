"""Command `train`: one policy on the episode stores of a training set (paper B.3)."""

import hashlib
import json
import shutil
import sys
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from typing import Literal

import torch

from roomkin.stages.config.code import code_digest, cover
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options, write_json, write_text
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.trained import CHECKPOINTS, TrainedPolicy
from roomkin.stages.plugins import find_options, parse_kwargs, qualify_module
from roomkin.stages.policies.base import FILES, make_policy, save_weights
from roomkin.stages.training.dataset import (
    DemonstrationSet,
    constant_error,
    frames_of,
    read_demonstrations,
    split_episodes,
)
from roomkin.stages.training.state import Line, Logbook, Setting, TrainingState, optimise

WANDB_FOLDER = Path("logs/training")  # its runs are named by time: nothing for results/


def run(
    *,
    episodes: tuple[Path, ...],
    per_store: int,
    out: Path,
    task: str = "",
    options: str = "",
    seed: int = 0,
    threads: int = 1,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Train a policy.

    An interrupted run leaves its state in the folder `<out>.work`, and the same command and code go on from there.

    Args:
        episodes: episode stores (episodes.h5) of the training set.
        per_store: how many episodes of each are used, from the first.
        task: that they must be of; '': any.
        out: folder for policy.safetensors (best), last.safetensors, config.json, metrics.jsonl.
        options: one entry of `training.configs` as JSON, or a JSON file.
        seed: of initial weights, validation split, sampling and augmentation.
        threads: CPU threads. Results are repeatable for a given number.
        device: where the network is trained.
    """
    config = read_options(PolicyConfig, options)
    kwargs = parse_kwargs(find_options("policies", config.policy), config.kwargs)
    config = config.model_copy(update={"kwargs": kwargs.model_dump(mode="json")})
    if device == "cuda" and not torch.cuda.is_available():
        what = "cuda is asked for, but torch finds no GPU."
        raise InputError("device", what, "set `device: cpu`", code="E-DEVICE-GPU")
    torch.set_num_threads(threads)
    torch.manual_seed(seed)
    data = read_demonstrations(episodes, per_store, config.release_included, task)
    if data.clouds.shape[1] < config.points:
        what = f"is {config.points}, but the clouds have {data.clouds.shape[1]} points."
        raise InputError("training.points", what, code="E-EPISODES-POINTS")
    if config.handle:
        data = data.segment_handles()
    setting = Setting(config, data.on(device), seed, work=out.parent / f"{out.name}.work")
    training, validation = split_episodes(data, seed)
    policy = make_policy(config)
    policy.fit(data.clouds, data.proprio, data.actions, frames_of(data, training))
    policy.to(device)
    learned = [*policy.parameters()] or [torch.nn.Parameter(torch.zeros(0))]  # a policy may be fitted alone
    optimiser = torch.optim.AdamW(learned, weight_decay=config.weight_decay, fused=True)
    state = TrainingState(optimiser, fingerprint(data, config, seed))
    if state.resume(policy, setting.work):
        print(f"training: goes on from step {state.step}", file=sys.stderr)
    setting.work.mkdir(parents=True, exist_ok=True)
    metrics = setting.work / "metrics.jsonl"
    logbook = Logbook(metrics, state.lines, config.wandb, WANDB_FOLDER, config.model_dump(mode="json") | {"seed": seed})
    optimise(policy, state, setting, logbook.write)
    logbook.close()

    kept = sorted((setting.work / "checkpoints").glob("*.safetensors")) if config.num_checkpoints else []
    pack(setting.work / "checkpoints", out / CHECKPOINTS)  # the work folder stays whole until everything is written
    save_weights(out / FILES["last"], policy.state_dict())
    save_weights(out / FILES["best"], state.best)
    write_text(out / "metrics.jsonl", metrics.read_text(encoding="utf-8"))
    constant = constant_error(data, training, validation)
    found = TrainedPolicy(
        task=data.task, task_options=data.task_options, config=config, seed=seed, stores=data.stores,
        data_digest=data.digest, training_episodes=len(training), validation_episodes=len(validation),
        parameters=sum(parameter.numel() for parameter in policy.parameters()), best_step=state.best_step,
        best_loss=state.best_loss,
        best_error=next(line for line in state.lines if line["step"] == state.best_step).get("validation_error"),
        constant_error=constant, plateau=plateau(state.lines, constant),
        checkpoints=[f"checkpoints/{path.name}" for path in kept],
    )  # fmt: skip
    write_json(out / "config.json", found)
    if found.best_loss is not None:
        print(f"training: {outcome(found)}", file=sys.stderr)
    shutil.rmtree(setting.work / "checkpoints", ignore_errors=True)
    for path in setting.work.iterdir():
        if path.suffix != ".refused":  # a state that was set aside is the user's to look at
            path.unlink()
    if not any(setting.work.iterdir()):
        setting.work.rmdir()


def plateau(lines: Sequence[Line], constant: float | None) -> int | None:
    """The last logged step before the validation error first fell below that of a constant action; 0: none."""
    if constant is None:
        return None
    steps = takewhile(lambda line: (line.get("validation_error") or 0.0) >= constant, lines)
    return max((int(line["step"] or 0) for line in steps), default=0)


def outcome(policy: TrainedPolicy) -> str:
    """How a training with validation episodes ended, in a line."""
    text = f"validation loss {policy.best_loss:.2f} at step {policy.best_step}"
    if policy.best_error is None or policy.constant_error is None:
        return text
    text += f"; its actions are off by {policy.best_error:.2f}, one constant action by {policy.constant_error:.2f}"
    if not policy.learned:
        return f"seed {policy.seed} did not learn: {text}"
    return f"seed {policy.seed} learned late, after step {policy.plateau}: {text}" if policy.late else text


def fingerprint(data: DemonstrationSet, config: PolicyConfig, seed: int) -> str:
    """What must be equal for an interrupted run to go on: data, options, seed and code."""
    module = qualify_module("policies", config.policy)
    cover([module])
    what = [data.digest, config.model_dump(mode="json"), seed, code_digest(__name__, module)]
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()
