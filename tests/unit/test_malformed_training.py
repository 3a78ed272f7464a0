"""Episodes, weights and the state of a training: broken in every way, refused or set aside."""

import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import torch
from safetensors.numpy import save_file
from safetensors.torch import save_file as save_torch

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import TrainablePolicy, load_network, make_policy, save_weights
from roomkin.stages.training.dataset import read_demonstrations
from roomkin.stages.training.state import TrainingState
from tests.refusals import refused
from tests.unit.contract_files import HAND, Bench, weights, with_value


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def replace(file: h5py.File, name: str, array: Any) -> None:
    del file[name]
    if array is not None:
        file[name] = array


POINTS, PROPRIO, ACTIONS = (f"data/demo_1/{name}" for name in ("obs/point_cloud", "obs/proprio", "actions"))
STEPS = np.full((6, 7), 0.5, np.float32)
EPISODES = {
    "no data": ("data", None, "has no group 'data'"),
    "a gap": ("data/demo_0", None, "demo_0"),
    "no actions": (ACTIONS, None, "has no array 'data/demo_1/actions'"),
    "no clouds": (POINTS, None, "obs/point_cloud"),
    "no steps": (ACTIONS, STEPS[:0], "actions: is empty"),
    "a number": (ACTIONS, np.float32(1), "actions: is empty"),
    "NaN action": (ACTIONS, with_value(STEPS, np.nan), "actions: holds NaN"),
    "infinite action": (ACTIONS, with_value(STEPS, -np.inf), "actions: holds NaN or infinity"),
    "large action": (ACTIONS, with_value(STEPS, 1.5), "actions: holds 1.5"),
    "six numbers": (ACTIONS, STEPS[:, :6], "actions: has shape (6, 6), not (6, 7)"),
    "whole numbers": (ACTIONS, STEPS.astype(int), "actions: has type int64"),
    "fewer actions": (ACTIONS, STEPS[:5], "obs/point_cloud: has shape (6, 64, 4), not (5, 64, 4)"),
    "more actions": (ACTIONS, np.repeat(STEPS, 2, axis=0), "not (12, 64, 4)"),
    "fewer proprio": (PROPRIO, np.ones((5, 9), np.float32), "obs/proprio: has shape (5, 9)"),
    "wide proprio": (PROPRIO, np.ones((6, 10), np.float32), "obs/proprio: has shape (6, 10)"),
    "no turns": (PROPRIO, np.zeros((6, 9), np.float32), "obs/proprio: holds quaternions"),
    "NaN proprio": (PROPRIO, with_value(HAND, np.nan), "obs/proprio: holds NaN"),
    "three columns": (POINTS, np.ones((6, 64, 3), np.float16), "obs/point_cloud: has shape (6, 64, 3)"),
    "other points": (POINTS, np.ones((6, 32, 4), np.float16), "obs/point_cloud: has shape (6, 32, 4)"),
    "fewer clouds": (POINTS, np.ones((5, 64, 4), np.float16), "obs/point_cloud: has shape (5, 64, 4)"),
    "NaN cloud": (POINTS, with_value(np.ones((6, 64, 4), np.float16), np.nan), "obs/point_cloud: holds NaN"),
    "millimetres": (POINTS, np.full((6, 64, 4), 900, np.float16), "obs/point_cloud: holds 900"),
}


@pytest.mark.parametrize("case", list(EPISODES))
def test_episodes(bench: Bench, case: str) -> None:
    name, array, words = EPISODES[case]
    with h5py.File(bench.path("episodes"), "a") as file:
        replace(file, name, array)
    bench.refused("episodes", "episodes.h5", words)
    with pytest.raises(InputError, match=r"episodes\.h5"):
        read_demonstrations([bench.path("episodes")], 2)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("task", None, "no text attribute 'task'"),
        ("task", 3, "no text attribute 'task'"),
        ("asset", "", "no text attribute 'asset'"),
        ("task_options", "{", "task_options"),
        ("task_options", '{"points": -1}', "task_options: points"),
        ("task_options", '{"point": 64}', "task_options: point"),
    ],
)
def test_attributes_of_episodes(bench: Bench, name: str, value: Any, words: str) -> None:
    with h5py.File(bench.path("episodes"), "a") as file:
        del file["data"].attrs[name]
        if value is not None:
            file["data"].attrs[name] = value
    bench.refused("episodes", "episodes.h5", words)


def test_episodes_that_the_ledger_does_not_count(bench: Bench) -> None:
    with h5py.File(bench.path("episodes"), "a") as file:
        del file["data/demo_1"]
    bench.refused("episodes", "has 1 episodes, attempts.jsonl counts 2")


@pytest.mark.parametrize(("stores", "count"), [(0, 1), (1, 0), (1, -3), (1, 3)])
def test_nothing_to_train_on(bench: Bench, stores: int, count: int) -> None:
    with pytest.raises(InputError, match=r"name no episodes|2 episodes, 3 are asked for"):
        read_demonstrations([bench.path("episodes")] * stores, count)


def changed(**arrays: Any) -> dict[str, np.ndarray]:
    return {name: array for name, array in (weights() | arrays).items() if array is not None}


WEIGHTS = {
    "NaN": (changed(**{"head.weight": np.full((4, 6), np.nan, np.float32)}), "head.weight: holds NaN"),
    "no normaliser": (changed(proprio_mean=None), "proprio_mean: has shape None"),
    "other normaliser": (changed(proprio_std=np.ones(8, np.float32)), "proprio_std: has shape (8,)"),
    "no spread": (changed(proprio_std=np.zeros(9, np.float32)), "proprio_std: is not positive"),
    "more weights": (changed(more=np.ones(3, np.float32)), "holds 27 numbers, config.json says parameters: 24"),
    "fewer weights": (changed(**{"head.weight": np.ones((4, 5), np.float32)}), "holds 20 numbers"),
}


@pytest.mark.parametrize("case", list(WEIGHTS))
@pytest.mark.parametrize("name", ["policy", "last"])
def test_weights(bench: Bench, case: str, name: str) -> None:
    arrays, words = WEIGHTS[case]
    save_file(arrays, bench.root / f"training/{name}.safetensors")
    bench.refused("policy", f"{name}.safetensors", words)


def test_weights_of_another_network(bench: Bench) -> None:
    save_file(changed(**{"head.weight": np.ones((6, 4), np.float32)}), bench.root / "training/last.safetensors")
    bench.refused("policy", "last.safetensors", "has other weights than policy.safetensors")
    with refused("E-POLICY-WEIGHTS"):
        load_network(bench.root / "training", "best")


def test_weights_of_a_policy_of_ones_own_are_its_own(bench: Bench) -> None:
    """No normaliser, numbers that numpy does not have, and a negative log_std: not for us to judge."""
    bench.edit("policy", lambda content: content["config"].update(policy="my_package.policies.mlp"))
    own = {"layer": torch.ones(3, dtype=torch.bfloat16), "log_std": torch.full((2,), -1.0)}
    for name in ("policy", "last"):
        save_torch(own, bench.root / f"training/{name}.safetensors")
    assert main(["policy", str(bench.path("policy"))]) == 0
    save_torch(own | {"log_std": torch.full((2,), torch.nan)}, bench.root / "training/last.safetensors")
    bench.refused("policy", "last.safetensors", "log_std: holds NaN")


def test_weights_have_the_permissions_of_other_files(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    save_weights(tmp_path / "policy.safetensors", {"x": torch.zeros(2)})
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "policy.safetensors")]
    assert modes[0] == modes[1]


# the state of an interrupted training

SMALL = PolicyConfig(points=16, kwargs={"pointnet_width": 8, "rnn_hidden": 8, "mlp": [8], "gmm_modes": 1})


def training() -> tuple[TrainablePolicy, TrainingState]:
    torch.manual_seed(0)
    policy = make_policy(SMALL)
    return policy, TrainingState(torch.optim.AdamW(policy.parameters()), "this run")


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    policy, state = training()
    state.step = 5
    folder = tmp_path_factory.mktemp("state")
    state.save(policy, folder)
    return torch.load(folder / "state.pt", weights_only=True)


STATES: dict[str, Callable[[dict[str, Any]], Any]] = {
    "another object": lambda state: [1, 2],
    "no fingerprint": lambda state: {name: value for name, value in state.items() if name != "fingerprint"},
    "no optimiser": lambda state: {name: value for name, value in state.items() if name != "optimiser"},
    "other weights": lambda state: state | {"policy": {"x": torch.zeros(3)}},
    "other best": lambda state: state | {"best": {"x": torch.zeros(3)}},
    "weights as text": lambda state: state | {"policy": "weights"},
    "other optimiser": lambda state: state | {"optimiser": {"state": {}, "param_groups": []}},
    "optimiser as text": lambda state: state | {"optimiser": "adam"},
}


@pytest.mark.parametrize("case", ["empty", "text", "cut", "pickle", *STATES])
def test_a_state_that_cannot_be_used_is_set_aside(
    tmp_path: Path, state: dict[str, Any], case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "state.pt"
    torch.save(STATES.get(case, dict)(state), path)
    if case == "cut":
        cut(path)
    elif case == "pickle":
        torch.save({"x": Path("/")}, path)  # an object that is no tensor: never unpickled
    elif case in ("empty", "text"):
        path.write_text("" if case == "empty" else "state")
    content = path.read_bytes()
    policy, fresh = training()
    before = {name: tensor.clone() for name, tensor in policy.state_dict().items()}
    assert fresh.resume(policy, tmp_path) is False
    assert fresh.step == 0 and all(torch.equal(before[name], tensor) for name, tensor in policy.state_dict().items())
    assert [file.name for file in tmp_path.iterdir()] == ["state.pt.refused"]
    assert (tmp_path / "state.pt.refused").read_bytes() == content
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "state.pt" in line and "training starts over" in line


def test_a_good_state_is_used(tmp_path: Path, state: dict[str, Any]) -> None:
    torch.save(state, tmp_path / "state.pt")
    policy, fresh = training()
    assert fresh.resume(policy, tmp_path) is True and fresh.step == 5
