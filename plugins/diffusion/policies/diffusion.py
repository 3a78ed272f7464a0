"""Policy `diffusion`: the next actions, denoised in a few steps from noise (Chi et al., Diffusion Policy, RSS 2023).

One observation, seen by the paper's PointNet, conditions the actions of the `rnn_horizon` steps from there on. In
closed loop the first `executed` of them are done, then the policy looks again. The network estimates clean actions from
noisy ones.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Self

import numpy as np
import torch
from pydantic import Field, ValidationError, model_validator
from torch import Tensor, nn

from stages.contracts.episode_store import ACTION
from stages.contracts.errors import InputError
from stages.contracts.files import first_error
from stages.contracts.section import Section
from stages.contracts.training_run import TrainingRun
from stages.policies import Choice, Float
from stages.policies.seeing import SeeingPolicy

TEMPERATURE: dict[Choice, float] = {"sample": 1.0, "sharpened": 0.5, "most_likely": 0.0}  # of the noise begun with


class Options(Section):
    """`own: {diffusion: ...}` of a training run."""

    levels: int = Field(100, ge=2, description="noise levels in training")
    steps: int = Field(10, ge=1, description="of them, evenly spaced, denoised in closed loop (DDIM)")
    executed: int = Field(4, ge=1, description="actions done between two looks")
    width: int = Field(256, ge=8, description="of the layers that denoise")
    layers: int = Field(3, ge=1, description="how many they are")

    @model_validator(mode="after")
    def _steps_differ(self) -> Self:
        if self.steps > self.levels:
            raise ValueError(f"steps is {self.steps}, more than levels, {self.levels}")
        return self


def signal_levels(levels: int) -> Tensor:
    """(levels + 1,) shares of the variance that is signal, from 1 to nearly 0: cosine (Nichol and Dhariwal 2021)."""
    turn = (torch.linspace(0, 1, levels + 1) + 0.008) / 1.008 * torch.pi / 2
    return (turn.cos().square() / turn[0].cos().square()).clamp(1e-4, 1.0)


class Policy(SeeingPolicy):
    """PointNet and proprioception -> denoiser of a sequence of actions."""

    updates: Tensor
    signal: Tensor

    def __init__(self, run: TrainingRun) -> None:
        super().__init__(run)
        try:
            self.options = options = Options.model_validate(run.own.get("diffusion", {}))
        except ValidationError as error:
            fix = f"the keys are {', '.join(Options.model_fields)}"
            raise InputError("own.diffusion", f"{first_error(error)}.", fix, code="E-DIFFUSION-OPTION") from None
        chunk, width = run.rnn_horizon * ACTION, options.width
        self.enter = nn.Linear(chunk + self.features + 2, width)
        self.blocks = nn.ModuleList(
            nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, width))
            for _ in range(options.layers)
        )
        self.leave = nn.Linear(width, chunk)
        self.register_buffer("updates", torch.zeros((), dtype=torch.int64))
        self.register_buffer("signal", signal_levels(options.levels), persistent=False)

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
        level = torch.randint(1, self.options.levels + 1, (len(actions),), generator=random).to(actions.device)
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
        actions, count = noise, self.options.steps
        levels = torch.linspace(self.options.levels, 0, count + 1).round().long().tolist()
        for level, lower in pairwise(levels):
            now, then = self.signal[level], self.signal[lower]
            clean = self.clean(actions, torch.full((len(noise),), level, device=noise.device), seen).clamp(-1, 1)
            left = (actions - now.sqrt() * clean) / (1 - now).sqrt()
            actions = then.sqrt() * clean + (1 - then).sqrt() * left
        return actions

    def actor(self, slots: int, choose: Choice) -> "Actor":
        """One that looks again after `executed` actions."""
        return Actor(self, slots, TEMPERATURE[choose])


class Actor:
    """Acts for `slots` environments, each with its own plan and its own random numbers."""

    def __init__(self, policy: Policy, slots: int, temperature: float) -> None:
        self.policy, self.temperature = policy, temperature
        self.plans: list[list[Float]] = [[] for _ in range(slots)]
        self.random = [np.random.default_rng(0) for _ in range(slots)]

    def reset(self, slot: int, seed: int) -> None:
        """Start an episode; `seed` decides every random choice of it."""
        self.plans[slot] = []
        self.random[slot] = np.random.default_rng((seed, 7))

    def act(self, slots: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """Actions (n, 7) in [-1, 1] of the environments in `slots`, from clouds (P, 4) and proprioception (9,)."""
        looking = [(i, slot) for i, slot in enumerate(slots) if not self.plans[slot]]
        if looking:
            found = self.plan_actions(
                [s for _, s in looking], [clouds[i] for i, _ in looking], [proprio[i] for i, _ in looking]
            )
            for (_, slot), plan in zip(looking, found, strict=True):
                self.plans[slot] = list(plan[: self.policy.options.executed])
        return np.stack([self.plans[slot].pop(0) for slot in slots])

    @torch.inference_mode()
    def plan_actions(self, slots: list[int], clouds: list[Float], proprio: list[Float]) -> Float:
        """The next actions (n, T, 7) of some environments."""
        policy = self.policy
        kept = [policy.thin_cloud(cloud, self.random[slot]) for slot, cloud in zip(slots, clouds, strict=True)]
        seen = policy.flatten_observations(policy.encode_observations(kept, proprio)[:, None])
        shape = (policy.run.rnn_horizon, ACTION)
        noise = np.stack([self.random[slot].standard_normal(shape, np.float32) for slot in slots])
        plans: Float = (
            policy.sample(torch.from_numpy(noise * np.float32(self.temperature)).to(seen.device), seen).cpu().numpy()
        )
        return plans
