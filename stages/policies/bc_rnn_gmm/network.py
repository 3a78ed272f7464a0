"""BC-RNN-GMM: PointNet and proprioception -> LSTM -> MLP -> mixture of Gaussians (paper B.3)."""

from itertools import pairwise

from torch import Tensor, nn
from torch.nn import functional

from stages.contracts.episode_store import ACTION
from stages.contracts.training_run import TrainingRun
from stages.policies import Choice
from stages.policies.bc_rnn_gmm.actor import Actor
from stages.policies.bc_rnn_gmm.mixture import Mixture
from stages.policies.seeing import SeeingPolicy

State = tuple[Tensor, Tensor]


class BcRnnGmm(SeeingPolicy):
    """The paper's policy."""

    def __init__(self, run: TrainingRun) -> None:
        super().__init__(run)
        network = run.network
        self.lstm = nn.LSTM(self.features, network.rnn_hidden, batch_first=True)
        sizes = [network.rnn_hidden, *network.mlp]
        self.mlp = nn.Sequential(*(nn.Sequential(nn.Linear(a, b), nn.ReLU()) for a, b in pairwise(sizes)))
        self.head = nn.Linear(sizes[-1], network.gmm_modes * (1 + 2 * ACTION))

    def decode(self, encoded: Tensor, state: State | None = None) -> tuple[Mixture, State]:
        """Mixtures (B, T, ...) of encoded observations (B, T, F), and the LSTM's state behind the last one."""
        memory, state = self.lstm(self.with_handle(encoded), state)
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
