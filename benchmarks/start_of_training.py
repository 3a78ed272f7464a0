"""What the first updates of training do to the network, with each of the two mends and at higher learning rates.

    python -m benchmarks.start_of_training --episodes results/demonstrations/drawer/cousin_*/episodes.h5 --per-store 30

Per start of training: medians over seeds, after `--updates`, of the largest pooled feature, the share of the LSTM's
outputs beyond .98, and the share of the first hidden layer that no validation sequence wakes; and how many seeds are
hardly better than a constant action.
"""

import argparse
import contextlib
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import torch

from stages.contracts.training_run import NetworkConfig, TrainingRun
from stages.policies.bc_rnn_gmm import Policy
from stages.training.dataset import constant_error, frames_of, read_demonstrations, split_episodes
from stages.training.loop import Setting, optimise, validate, validation_batches
from stages.training.state import TrainingState

STARTS = {"at random": (False, 0), "+ warm-up": (False, 100), "at the actions": (True, 0), "+ both": (True, 100)}
PEAKS = (2e-3, 4e-3, 8e-3)  # `lite`'s, twice, four times
SATURATED = 0.98


class Found(NamedTuple):
    """What a network is like after some updates."""

    feature: float
    saturated: float
    dead: float
    error: float
    constant: float

    @property
    def stuck(self) -> bool:
        """Whether it is hardly better than a constant action."""
        return self.error > 0.9 * self.constant


class EnoughError(Exception):
    """So many updates are done."""


def first_updates(setting: Setting) -> Found:
    """The network at the first line of the log of a training of full length."""
    torch.manual_seed(setting.seed)
    data, run = setting.data, setting.run
    training, validation = split_episodes(data, run.validation_fraction, setting.seed)
    policy = Policy(run)
    policy.fit(data.clouds, data.proprio, data.actions, frames_of(data, training))
    optimiser = torch.optim.AdamW(policy.parameters(), weight_decay=run.weight_decay, fused=True)

    def stop(line: object) -> None:
        raise EnoughError

    with contextlib.suppress(EnoughError):
        optimise(policy, TrainingState(optimiser, fingerprint=""), setting, stop)
    batches = list(validation_batches(setting, validation))
    with torch.no_grad():
        encoded = policy.add_handle_offset(policy.encode(batches[0].clouds, batches[0].proprio))
        memory = policy.lstm(encoded)[0]
        hidden = policy.mlp[0](memory)
        return Found(
            feature=float(encoded[..., : run.network.pointnet_width].max()),
            saturated=float((memory.abs() > SATURATED).float().mean()),
            dead=float((hidden.flatten(0, 1).amax(0) <= 0).float().mean()),
            error=validate(policy, batches)["validation_error"],
            constant=constant_error(data, training, validation) or 0.0,
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=Path, nargs="+", required=True)
    parser.add_argument("--per-store", type=int, required=True)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--updates", type=int, default=200)
    given = parser.parse_args()
    torch.set_num_threads(1)
    data = read_demonstrations(given.episodes, given.per_store)
    print(
        "| learning rate | start | largest feature | saturated | dead | error | stuck |\n|---|---|---|---|---|---|---|"
    )
    for peak in PEAKS:
        for name, (at_actions, warmup) in STARTS.items():
            network = NetworkConfig(start_at_actions=at_actions)
            run = TrainingRun(learning_rate=peak, warmup=warmup, network=network, log_every=given.updates)
            with TemporaryDirectory() as folder:
                settings = [Setting(run, data, seed, Path(folder)) for seed in range(given.seeds)]
                found = [first_updates(setting) for setting in settings]
            feature, saturated, dead, error, _ = (median(values) for values in zip(*found, strict=True))
            stuck = sum(one.stuck for one in found)
            activations = f"{feature:.0f} | {saturated:.0%} | {dead:.0%}"
            print(f"| {peak:g} | {name} | {activations} | {error:.2f} | {stuck} of {given.seeds} |", flush=True)


if __name__ == "__main__":
    main()
