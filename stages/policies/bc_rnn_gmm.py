"""BC-RNN-GMM: PointNet and proprioception -> LSTM -> MLP -> mixture of Gaussians over actions (paper B.3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from roomkin.stages.contracts.episode_store import ACTION
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.plugins import parse_kwargs
from roomkin.stages.policies.base import ActionMode, Float
from roomkin.stages.policies.bc_rnn_gmm_options import Options
from roomkin.stages.policies.point_cloud import PointCloudPolicy

POWERS: dict[ActionMode, float] = {"sample": 1.0, "sharpened": 2.0, "most_likely": 1e4}  # of the weights of the modes


@dataclass(frozen=True)
class Mixture:
    """Diagonal Gaussians: logits (..., M), means and stds (..., M, A)."""

    logits: Tensor
    means: Tensor
    stds: Tensor

    def log_prob(self, actions: Tensor) -> Tensor:
        """Log-density (...) of actions (..., A)."""
        z = (actions.unsqueeze(-2) - self.means) / self.stds
        normal = -0.5 * z.square().sum(-1) - self.stds.log().sum(-1) - 0.5 * z.shape[-1] * math.log(2 * math.pi)
        return torch.logsumexp(functional.log_softmax(self.logits, -1) + normal, -1)

    def select_steps(self, steps: Sequence[int]) -> "Mixture":
        """Of mixtures (B, T, ...) the one (B, ...) at one step per row."""
        rows = range(len(steps))
        return Mixture(self.logits[rows, steps], self.means[rows, steps], self.stds[rows, steps])

    def most_likely(self) -> Tensor:
        """Mean (..., A) of the mode with the largest weight."""
        return self._mean_of(self.logits.argmax(-1))

    def sample(self, draws: Tensor, power: float = 1.0) -> Tensor:
        """Means (..., A) of modes drawn by their weight to a power; `draws` (...) are uniform in [0, 1).

        Robomimic adds noise of 1e-4 to it in rollouts (`low_noise_eval`), 5 micrometres: left out.
        """
        reached = (power * self.logits).softmax(-1).cumsum(-1) > draws.unsqueeze(-1)
        return self._mean_of(reached.float().argmax(-1))  # no mode reached (rounding): argmax of zeros is mode 0

    def _mean_of(self, mode: Tensor) -> Tensor:
        index = mode[..., None, None].expand(*mode.shape, 1, self.means.shape[-1])
        return self.means.gather(-2, index).squeeze(-2)


State = tuple[Tensor, Tensor]
START_MEAN, START_STD = 0.9, 0.01  # largest mean (before atanh), least deviation at which a mode starts; chosen


class Policy(PointCloudPolicy):
    """The paper's policy."""

    options: Options

    def __init__(self, config: PolicyConfig) -> None:
        options = parse_kwargs(Options, config.kwargs)
        super().__init__(config, options)
        self.lstm = nn.LSTM(self.features, options.rnn_hidden, batch_first=True)
        sizes = [options.rnn_hidden, *options.mlp]
        self.mlp = nn.Sequential(*(nn.Sequential(nn.Linear(a, b), nn.ReLU()) for a, b in pairwise(sizes)))
        self.head = nn.Linear(sizes[-1], options.gmm_modes * (1 + 2 * ACTION))

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Fit the normaliser; with `init_from_action_stats` modes start near mean and deviation of the actions."""
        super().fit(clouds, proprio, actions, frames)
        if self.options.init_from_action_stats:
            self.start_at(actions[frames])

    @torch.no_grad()
    def start_at(self, actions: Tensor) -> None:
        """Let every mode be about the mean and deviation of `actions` (F, 7), whatever is seen.

        From a start at random all weights first move together to make the deviations smaller. In fifty updates that
        saturates a third of the LSTM and silences half of the MLP, and some trainings never recover.
        """
        modes = self.options.gmm_modes
        means = actions.mean(0).clamp(-START_MEAN, START_MEAN).atanh()
        stds = (actions.std(0) - self.options.gmm_min_std).clamp_min(START_STD)
        _, mean_bias, std_bias = self.head.bias.split([modes, modes * ACTION, modes * ACTION])
        mean_bias.add_(means.repeat(modes))
        std_bias.copy_(stds.expm1().log().repeat(modes))  # softplus of it is the deviation

    def decode(self, encoded: Tensor, state: State | None = None) -> tuple[Mixture, State]:
        """Mixtures (B, T, ...) of encoded observations (B, T, F), and the LSTM's state behind the last one."""
        memory, state = self.lstm(self.add_handle_offset(encoded), state)
        out = self.head(self.mlp(memory))
        modes = self.options.gmm_modes
        logits, means, stds = out.split([modes, modes * ACTION, modes * ACTION], dim=-1)
        means, stds = (each.unflatten(-1, (modes, ACTION)) for each in (means, stds))
        return Mixture(logits, means.tanh(), functional.softplus(stds) + self.options.gmm_min_std), state

    def forward(self, clouds: Tensor, proprio: Tensor) -> Mixture:
        """Mixtures (B, T, ...) of sequences of clouds (B, T, P, 4) and proprioception (B, T, 9)."""
        return self.decode(self.encode(clouds, proprio))[0]

    def loss(self, clouds: Tensor, proprio: Tensor, actions: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Mean negative log-density of the actions, and the RMS error of the most likely ones."""
        mixture = self(clouds, proprio)
        total = weights.sum()
        loss = -(mixture.log_prob(actions) * weights).sum() / total
        squared = (mixture.most_likely().detach() - actions).square().mean(-1)
        return loss, ((squared * weights).sum() / total).sqrt()

    def make_rollout_policy(self, num_envs: int, mode: ActionMode) -> "Rollout":
        """One that runs the LSTM over the last `horizon` observations."""
        return Rollout(self, num_envs, mode)


class Rollout:
    """The policy in closed loop: one forward pass per control step for all environments.

    The LSTM is run over the last `horizon` encoded observations, as in training, where a sequence starts anywhere in an
    episode with an empty memory.

    Args:
        mode: 'sample' a mode of the mixture by its weight (robomimic), or by the square of its weight ('sharpened'), or
            take the 'most_likely'.
    """

    def __init__(self, policy: Policy, num_envs: int, mode: ActionMode) -> None:
        self.policy, self.mode = policy, mode
        self.past: list[list[Tensor]] = [[] for _ in range(num_envs)]
        self.random = [np.random.default_rng(0) for _ in range(num_envs)]

    def start_episode(self, env_id: int, seed: int) -> None:
        """As of `RolloutPolicy`."""
        self.past[env_id] = []
        self.random[env_id] = np.random.default_rng((seed, 7))

    @torch.inference_mode()
    def get_action(self, env_ids: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """As of `RolloutPolicy`."""
        kept = [self.policy.thin_cloud(cloud, self.random[i]) for i, cloud in zip(env_ids, clouds, strict=True)]
        encoded = self.policy.encode_observations(kept, list(proprio))
        for i, row in zip(env_ids, encoded, strict=True):
            self.past[i] = [*self.past[i], row][-self.policy.config.horizon :]
        lengths = [len(self.past[i]) for i in env_ids]
        batch = nn.utils.rnn.pad_sequence([torch.stack(self.past[i]) for i in env_ids], batch_first=True)
        mixture = self.policy.decode(batch)[0].select_steps([length - 1 for length in lengths])
        if self.mode == "most_likely":
            actions = mixture.most_likely()
        else:
            draws = [self.random[i].random() for i in env_ids]
            uniform = torch.tensor(draws, device=mixture.logits.device, dtype=torch.float32)
            actions = mixture.sample(uniform, POWERS[self.mode])
        return actions.clamp(-1, 1).cpu().numpy().astype(np.float32)
