"""A policy in closed loop on several environments: one forward pass per control step for all of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor

from stages.policies import Choice, Float
from stages.policies.bc_rnn_gmm.mixture import POWERS

if TYPE_CHECKING:
    from stages.policies.bc_rnn_gmm.network import BcRnnGmm


class Actor:
    """Acts for `slots` environments, each with its own memory and its own random numbers.

    The LSTM is run over the last `horizon` encoded observations, as in training, where a sequence
    starts anywhere in an episode with an empty memory.

    Args:
        choose: 'sample' a mode of the mixture by its weight (robomimic), or by the square of its weight ('sharpened'),
            or take the 'most_likely'.
    """

    def __init__(self, policy: "BcRnnGmm", horizon: int, slots: int, choose: Choice) -> None:
        self.policy, self.horizon, self.choose = policy, horizon, choose
        self.past: list[list[Tensor]] = [[] for _ in range(slots)]
        self.random = [np.random.default_rng(0) for _ in range(slots)]

    def reset(self, slot: int, seed: int) -> None:
        """Start an episode: forget the last one; `seed` decides every random choice of this one."""
        self.past[slot] = []
        self.random[slot] = np.random.default_rng((seed, 7))

    @torch.inference_mode()
    def act(self, slots: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """Actions (n, 7) in [-1, 1] of the environments in `slots`, from clouds (P, 4) and proprioception (9,)."""
        kept = [self.policy.thin_cloud(cloud, self.random[slot]) for slot, cloud in zip(slots, clouds, strict=True)]
        encoded = self.policy.encode_observations(kept, list(proprio))
        for slot, row in zip(slots, encoded, strict=True):
            self.past[slot] = [*self.past[slot], row][-self.horizon :]
        lengths = [len(self.past[slot]) for slot in slots]
        batch = torch.nn.utils.rnn.pad_sequence([torch.stack(self.past[slot]) for slot in slots], batch_first=True)
        mixture = self.policy.decode(batch)[0].select_steps([length - 1 for length in lengths])
        if self.choose == "most_likely":
            actions = mixture.most_likely()
        else:
            draws = [self.random[slot].random() for slot in slots]
            uniform = torch.tensor(draws, device=mixture.logits.device, dtype=torch.float32)
            actions = mixture.sample(uniform, POWERS[self.choose])
        return actions.clamp(-1, 1).cpu().numpy().astype(np.float32)
