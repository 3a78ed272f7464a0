"""BC-RNN-GMM: PointNet and proprioception -> LSTM -> MLP -> mixture of Gaussians (paper B.3)."""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from stages.config.training import TrainingRun
from stages.policies import Choice, TrainablePolicy
from stages.policies.bc_rnn_gmm.actor import Actor
from stages.policies.bc_rnn_gmm.mixture import Mixture
from stages.policies.bc_rnn_gmm.pointnet import PointNet
from stages.policies.proud import middles, to_handle

ACTION = 7  # delta position 3, delta axis-angle 3, gripper
PROPRIO = 9  # end-effector position 3, quaternion 4, finger joints 2
HANDLE = 4  # from the hand to the middle of what is marked 3, whether anything is

State = tuple[Tensor, Tensor]


class BcRnnGmm(TrainablePolicy):
    """Policy network with its normaliser. Clouds and proprioception come in the robot base frame, metres."""

    proprio_mean: Tensor
    proprio_std: Tensor
    cloud_mean: Tensor
    cloud_std: Tensor

    def __init__(self, run: TrainingRun) -> None:
        super().__init__(run)
        self.network = network = run.network
        width, hidden, modes = network.pointnet_width, network.rnn_hidden, network.gmm_modes
        self.flags = 3 if run.handle.flag else 2
        bf16 = run.precision == "bf16"
        self.pointnet = PointNet(width, network.pointnet_layers, network.flag_embedding, bf16, self.flags)
        eyes = width * network.cloud + HANDLE * run.handle.middle
        self.lstm = nn.LSTM(eyes + PROPRIO, hidden, batch_first=True)
        sizes = [hidden, *network.mlp]
        self.mlp = nn.Sequential(*(nn.Sequential(nn.Linear(a, b), nn.ReLU()) for a, b in pairwise(sizes)))
        self.head = nn.Linear(sizes[-1], modes * (1 + 2 * ACTION))
        for name, value in (
            ("proprio_mean", torch.zeros(PROPRIO)),
            ("proprio_std", torch.ones(PROPRIO)),
            ("cloud_mean", torch.zeros(3)),
            ("cloud_std", torch.ones(())),
        ):
            self.register_buffer(name, value)

    def in_frame(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """Coordinates (..., P, 3) of clouds (..., P, 4) about the origin that `cloud_frame` names."""
        xyz = clouds[..., :3]
        return xyz - proprio[..., None, :3] if self.network.cloud_frame == "gripper" else xyz

    def normalised(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """What the PointNet reads: (..., P, 4), or 5 with what stands proud marked."""
        xyz = (self.in_frame(clouds, proprio) - self.cloud_mean) / self.cloud_std
        if self.flags == 2:
            return torch.cat([xyz, clouds[..., 3:]], dim=-1)
        return torch.cat([xyz, clouds[..., 3:] == 1, clouds[..., 3:] == -1], dim=-1)

    def encode(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """What is seen, (..., width) or nothing, and felt, of clouds (..., P, 4) and proprioception (..., 9): (..., F).

        With `handle.middle` the middle of the handle (`policies.proud.middles`) stands last.
        """
        own = (proprio - self.proprio_mean) / self.proprio_std
        if not self.network.cloud:
            return own
        features = self.pointnet(self.normalised(clouds, proprio).flatten(0, -3)).unflatten(0, clouds.shape[:-2])
        seen = [proprio[..., :3], middles(clouds)] if self.run.handle.middle else []
        return torch.cat([features, own, *seen], dim=-1)

    def decode(self, encoded: Tensor, state: State | None = None) -> tuple[Mixture, State]:
        """Mixtures (B, T, ...) of encoded observations (B, T, F), and the LSTM's state behind the last one."""
        if self.run.handle.middle:
            encoded, hand, seen = encoded.split([encoded.shape[-1] - 7, 3, 4], dim=-1)
            encoded = torch.cat([encoded, to_handle(seen, hand)], dim=-1)
        memory, state = self.lstm(encoded, state)
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

    def fit(self, clouds: Tensor, proprio: Tensor, frames: Tensor) -> None:
        """Mean and spread of proprioception, and of the clouds where `standardise` asks for it."""
        used = proprio[frames]
        self.proprio_mean.copy_(used.mean(0))
        self.proprio_std.copy_(used.std(0).clamp_min(1e-3))
        if self.network.standardise:
            some = frames[:: max(1, len(frames) // 1000)]  # a thousand clouds say enough
            xyz = self.in_frame(clouds[some].float(), proprio[some]).flatten(0, -2)
            self.cloud_mean.copy_(xyz.mean(0))
            self.cloud_std.copy_((xyz - xyz.mean(0)).square().mean().sqrt())
            shown = self.normalised(clouds[some].float(), proprio[some])
            self.pointnet.standardise(shown, self.network.standardise_floor)

    def actor(self, slots: int, choose: Choice) -> Actor:
        """One that runs the LSTM over the last `rnn_horizon` observations."""
        return Actor(self, self.run.rnn_horizon, slots, choose)
