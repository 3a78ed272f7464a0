"""Every seed that the config takes works where it is used, and gives something of its own."""

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

from roomkin.plugins.furniture.catalogue import sample
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.collect import attempt_seeds
from roomkin.stages.evaluation.states import initial_states
from roomkin.stages.policies.bc_rnn_gmm import Rollout
from roomkin.stages.simulation.robot import REST
from roomkin.stages.tables.intervals import PLACE, resample_rates
from roomkin.stages.tasks.filmed import sample_factors
from roomkin.stages.tasks.initial_state import sample_initial_state
from roomkin.stages.tasks.observation import CameraRig, Sensing, jitter, shoulder
from roomkin.stages.training.state import generator
from roomkin.stages.training.train import run as train
from tests.toy_reach import write_store

LARGEST = 2**53 - 1
SEEDS = [0, 20261122, 2**32, LARGEST]


def random_actions(seed: int) -> list[float]:
    acting = Rollout(SimpleNamespace(), 1, "sample")  # type: ignore[arg-type]
    acting.start_episode(0, seed)
    return [acting.random[0].random() for _ in range(3)]


def resamples(seed: int) -> list[Any]:
    places = pd.MultiIndex.from_tuples([("f", "a", 0), ("g", "b", 0), ("h", "c", 0)], names=PLACE)
    side = pd.DataFrame([[0.0, 1.0, 1.0]], columns=places)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(TablesConfig, "seed", seed)
        return [array[:20].tolist() for (array,) in resample_rates([[side]], TablesConfig())]


def noisy_cloud(seed: int) -> list[float]:
    """What a depth camera that errs, and is never moved, shows of a wall."""
    options = TaskConfig(camera_jitter=(0.0, 0.0))
    rig = CameraRig([shoulder(options)], options, Sensing(depth_noise=True))
    rig.place({}, 0, seed)
    picture = np.full((1, 8, 8, 4), [0, 0, -1000, 1], np.int16)
    joints = np.append(REST, [0.04, 0.04])
    cloud: list[float] = rig.observation(joints, [picture], np.array([1], np.int16), 0)["point_cloud"].ravel().tolist()
    return cloud


DRAWS: dict[str, Callable[[int], Any]] = {
    "model": lambda seed: sample("mug", 0, seed).parameters,
    "attempts": lambda seed: list(attempt_seeds(seed, "twin", 4)),
    "states of the roles": lambda seed: initial_states("roles", seed, 4),
    "states of the split": lambda seed: initial_states("test", seed, 4, place=3),
    "initial state": lambda seed: str(sample_initial_state(seed, TaskConfig())),
    "camera": lambda seed: jitter(seed, 0, TaskConfig(camera_jitter=(0.1, 0.1))).tolist(),
    "noise of depth": noisy_cloud,
    "factors": lambda seed: sample_factors(seed, RandomiseOptions()),
    "actions": random_actions,
    "batches": lambda seed: torch.rand(3, generator=generator(seed, 5)).tolist(),
    "resamples": resamples,
}


@pytest.mark.parametrize("name", list(DRAWS))
def test_every_seed_works_and_matters(name: str) -> None:
    found = [DRAWS[name](seed) for seed in SEEDS]
    assert found == [DRAWS[name](seed) for seed in SEEDS]
    assert len({str(each) for each in found}) == len(SEEDS)


def test_a_policy_is_trained_with_the_largest_seed(tmp_path: Path) -> None:
    store = write_store(tmp_path / "episodes.h5", episodes=2)
    small = {"points": 64, "kwargs": {"pointnet_width": 8, "rnn_hidden": 8, "mlp": [8]}, "steps": 1, "batch_size": 2}
    weights = []
    for seed in (0, LARGEST):
        out = tmp_path / str(seed)
        train(episodes=(store,), per_store=2, out=out, options=json.dumps(small), seed=seed)
        weights.append((out / "policy.safetensors").read_bytes())
        assert json.loads((out / "config.json").read_text())["seed"] == seed
    assert weights[0] != weights[1]


def test_the_config_says_how_large_a_seed_may_be() -> None:
    assert ExperimentConfig(seeds=[LARGEST]).seeds == [LARGEST]
    with pytest.raises(ValueError, match="less than 9007199254740992"):
        ExperimentConfig(seeds=[LARGEST + 1])


def test_initial_states_are_those_of_the_published_rollouts() -> None:
    """With others whoever repeats a run of docs/results would do another study."""
    assert initial_states("roles", 2026, 2) == [2_219_207_311, 2_219_207_312]
    assert initial_states("test", 2026, 1) == [2_898_415_089]
