"""The policy network: exact savings, mixture, files, closed loop."""

import copy
from typing import get_args

import numpy as np
import pytest
import torch
from torch.nn import functional

from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import ActionMode
from roomkin.stages.policies.bc_rnn_gmm import Mixture, Policy
from roomkin.stages.policies.point_cloud import PointNet


def dense(net: PointNet, clouds: torch.Tensor) -> torch.Tensor:
    """The plain network: embedding beside every point, gradient through every point."""
    x = net.first(torch.cat([clouds[..., :3], net.flag(clouds[..., 3].long())], dim=-1))
    for layer in net.rest:
        x = layer(functional.gelu(x))
    return functional.relu(x.amax(dim=1))


def clouds(count: int, points: int) -> torch.Tensor:
    random = torch.Generator().manual_seed(0)
    xyz = torch.randn((count, points, 3), generator=random)
    return torch.cat([xyz, (torch.rand((count, points, 1), generator=random) < 0.2).float()], dim=-1)


@pytest.mark.parametrize("layers", [2, 3])
def test_savings_leave_values_and_gradients_as_they_are(layers: int) -> None:
    torch.manual_seed(1)
    net = PointNet(width=64, layers=layers, flag_embedding=128)
    plain, points = copy.deepcopy(net), clouds(12, 200)
    target = torch.randn(12, 64)
    value, expected = net(points), dense(plain, points)
    assert torch.allclose(value, expected, atol=1e-5)
    with torch.no_grad():
        assert torch.allclose(net(points), expected, atol=1e-5), "in inference"
    (value * target).sum().backward()
    (expected * target).sum().backward()
    for (name, ours), theirs in zip(net.named_parameters(), plain.parameters(), strict=True):
        error = (ours.grad - theirs.grad).norm() / theirs.grad.norm()
        assert error < 1e-4, f"{name}: relative gradient error {error:.1e}"


def test_standardised_features_have_unit_variance() -> None:
    torch.manual_seed(0)
    net, points = PointNet(32, 2, 128), clouds(200, 60)
    points[..., :3] += torch.randn(200, 1, 3)  # clouds that differ
    with torch.no_grad():
        before = net(points).std(0).mean()
        net.standardise(points)
        pooled = net._winners(points)[0]
    assert before < 0.7
    assert torch.allclose(pooled.std(0), torch.ones(32), atol=1e-3)
    assert torch.allclose(pooled.mean(0), torch.ones(32), atol=1e-3)


def test_with_a_floor_what_never_varies_is_not_blown_up() -> None:
    torch.manual_seed(0)
    net, points = PointNet(32, 2, 8), clouds(200, 60)
    points[..., :3] += torch.randn(200, 1, 3)
    points[:, 0] = torch.tensor([10.0, -10.0, 10.0, 1.0])  # a finger, always at the same place, wins many channels
    with torch.no_grad():
        still = net._winners(points)[0].std(0) < 1e-3
        growth = {}
        for floor in (0.0, 0.5):
            scaled = copy.deepcopy(net)
            scaled.standardise(points, floor)
            growth[floor] = (scaled.rest[-1].weight / net.rest[-1].weight).abs()[:, 0]
    assert 0 < still.sum() < 16
    assert growth[0.5][still].max() < 4 * growth[0.5][~still].median() < growth[0.0][still].max() / 100


def test_bf16_is_near() -> None:
    torch.manual_seed(0)
    net, points = PointNet(32, 2, 8), clouds(5, 100)
    expected = net(points)
    net.bf16 = True
    assert 0 < (net(points) - expected).abs().max() < 0.05


def test_mixture_density_and_choices() -> None:
    mixture = Mixture(
        logits=torch.tensor([[0.0, 2.0]]),
        means=torch.tensor([[[0.1] * 7, [-0.4] * 7]]),
        stds=torch.full((1, 2, 7), 0.3),
    )
    components = torch.distributions.Independent(torch.distributions.Normal(mixture.means, mixture.stds), 1)
    reference = torch.distributions.MixtureSameFamily(
        torch.distributions.Categorical(logits=mixture.logits), components
    )
    action = torch.linspace(-0.5, 0.5, 7)[None]
    assert torch.allclose(mixture.log_prob(action), reference.log_prob(action), atol=1e-5)
    assert torch.allclose(mixture.most_likely(), torch.full((1, 7), -0.4))
    # the first mode has weight 1 / (1 + e^2) = 0.119
    assert torch.allclose(mixture.sample(torch.tensor([0.11])), torch.full((1, 7), 0.1))
    assert torch.allclose(mixture.sample(torch.tensor([0.13])), torch.full((1, 7), -0.4))


@pytest.mark.parametrize("asked", [True, False])
def test_training_starts_at_the_mean_and_deviation_of_the_actions(asked: bool) -> None:
    torch.manual_seed(0)
    policy = Policy(PolicyConfig(points=64, kwargs={"init_from_action_stats": asked}))
    actions = torch.tensor([0.1, -0.2, 0.3, 0, 0, 0, 1.0]) + 0.3 * torch.randn(200, 7) * torch.tensor([1.0] * 6 + [0])
    seen, felt = clouds(200, 64), torch.randn(200, 9)
    policy.fit(seen, felt, torch.cat([actions, torch.full((1, 7), 50.0)]), torch.arange(200))  # the last is unused
    start = policy(seen[None, :10], felt[None, :10])
    means, stds = start.means.mean((0, 1, 2)), start.stds.mean((0, 1, 2))
    near = (means - actions.mean(0).clamp(-0.9, 0.9)).abs().max() < 0.1 and (stds[:6] - 0.3).abs().max() < 0.05
    assert bool(near) == asked
    assert not asked or stds[6] < policy.options.gmm_min_std + 0.02


def test_paper_sizes() -> None:
    """B.3: 2-layer 512 PointNet, 128-d flag embedding, LSTM 512; 3.01 M parameters with MLP 512, 512 and 5 modes."""
    sizes = {"pointnet_width": 512, "pointnet_layers": 2, "rnn_hidden": 512, "mlp": [512, 512], "gmm_modes": 5}
    policy = Policy(PolicyConfig(kwargs=sizes))
    assert policy.pointnet.first.in_features == 3 + 128
    assert sum(parameter.numel() for parameter in policy.parameters()) == pytest.approx(3.01e6, rel=0.01)


def test_gripper_frame_sees_no_common_shift() -> None:
    policy = Policy(PolicyConfig(kwargs={"cloud_frame": "gripper"}))
    cloud, proprio, shift = clouds(1, 40)[None], torch.randn(1, 1, 9), torch.tensor([0.3, -0.2, 0.1])
    moved, moved_proprio = cloud.clone(), proprio.clone()
    moved[..., :3] += shift
    moved_proprio[..., :3] += shift
    assert torch.allclose(policy.move_to_frame(cloud, proprio), policy.move_to_frame(moved, moved_proprio), atol=1e-6)
    robot = Policy(PolicyConfig(kwargs={"cloud_frame": "robot"}))
    assert torch.equal(robot.move_to_frame(cloud, proprio), cloud[..., :3])


def test_it_acts_as_the_network_on_the_last_steps() -> None:
    """Stepwise in a batch of episodes of unequal age = the whole sequence at once."""
    torch.manual_seed(0)
    policy = Policy(PolicyConfig(points=40, horizon=4)).eval()
    observations = clouds(6, 40).numpy(), np.random.default_rng(0).normal(size=(6, 9)).astype(np.float32)
    acting = policy.make_rollout_policy(2, "most_likely")
    acting.start_episode(0, 1)
    acting.start_episode(1, 2)
    for step in range(6):
        env_ids = [0, 1] if step >= 3 else [0]
        actions = acting.get_action(
            env_ids, [observations[0][step]] * len(env_ids), [observations[1][step]] * len(env_ids)
        )
    for env_id, first in ((0, 2), (1, 3)):
        with torch.no_grad():
            mixture = policy(*(torch.from_numpy(o[first:])[None] for o in observations))
        assert np.allclose(actions[env_id], mixture.most_likely()[0, -1].clamp(-1, 1).numpy(), atol=1e-5)


def test_the_sharper_the_choice_the_rarer_the_lighter_mode() -> None:
    """Of two modes with weights 1/3 and 2/3 the lighter one is drawn in 1/3, in 1/5 and in none of the steps."""
    policy = Policy(PolicyConfig(points=40, horizon=1, kwargs={"gmm_modes": 2})).eval()
    with torch.no_grad():
        policy.head.weight.zero_()
        policy.head.bias.copy_(torch.tensor([0.0, np.log(2.0), *[-1.0] * 7, *[1.0] * 7, *[0.0] * 14]))
    observations = clouds(1, 40).numpy(), np.zeros((1, 9), np.float32)
    shares = []
    for mode in get_args(ActionMode):
        acting = policy.make_rollout_policy(1, mode)
        acting.start_episode(0, 1)
        shares.append(np.mean([acting.get_action([0], *observations)[0, 0] < 0 for _ in range(400)]))
    assert shares == pytest.approx([1 / 3, 1 / 5, 0], abs=0.06)
