"""Policy `diffusion`: the next actions, denoised in a few steps from noise (Chi et al., Diffusion Policy, RSS 2023).

One observation, seen by the paper's PointNet, conditions the actions of the `horizon` steps from there on. In closed
loop the first `n_action_steps` of them are done, then the policy looks again. The network estimates clean actions from
noisy ones.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn

from roomkin.plugins.diffusion.policies.diffusion_options import Options
from roomkin.stages.contracts.episode_store import ACTION
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.plugins import parse_kwargs
from roomkin.stages.policies.base import ActionMode, Float
from roomkin.stages.policies.point_cloud import PointCloudPolicy

TEMPERATURE: dict[ActionMode, float] = {"sample": 1.0, "sharpened": 0.5, "most_likely": 0.0}  # of the noise begun with


def signal_levels(levels: int) -> Tensor:
    """(levels + 1,) shares of the variance that is signal, from 1 to nearly 0: cosine (Nichol and Dhariwal 2021)."""
    turn = (torch.linspace(0, 1, levels + 1) + 0.008) / 1.008 * torch.pi / 2
    return (turn.cos().square() / turn[0].cos().square()).clamp(1e-4, 1.0)


class Policy(PointCloudPolicy):
    """PointNet and proprioception -> denoiser of a sequence of actions."""

    options: Options
    updates: Tensor
    signal: Tensor

    def __init__(self, config: PolicyConfig) -> None:
        options = parse_kwargs(Options, config.kwargs)
        super().__init__(config, options)
        chunk, width = config.horizon * ACTION, options.width
        self.enter = nn.Linear(chunk + self.features + 2, width)
        self.blocks = nn.ModuleList(
            nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, width))
            for _ in range(options.layers)
        )
        self.leave = nn.Linear(width, chunk)
        self.register_buffer("updates", torch.zeros((), dtype=torch.int64))
        self.register_buffer("signal", signal_levels(options.num_train_timesteps), persistent=False)

    def clean(self, noisy: Tensor, level: Tensor, seen: Tensor) -> Tensor:
        """Estimate (B, T, 7) of the actions behind noisy ones at levels (B,), given observations (B, F)."""
        signal = self.signal[level][:, None]
        x = self.enter(torch.cat([noisy.flatten(1), seen, signal.sqrt(), (1 - signal).sqrt()], dim=1))
        for block in self.blocks:
            x = x + block(x)
        return self.leave(x).unflatten(1, (-1, ACTION))  # type: ignore[no-any-return]

    def loss(self, clouds: Tensor, proprio: Tensor, actions: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Mean squared error of the denoised actions, and the RMS error: of those sampled, in training of the denoised.

        The noise of an update follows from how many came before, so that a resumed run equals a whole one.
        """
        training = torch.is_grad_enabled()
        random = torch.Generator().manual_seed(int(self.updates) if training else 0)
        self.updates += training
        seen = self.flatten_observations(self.encode(clouds[:, :1], proprio[:, :1]))
        levels = self.options.num_train_timesteps
        level = torch.randint(1, levels + 1, (len(actions),), generator=random).to(actions.device)
        noise = torch.randn(actions.shape, generator=random).to(actions.device)
        signal = self.signal[level][:, None, None]
        denoised = self.clean(signal.sqrt() * actions + (1 - signal).sqrt() * noise, level, seen)
        found = denoised.detach() if training else self.sample(noise, seen)
        error = (found - actions).square().mean(-1)
        total = weights.sum()
        loss = ((denoised - actions).square().mean(-1) * weights).sum() / total
        return loss, ((error * weights).sum() / total).sqrt()

    def flatten_observations(self, encoded: Tensor) -> Tensor:
        """Observations (B, F) from encoded sequences of one step (B, 1, F)."""
        return self.add_handle_offset(encoded).squeeze(1)

    def sample(self, noise: Tensor, seen: Tensor) -> Tensor:
        """Actions (B, T, 7) in [-1, 1], denoised from noise (B, T, 7) by DDIM (Song et al. 2021), without new noise."""
        actions, count = noise, self.options.num_inference_steps
        levels = torch.linspace(self.options.num_train_timesteps, 0, count + 1).round().long().tolist()
        for level, lower in pairwise(levels):
            now, then = self.signal[level], self.signal[lower]
            clean = self.clean(actions, torch.full((len(noise),), level, device=noise.device), seen).clamp(-1, 1)
            left = (actions - now.sqrt() * clean) / (1 - now).sqrt()
            actions = then.sqrt() * clean + (1 - then).sqrt() * left
        return actions

    def make_rollout_policy(self, num_envs: int, mode: ActionMode) -> "Rollout":
        """One that looks again after `n_action_steps` actions."""
        return Rollout(self, num_envs, TEMPERATURE[mode])


class Rollout:
    """The policy in closed loop: each environment has its own plan and its own random numbers."""

    def __init__(self, policy: Policy, num_envs: int, temperature: float) -> None:
        self.policy, self.temperature = policy, temperature
        self.plans: list[list[Float]] = [[] for _ in range(num_envs)]
        self.random = [np.random.default_rng(0) for _ in range(num_envs)]

    def start_episode(self, env_id: int, seed: int) -> None:
        """As of `RolloutPolicy`."""
        self.plans[env_id] = []
        self.random[env_id] = np.random.default_rng((seed, 7))

    def get_action(self, env_ids: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """As of `RolloutPolicy`."""
        looking = [place for place, i in enumerate(env_ids) if not self.plans[i]]
        if looking:
            ids = [env_ids[place] for place in looking]
            plans = self.plan_actions(ids, [clouds[place] for place in looking], [proprio[place] for place in looking])
            for i, plan in zip(ids, plans, strict=True):
                self.plans[i] = list(plan[: self.policy.options.n_action_steps])
        return np.stack([self.plans[i].pop(0) for i in env_ids])

    @torch.inference_mode()
    def plan_actions(self, env_ids: list[int], clouds: list[Float], proprio: list[Float]) -> Float:
        """The next actions (n, T, 7) of some environments."""
        policy = self.policy
        kept = [policy.thin_cloud(cloud, self.random[i]) for i, cloud in zip(env_ids, clouds, strict=True)]
        seen = policy.flatten_observations(policy.encode_observations(kept, proprio)[:, None])
        shape = (policy.config.horizon, ACTION)
        noise = np.stack([self.random[i].standard_normal(shape, np.float32) for i in env_ids])
        start = torch.from_numpy(noise * np.float32(self.temperature)).to(seen.device)
        plans: Float = policy.sample(start, seen).cpu().numpy()
        return plans
