"""Reflected sequences are what a mirror shows: of observations as they are made, of actions as they are executed."""

from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.simulation.controller import apply_delta, scale_action
from stages.simulation.observation import finger_points, proprioception
from stages.simulation.robot import REST, panda_chain
from stages.training.augment import mirror_some, mirrored
from stages.training.dataset import Batch, gather, read_demonstrations, windows
from tests.toy_reach import write_store

Array = NDArray[np.float64]
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def reflection(pose: Array) -> Array:
    """The hand's pose (4, 4) as a mirror in y = 0 shows it, its two fingers exchanged."""
    return np.asarray(MIRROR @ pose @ MIRROR)


def batch_of(proprio: Array, actions: Array, clouds: Array | None = None) -> Batch:
    clouds = np.zeros((len(proprio), 1, 4)) if clouds is None else clouds
    tensors = (torch.as_tensor(np.asarray(array, np.float32))[None] for array in (clouds, proprio, actions))
    return Batch(*tensors, weights=torch.ones(1, len(proprio)))


def poses(count: int) -> Array:
    """Hands about the rest pose, turned by up to 80 degrees."""
    random = np.random.default_rng(0)
    near = np.tile(panda_chain().pose(REST[None])[0], (count, 1, 1))
    near[:, :3, 3] += random.uniform(-0.3, 0.3, (count, 3))
    near[:, :3, :3] = Rotation.from_rotvec(random.uniform(-0.8, 0.8, (count, 3))).as_matrix() @ near[:, :3, :3]
    return near


def test_an_episode_mirrored_twice_is_itself(tmp_path: Path) -> None:
    data = read_demonstrations([write_store(tmp_path / "episodes.h5", 3)], 3)
    frames, real = windows(data, [0, 1, 2], 10, 4)
    batch = gather(data, frames, real, 96, torch.Generator().manual_seed(0))
    once, twice = mirrored(batch), mirrored(mirrored(batch))
    for name in ("clouds", "proprio", "actions", "weights"):
        assert torch.equal(getattr(twice, name), getattr(batch, name)), name
    assert not torch.equal(once.actions, batch.actions)


def test_observations_are_those_of_the_reflected_hand() -> None:
    rest, fingers = panda_chain().pose(REST[None])[0], np.array([0.01, 0.03])
    hands = poses(20)
    seen = np.stack([proprioception(hand, fingers, rest) for hand in hands])
    expected = np.stack([proprioception(reflection(hand), fingers[::-1], rest) for hand in hands])
    points = np.stack([np.c_[finger_points(hand, fingers, 32), np.ones(32)] for hand in hands])
    reflected = mirrored(batch_of(seen, np.zeros((20, 7)), points))
    np.testing.assert_allclose(reflected.proprio[0], expected, atol=1e-6)
    for hand, cloud in zip(hands, reflected.clouds[0].numpy(), strict=True):
        other = finger_points(reflection(hand), fingers[::-1], 32)
        distances = np.linalg.norm(cloud[:, None, :3] - other[None], axis=-1)
        assert distances.min(axis=1).max() < 1e-6  # the same points, the fingers' rows exchanged
        assert (cloud[:, 3] == 1).all()


def test_the_reflected_action_moves_the_reflected_hand_to_the_reflection() -> None:
    random = np.random.default_rng(1)
    hands, actions = poses(20), random.uniform(-1, 1, (20, 7))
    reflected = mirrored(batch_of(np.zeros((20, 9)), actions)).actions[0].double().numpy()

    def moved(start: Array, action: Array) -> Array:
        return apply_delta(start, scale_action(action[:, :6], 0.05, 0.2))

    there = moved(np.stack([reflection(hand) for hand in hands]), reflected)
    np.testing.assert_allclose(there, [reflection(hand) for hand in moved(hands, actions)], atol=1e-6)
    np.testing.assert_allclose(reflected[:, 6], actions[:, 6], atol=1e-6)


@pytest.mark.parametrize(("probability", "low", "high"), [(0.0, 0, 0), (0.5, 35, 65), (1.0, 100, 100)])
def test_some_sequences_are_mirrored(probability: float, low: int, high: int) -> None:
    batch = Batch(torch.ones(100, 2, 3, 4), torch.ones(100, 2, 9), torch.ones(100, 2, 7), torch.ones(100, 2))
    out = mirror_some(batch, probability, torch.Generator().manual_seed(0))
    turned = out.actions[:, 0, 1] < 0
    assert low <= turned.sum() <= high
    for tensor in (out.actions[..., 1], out.proprio[..., 1], out.clouds[..., 0, 1]):
        assert torch.equal(tensor < 0, turned[:, None].expand(-1, 2))  # whole sequences, in all their parts
