"""Training: it learns, resumes exactly, repeats itself, refuses bad stores."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import torch
from safetensors.torch import load_file

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from roomkin.stages.contracts.trained import read_config, weights_of
from roomkin.stages.policies import point_cloud
from roomkin.stages.policies.base import load_network, make_policy
from roomkin.stages.training import augment, dataset
from roomkin.stages.training import state as loop
from roomkin.stages.training.augment import list_windows, make_batch
from roomkin.stages.training.dataset import constant_error, frames_of, read_demonstrations, split_episodes
from roomkin.stages.training.state import Line, TrainingState, copy_weights
from roomkin.stages.training.train import outcome, plateau
from roomkin.stages.training.train import run as train
from tests.refusals import refused
from tests.toy_reach import ToyReach, write_store

SMALL = {
    "points": 64,
    "kwargs": {"pointnet_width": 32, "rnn_hidden": 32, "mlp": [32]},
    "batch_size": 8,
    "steps": 6,
    "log_freq": 2,
    "wandb": "disabled",
}


@pytest.fixture(autouse=True)
def _save_often() -> Iterator[None]:
    """States are saved at every line."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "SAVE_FREQ", 2)
        yield


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_store(tmp_path_factory.mktemp("store") / "episodes.h5", episodes=60)


def augmented(
    clouds: torch.Tensor, proprio: torch.Tensor, translation: float = 0.0, jitter: float = 0.0, **values: Any
) -> tuple[torch.Tensor, torch.Tensor]:
    """Augmented sequences; the shares of those that are translated and jittered."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(augment, "TRANSLATION_PROBABILITY", translation)
        patch.setattr(augment, "JITTER_PROBABILITY", jitter)
        return augment.augment(clouds, proprio, PolicyConfig(**values), torch.Generator().manual_seed(0))


def options(**changes: object) -> str:
    return json.dumps(SMALL | changes)


def test_learns_to_reach_what_the_cloud_shows(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Closed loop on unseen goals: the hand ends within 3 cm; before training it does not."""
    monkeypatch.setattr(point_cloud, "FLAG_EMBEDDING", 8)  # with 128 so small a network learns in thousands of steps
    train(episodes=(store,), per_store=60, options=options(steps=800, log_freq=200), out=tmp_path / "policy")
    policy = load_network(tmp_path / "policy", "last")
    reached = []
    for seed in range(1000, 1020):
        toy, acting = ToyReach(seed), policy.make_rollout_policy(1, "most_likely")
        acting.start_episode(0, seed)
        for _ in range(16):
            cloud, proprio = toy.observe()
            toy.step(acting.get_action([0], [cloud], [proprio])[0])
        reached.append(toy.distance < 0.03)
    assert np.mean(reached) >= 0.7
    lines = [json.loads(line) for line in (tmp_path / "policy" / "metrics.jsonl").read_text().splitlines()]
    assert [line["step"] for line in lines] == [200, 400, 600, 800]
    assert lines[-1]["validation_loss"] < lines[0]["validation_loss"]
    said = capsys.readouterr().err
    assert "training: validation loss" in said and "did not learn" not in said


def test_interrupted_equals_uninterrupted(store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    train(episodes=(store,), per_store=8, options=options(), out=whole)

    calls = 0
    augment_once = loop.augment

    def power_cut(*args: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 6:
            raise KeyboardInterrupt
        return augment_once(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(loop, "augment", power_cut)
    with pytest.raises(KeyboardInterrupt):
        train(episodes=(store,), per_store=8, options=options(), out=broken)
    assert not broken.exists()
    monkeypatch.undo()
    train(episodes=(store,), per_store=8, options=options(), out=broken)
    for name in ("policy.safetensors", "last.safetensors", "config.json"):
        assert (whole / name).read_bytes() == (broken / name).read_bytes(), name
    assert [json.loads(line)["step"] for line in (broken / "metrics.jsonl").read_text().splitlines()] == [2, 4, 6]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken", "whole"]


def test_another_run_does_not_go_on_from_the_state(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "validation_batches", lambda *args: iter(()))
    train(episodes=(store,), per_store=8, options=options(), out=tmp_path / "a", seed=1)
    monkeypatch.setattr("roomkin.stages.training.train.save_weights", stop)
    with pytest.raises(KeyboardInterrupt):
        train(episodes=(store,), per_store=8, options=options(), out=tmp_path / "b", seed=0)
    monkeypatch.undo()
    monkeypatch.setattr(loop, "validation_batches", lambda *args: iter(()))
    train(episodes=(store,), per_store=8, options=options(), out=tmp_path / "b", seed=1)
    assert "state.pt is of a run with other data, options, seed or code; kept as" in capsys.readouterr().err
    assert (tmp_path / "a" / "last.safetensors").read_bytes() == (tmp_path / "b" / "last.safetensors").read_bytes()


def test_writes_what_the_contract_says(store: Path, tmp_path: Path) -> None:
    train(episodes=(store, store), per_store=5, options=options(num_checkpoints=2), out=tmp_path / "policy", seed=3)
    config = read_config(tmp_path / "policy")
    assert [s.episodes for s in config.stores] == [5, 5]
    assert config.training_episodes + config.validation_episodes == 10
    assert config.task_options.points == 96
    assert config.checkpoints == ["checkpoints/step_3.safetensors", "checkpoints/step_6.safetensors"]
    kept = load_file(weights_of(tmp_path / "policy", config.checkpoints[-1]))
    last = load_file(tmp_path / "policy" / "last.safetensors")
    assert all(torch.equal(kept[name], last[name]) for name in last)
    policy = load_network(tmp_path / "policy", "checkpoints/step_3.safetensors")
    assert policy.proprio_std[3:7].min() >= 1e-3  # constant entries do not blow up


def test_windows_pad_at_the_end_without_weight(store: Path) -> None:
    data = read_demonstrations([store], 3)
    frames, real = list_windows(data, [1], horizon=10, stride=1)
    assert frames.shape == (14, 10)
    assert frames[0].tolist() == list(range(14, 24))
    assert frames[-1].tolist() == [27] * 10
    assert real[-1].tolist() == [True] + [False] * 9


def test_other_actions_are_other_data(store: Path, tmp_path: Path) -> None:
    other = write_store(tmp_path / "episodes.h5", episodes=3)
    assert read_demonstrations([other], 3).digest == read_demonstrations([store], 3).digest
    with h5py.File(other, "a") as file:
        file["data/demo_2/actions"][0, 6] *= -1
    assert read_demonstrations([other], 3).digest != read_demonstrations([store], 3).digest


def test_the_split_and_the_batches_follow_the_seed(store: Path, tmp_path: Path) -> None:
    data = read_demonstrations([store], 40)
    assert len({tuple(split_episodes(data, seed)[1]) for seed in range(4)}) > 1
    losses = []
    for seed in (0, 1):
        random = [loop.generator(seed, step) for step in (1, 2)]
        losses.append([torch.randint(1000, (4,), generator=each).tolist() for each in random])
    assert losses[0] != losses[1] and losses[0][0] != losses[0][1]


def test_split_is_by_episode_and_store(store: Path) -> None:
    data = read_demonstrations([store, store], 10)
    training, validation = split_episodes(data, seed=0)
    assert sorted(training + validation) == list(range(20))
    assert sum(i < 10 for i in validation) == 1 and len(validation) == 2
    assert split_episodes(read_demonstrations([store], 1), 0) == ([0], [])


def test_downsampling_takes_one_subset_per_sequence(store: Path) -> None:
    data = read_demonstrations([store], 2)
    frames, real = list_windows(data, [0], 5, 5)
    batch = make_batch(data, frames[:1], real[:1], 20, torch.Generator().manual_seed(0))
    assert batch.clouds.shape == (1, 5, 20, 4)
    whole = data.clouds[int(frames[0, 2])].float()
    assert all((whole == point).all(1).any() for point in batch.clouds[0, 2])


def sequences() -> tuple[torch.Tensor, torch.Tensor]:
    return torch.zeros(64, 5, 8, 4), torch.zeros(64, 5, 9)


def test_translation_keeps_hand_and_handle_together() -> None:
    clouds, proprio = augmented(*sequences(), translation=0.5)
    assert torch.equal(clouds[:, :, 0, :3], proprio[..., :3])  # same shift for both
    assert (proprio == proprio[:, :1]).all()  # constant over the sequence
    share = (proprio[:, 0, 0] != 0).float().mean()
    assert 0.3 < share < 0.7
    assert -0.04 <= proprio.min() < -0.03 and 0.03 < proprio.max() <= 0.04  # either way
    assert (clouds[..., 3] == 0).all()
    assert (proprio[..., 3:] == 0).all()


def test_official_translation_moves_the_cloud_alone() -> None:
    clouds, proprio = augmented(*sequences(), translation=1, translation_mode="cloud_only")
    assert (proprio == 0).all()
    assert not torch.equal(clouds[:, 0], clouds[:, 1])


def test_jitter_is_clipped() -> None:
    clouds, proprio = augmented(*sequences(), jitter=1)
    assert clouds[..., :3].abs().max() == pytest.approx(0.015)
    assert 0.005 < clouds[..., :3].std() < 0.01
    assert (proprio == 0).all()


def test_learning_rates() -> None:
    cosine = PolicyConfig(steps=100, learning_rate=1.0, schedule="cosine", warmup=0)
    assert [loop.learning_rate(step, cosine) for step in (0, 50, 100)] == pytest.approx([1, 0.5, 0])
    constant = PolicyConfig(steps=100, learning_rate=1.0, schedule="constant", warmup=4)
    assert [loop.learning_rate(step, constant) for step in range(6)] == pytest.approx([0.25, 0.5, 0.75, 1, 1, 1])
    linear = PolicyConfig(steps=50_000, learning_rate=1.0, schedule="linear", warmup=0)
    assert [loop.learning_rate(step, linear) for step in (0, 10_000, 40_000)] == pytest.approx([1, 0.1, 0.1])


def test_too_few_episodes_and_broken_stores_are_input_errors(store: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has 60 episodes, 61 are asked for"):
        read_demonstrations([store], 61)
    broken = tmp_path / "broken.h5"
    broken.write_bytes(b"no HDF5")
    with pytest.raises(InputError, match=r"broken\.h5: is no readable episode store"):
        read_demonstrations([broken], 1)
    other, shorter = (write_store(tmp_path / name, 2) for name in ("other.h5", "shorter.h5"))
    with h5py.File(other, "a") as file, h5py.File(shorter, "a") as same_task:
        file["data"].attrs["task"] = "drawer"
        same_task["data"].attrs["task_options"] = TaskConfig(points=96, success_fraction=0.25).model_dump_json()
    for one in (other, shorter):
        with refused("E-EPISODES-MIXED"):
            read_demonstrations([store, one], 2)
    with refused("E-EPISODES-TASK"):
        train(episodes=(other,), per_store=2, task="door", options=options(), out=tmp_path / "policy")
    with refused("E-EPISODES-POINTS"):
        train(episodes=(store,), per_store=2, options=json.dumps({"points": 97}), out=tmp_path / "policy")
    assert not (tmp_path / "policy").exists()


@pytest.mark.parametrize(("select", "kept"), [("validation", 2), ("last", 3)])
def test_the_best_weights_are_those_of_the_lowest_validation_loss(select: str, kept: int) -> None:
    policy = make_policy(PolicyConfig.model_validate(json.loads(options())))
    state = TrainingState(torch.optim.AdamW(policy.parameters()), fingerprint="")
    for step, loss in enumerate((3.0, 1.0, 2.0), start=1):
        state.step = step
        torch.nn.init.constant_(policy.head.bias, step)
        state.note(policy, loss, {"step": step}, select)
    assert state.best_step == kept
    assert (state.best["head.bias"] == kept).all()


def test_the_validation_loss_is_the_mean_over_steps_and_is_no_training(
    store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = read_demonstrations([store], 3)
    frames, real = list_windows(data, [0, 1, 2], 5, 5)
    one = make_batch(data, frames[:2], real[:2], 64, loop.generator(0))
    batches = [replace(one, weights=torch.ones(2, 5)), replace(one, weights=torch.full((2, 5), 0.1))]
    policy = torch.nn.Module()

    def losses(*each: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        return 10 * each[3].mean(), (40 if policy.training else 20) * each[3].mean()

    monkeypatch.setattr(policy, "loss", losses, raising=False)
    found = loop.validate(policy, batches)  # type: ignore[arg-type]
    assert policy.training
    assert found["validation_loss"] == pytest.approx((10 * 10 + 1 * 1) / 11, abs=1e-4)
    assert found["validation_error"] == pytest.approx(2 * found["validation_loss"], abs=1e-4)


def test_a_policy_is_fitted_to_its_training_episodes(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dataset, "VALIDATION_FRACTION", 0.5)
    train(episodes=(store,), per_store=8, out=tmp_path / "policy", options=options(steps=1), seed=1)
    data = read_demonstrations([store], 8)
    training, validation = split_episodes(data, 1)
    kept = load_file(tmp_path / "policy/policy.safetensors")
    whole, own = (data.proprio[frames_of(data, chosen)] for chosen in ([*training, *validation], training))
    assert torch.allclose(kept["proprio_mean"], own.mean(0), atol=1e-5)
    assert torch.allclose(kept["proprio_std"], own.std(0).clamp_min(1e-3), atol=1e-5)
    assert not torch.allclose(own.mean(0), whole.mean(0), atol=1e-5)


def test_gradients_are_clipped(store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Adam's step has the size of the learning rate, unless the whole gradient is far below its epsilon of 1e-8."""
    data = read_demonstrations([store], 4)

    def largest_change(clip: float) -> float:
        run = PolicyConfig.model_validate_json(options(steps=1, weight_decay=0.0, warmup=0))
        monkeypatch.setattr(loop, "GRADIENT_CLIP", clip)
        torch.manual_seed(0)
        policy = make_policy(run)
        before = copy_weights(policy.state_dict())
        optimiser = torch.optim.AdamW(policy.parameters(), weight_decay=0.0)
        state = TrainingState(optimiser, fingerprint="")
        loop.optimise(policy, state, loop.Setting(run, data, 0, tmp_path), lambda line: None)
        return max(float((after - before[name]).abs().max()) for name, after in policy.state_dict().items())

    assert largest_change(1e-12) < 1e-6 < 1e-5 < largest_change(1.0)


def test_batches_are_put_together_where_the_frames_are(store: Path) -> None:
    """Random numbers come from the host: `meta` stands for any device but the host, and refuses to be mixed with it."""
    data = read_demonstrations([store], 2).on("meta")
    frames, real = list_windows(data, [0, 1], 5, 5)
    random = torch.Generator().manual_seed(0)
    batch = make_batch(data, frames, real, 20, random)
    clouds, proprio = augmented(batch.clouds, batch.proprio, translation=0.4, jitter=1)
    assert clouds.device.type == proprio.device.type == batch.actions.device.type == batch.weights.device.type == "meta"
    assert clouds.shape == (len(frames), 5, 20, 4)


def test_a_training_that_learned_nothing_is_told(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = options(learning_rate=1e-9)
    train(episodes=(store,), per_store=60, options=run, out=tmp_path / "policy", seed=2)
    config = read_config(tmp_path / "policy")
    lines = [json.loads(line) for line in (tmp_path / "policy" / "metrics.jsonl").read_text().splitlines()]
    best = next(line for line in lines if line["step"] == config.best_step)
    assert (config.best_loss, config.best_error) == (best["validation_loss"], best["validation_error"])
    assert config.best_error and config.constant_error and config.best_error > config.constant_error > 0.3
    assert config.plateau == 6 and not config.late
    assert "training: seed 2 did not learn: validation loss" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("errors", "step"), [([0.3, 0.5, 0.2], 0), ([0.6, 0.4, 0.7, 0.2], 10), ([0.6, 0.5, 0.4], 20), ([0.6, 0.7], 20)]
)
def test_the_plateau_ends_where_the_error_first_falls_below_a_constant_action_s(errors: list[float], step: int) -> None:
    lines: list[Line] = [{"step": 10 * n, "validation_error": error} for n, error in enumerate(errors, 1)]
    assert plateau(lines, 0.5) == step
    assert plateau(lines, None) is None


def test_a_training_that_learned_late_is_told(store: Path, tmp_path: Path) -> None:
    train(episodes=(store,), per_store=60, options=options(steps=8), out=tmp_path / "policy", seed=5)
    config = read_config(tmp_path / "policy").model_copy(update={"best_error": 0.3, "constant_error": 0.5})
    early, late = (config.model_copy(update={"plateau": step}) for step in (2, 3))
    assert (early.late, late.late) == (False, True)
    assert outcome(early).startswith("validation loss") and outcome(late).startswith(
        "seed 5 learned late, after step 3"
    )
    assert not late.model_copy(update={"best_error": 0.6}).late  # it did not learn at all


def test_the_constant_action_is_the_mean_of_training_held_against_validation(store: Path) -> None:
    data = read_demonstrations([store], 3)
    actions = torch.zeros_like(data.actions)
    first, second, _ = torch.arange(len(actions)).split(data.lengths)
    actions[first], actions[second] = 1.0, 0.5
    data = replace(data, actions=actions)
    assert constant_error(data, [0, 1], [2]) == pytest.approx(0.75)
    assert constant_error(data, [0, 2], [1, 2]) == pytest.approx(np.sqrt((0 + 0.25) / 2), abs=1e-5)
    assert constant_error(data, [0, 1, 2], []) is None


def test_without_validation_episodes_nothing_is_said(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train(episodes=(store,), per_store=1, options=options(), out=tmp_path / "policy")
    config = read_config(tmp_path / "policy")
    assert (config.best_loss, config.best_error, config.constant_error, config.plateau) == (None, None, None, None)
    assert config.learned and not config.late
    assert "validation loss" not in capsys.readouterr().err
