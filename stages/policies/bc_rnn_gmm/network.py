"""BC-RNN-GMM: PointNet and proprioception -> LSTM -> MLP -> mixture of Gaussians (paper B.3)."""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from stages.contracts.episode_store import ACTION
from stages.contracts.training_run import TrainingRun
from stages.policies import Choice
from stages.policies.bc_rnn_gmm.actor import Actor
from stages.policies.bc_rnn_gmm.mixture import Mixture
from stages.policies.seeing import SeeingPolicy

State = tuple[Tensor, Tensor]
START_MEAN, START_STD = 0.9, 0.01  # largest mean (before atanh), least deviation at which a mode starts; chosen


class BcRnnGmm(SeeingPolicy):
    """The paper's policy."""

    def __init__(self, run: TrainingRun) -> None:
        super().__init__(run)
        network = run.network
        self.lstm = nn.LSTM(self.features, network.rnn_hidden, batch_first=True)
        sizes = [network.rnn_hidden, *network.mlp]
        self.mlp = nn.Sequential(*(nn.Sequential(nn.Linear(a, b), nn.ReLU()) for a, b in pairwise(sizes)))
        self.head = nn.Linear(sizes[-1], network.gmm_modes * (1 + 2 * ACTION))

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Fit the normaliser; with `start_at_actions` every mode starts near the mean and deviation of the actions."""
        super().fit(clouds, proprio, actions, frames)
        if self.network.start_at_actions:
            self.start_at(actions[frames])

    @torch.no_grad()
    def start_at(self, actions: Tensor) -> None:
        """Let every mode be about the mean and deviation of `actions` (F, 7), whatever is seen.

        From a start at random all weights first move together to make the deviations smaller. In fifty updates that
        saturates a third of the LSTM and silences half of the MLP, and some trainings never recover.
        """
        modes = self.network.gmm_modes
        means = actions.mean(0).clamp(-START_MEAN, START_MEAN).atanh()
        stds = (actions.std(0) - self.network.gmm_min_std).clamp_min(START_STD)
        _, mean_bias, std_bias = self.head.bias.split([modes, modes * ACTION, modes * ACTION])
        mean_bias.add_(means.repeat(modes))
        std_bias.copy_(stds.expm1().log().repeat(modes))  # softplus of it is the deviation

    def decode(self, encoded: Tensor, state: State | None = None) -> tuple[Mixture, State]:
        """Mixtures (B, T, ...) of encoded observations (B, T, F), and the LSTM's state behind the last one."""
        memory, state = self.lstm(self.add_handle_offset(encoded), state)
        out = self.head(self.mlp(memory))
        modes = self.network.gmm_modes
        logits, means, stds = out.split([modes, modes * ACTION, modes * ACTION], dim=-1)
        return (
            Mixture(
                logits,
                means.unflatten(-1, (modes, ACTION)).tanh(),
                functional.softplus(stds.unflatten(-1, (modes, ACTION))) + self.network.gmm_min_std,
            ),
            state,
        )

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

    def actor(self, slots: int, choose: Choice) -> Actor:
        """One that runs the LSTM over the last `rnn_horizon` observations."""
        return Actor(self, self.run.rnn_horizon, slots, choose)
