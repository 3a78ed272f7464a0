"""Gaussian mixture over actions, the output of BC-RNN-GMM (paper B.3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from roomkin.stages.policies.base import ActionMode

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
