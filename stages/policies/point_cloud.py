"""The base of our policies: clouds whose points carry a flag, encoded by the paper's PointNet (B.3), with two savings.

1. The flag has two values, so its embedding e(flag) folds into the first layer:
   W [xyz, e(f)] + b = W_x xyz + t_0 + f (t_1 - t_0) with t_k = W_e e(k) + b. 131 inputs become 4. A third value, for
   the handle, adds an input of its own, 1 where it holds.
2. Max-pooling passes gradient to the winning points only. A forward pass without gradient, in
   chunks that stay in the cache, finds the winners; a second pass differentiates them alone.

Both leave values and gradients as they are (a test compares with the plain dense network).
"""

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from roomkin.stages.contracts.episode_store import PROPRIO
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import Float, TrainablePolicy
from roomkin.stages.policies.bc_rnn_gmm_options import FLAG_EMBEDDING, PointCloudOptions
from roomkin.stages.policies.handle_points import find_handle_middles, offsets_to_handle

CHUNK_ELEMENTS = {"cpu": 2**18, "cuda": 2**27}  # activations per chunk: 1 MB of float32 fits a core's L2 cache


# torch's own linear layer goes to MKL, which takes twice the time of oneDNN on AMD processors (docs/benchmarks.md).
ONEDNN = torch.backends.mkldnn.is_available() and hasattr(torch.ops.mkldnn, "_linear_pointwise")


class PointNet(nn.Module):
    """Shared MLP over points, max-pool, ReLU: (N, P, 2 + flags) clouds -> (N, width) features.

    A point is x, y, z, 1 on a gripper finger (else 0) and, of three flags, 1 on the handle (else 0). Between the layers
    is GELU.
    """

    def __init__(self, width: int, layers: int, flag_embedding: int, bf16: bool = False, flags: int = 2) -> None:
        super().__init__()
        self.flag = nn.Embedding(flags, flag_embedding)
        self.first = nn.Linear(3 + flag_embedding, width)
        self.rest = nn.ModuleList(nn.Linear(width, width) for _ in range(layers - 1))
        self.bf16 = bf16
        # With one fan-in for all 131 inputs the 128 of the embedding drown the coordinates: all points look alike,
        # and hundreds of updates pass before the policy uses the cloud. Each group gets its own.
        nn.init.uniform_(self.first.weight[:, :3], -(3**-0.5), 3**-0.5)

    def forward(self, clouds: Tensor) -> Tensor:
        """Features (N, width) of clouds (N, P, 2 + flags)."""
        if not torch.is_grad_enabled():
            return functional.relu(self._winners(clouds)[0])
        with torch.no_grad():
            winner = self._winners(clouds)[1]  # (N, width): index of the point that wins each channel
        is_winner = torch.zeros(clouds.shape[:2], dtype=torch.bool, device=clouds.device).scatter_(1, winner, True)
        row = is_winner.flatten().cumsum(0).view_as(is_winner) - 1  # row of a point among all winners of the batch
        features = self._mlp(clouds[is_winner], *self.fold_first_layer())
        return functional.relu(features.gather(0, row.gather(1, winner)))

    @torch.no_grad()
    def standardise(self, clouds: Tensor, floor: float = 0.0) -> None:
        """Rescale the last layer so that the pooled features of `clouds` have mean 1 and deviation 1 before the ReLU.

        Initial features hardly differ between clouds; with unit variance, as proprioception has it, the policy uses
        them from the first updates on (data-dependent initialisation, Mishkin and Matas 2016). Call it before training.

        A channel that a point of the fingers wins in every cloud varies by millimetres. To make them count as one can
        blow the feature up in training until the LSTM behind is saturated for good (docs/policies.md), so features that
        vary by less than `floor` of the median are scaled as if they varied by that.
        """
        pooled = self._winners(clouds)[0]
        last = self.rest[-1]
        assert isinstance(last, nn.Linear)
        spread = pooled.std(0)
        scale = 1 / spread.clamp_min(max(1e-6, floor * float(spread.median())))
        last.weight.mul_(scale[:, None])
        last.bias.copy_((last.bias - pooled.mean(0)) * scale + 1)

    def fold_first_layer(self) -> tuple[Tensor, Tensor]:
        """First layer on (xyz, flags): weight (width, 2 + flags), bias (width,)."""
        table = functional.linear(self.flag.weight, self.first.weight[:, 3:], self.first.bias)
        return torch.cat([self.first.weight[:, :3], (table[1:] - table[0]).T], dim=1), table[0]

    def _mlp(self, points: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
        """Features (..., width) of points (..., 2 + flags). The first layer stays fp32: bf16 would cost millimetres."""
        x = functional.linear(points, weight, bias)
        with torch.autocast(points.device.type, torch.bfloat16, enabled=self.bf16):
            for layer in self.rest:
                x = layer(functional.gelu(x))
        return x.float()

    def _plain_winners(self, clouds: Tensor, weight: Tensor, bias: Tensor) -> tuple[Tensor, Tensor]:
        """Max of `_mlp` over points and its index, both (N, width)."""
        values, index = self._mlp(clouds, weight, bias).max(dim=1)
        return values, index

    def _onednn_winners(self, clouds: Tensor, weight: Tensor, bias: Tensor) -> tuple[Tensor, Tensor]:
        """`_plain_winners` by oneDNN, each GELU fused with the layer before it.

        The last layer's product is laid out by channel, so that numpy finds the winners in rows (four times as fast as
        torch, which looks at one number at a time); its bias is the same for all points of a channel.
        """
        fused, points = torch.ops.mkldnn._linear_pointwise, clouds
        for layer in self.rest:
            assert isinstance(layer, nn.Linear)
            points = fused(points, weight, bias, "gelu", [], "none")
            weight, bias = layer.weight, layer.bias
        by_channel: Tensor = fused(weight, points.flatten(0, 1), None, "none", [], "").unflatten(1, clouds.shape[:2])
        index = torch.from_numpy(by_channel.numpy().argmax(2))
        return by_channel.gather(2, index[..., None]).squeeze(2).T + bias, index.T

    @torch.no_grad()
    def _winners(self, clouds: Tensor) -> tuple[Tensor, Tensor]:
        """Max over points and its index, both (N, width), chunk by chunk; without gradient."""
        weight, bias = self.fold_first_layer()
        size = max(1, CHUNK_ELEMENTS[clouds.device.type] // (clouds.shape[1] * len(bias)))
        onednn = ONEDNN and clouds.device.type == "cpu" and not self.bf16
        find = self._onednn_winners if onednn else self._plain_winners
        values, indices = zip(*(find(chunk, weight, bias) for chunk in clouds.split(size)), strict=True)
        return torch.cat(values), torch.cat(indices)


class PointCloudPolicy(TrainablePolicy):
    """Encodes clouds and proprioception, with their normaliser. A subclass makes actions of that.

    Clouds and proprioception come in the robot base frame, metres.

    Attributes:
        options: those of the policy's kind.
        features: length of an observation from `encode` and `add_handle_offset`.
    """

    proprio_mean: Tensor
    proprio_std: Tensor
    cloud_mean: Tensor
    cloud_std: Tensor

    def __init__(self, config: PolicyConfig, options: PointCloudOptions) -> None:
        super().__init__(config)
        self.options = options
        self.flags = 3 if config.handle else 2
        width, bf16 = options.pointnet_width, options.precision == "bf16"
        self.pointnet = PointNet(width, options.pointnet_layers, FLAG_EMBEDDING, bf16, self.flags)
        self.features = width * options.cloud + PROPRIO + 4 * config.handle
        for name, value in (
            ("proprio_mean", torch.zeros(PROPRIO)),
            ("proprio_std", torch.ones(PROPRIO)),
            ("cloud_mean", torch.zeros(3)),
            ("cloud_std", torch.ones(())),
        ):
            self.register_buffer(name, value)

    def move_to_frame(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """Coordinates (..., P, 3) of clouds (..., P, 4) about the origin that `cloud_frame` names."""
        xyz = clouds[..., :3]
        return xyz - proprio[..., None, :3] if self.options.cloud_frame == "gripper" else xyz

    def normalise(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """What the PointNet reads: (..., P, 4), or 5 with the handle flagged."""
        xyz = (self.move_to_frame(clouds, proprio) - self.cloud_mean) / self.cloud_std
        if self.flags == 2:
            return torch.cat([xyz, clouds[..., 3:]], dim=-1)
        return torch.cat([xyz, clouds[..., 3:] == 1, clouds[..., 3:] == -1], dim=-1)

    def encode(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """Observations (..., F): features of clouds (..., P, 4), if the policy has eyes, and proprioception (..., 9).

        With `handle` the hand and the middle of the handle (`find_handle_middles`) come last.
        """
        own = (proprio - self.proprio_mean) / self.proprio_std
        if not self.options.cloud:
            return own
        features = self.pointnet(self.normalise(clouds, proprio).flatten(0, -3)).unflatten(0, clouds.shape[:-2])
        seen = [proprio[..., :3], find_handle_middles(clouds)] if self.config.handle else []
        return torch.cat([features, own, *seen], dim=-1)

    def add_handle_offset(self, encoded: Tensor) -> Tensor:
        """Encoded sequences (B, T, F); with `handle`, its offset from the hand takes the place of hand and middle."""
        if not self.config.handle:
            return encoded
        encoded, hand, seen = encoded.split([encoded.shape[-1] - 7, 3, 4], dim=-1)
        return torch.cat([encoded, offsets_to_handle(seen, hand)], dim=-1)

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Mean and spread of proprioception, and of the clouds where `standardise` asks for it."""
        used = proprio[frames]
        self.proprio_mean.copy_(used.mean(0))
        self.proprio_std.copy_(used.std(0).clamp_min(1e-3))
        if self.options.standardise:
            some = frames[:: max(1, len(frames) // 1000)]  # a thousand clouds say enough
            xyz = self.move_to_frame(clouds[some].float(), proprio[some]).flatten(0, -2)
            self.cloud_mean.copy_(xyz.mean(0))
            self.cloud_std.copy_((xyz - xyz.mean(0)).square().mean().sqrt())
            shown = self.normalise(clouds[some].float(), proprio[some])
            self.pointnet.standardise(shown, self.options.min_std)

    def thin_cloud(self, cloud: Float, random: np.random.Generator) -> Float:
        """A cloud (P, 4) of as many points as in training, drawn anew at every step (as official)."""
        if len(cloud) <= self.config.points:
            return cloud
        order = random.permutation(len(cloud))
        if self.config.handle:
            order = order[np.argsort(cloud[order, 3] != -1, kind="stable")]
        return cloud[order[: self.config.points]]

    def encode_observations(self, clouds: list[Float], proprio: list[Float]) -> Tensor:
        """Encoded observations (n, F) of n clouds (P, 4) and proprioceptions (9,)."""
        device = self.proprio_mean.device
        return self.encode(*(torch.from_numpy(np.stack(rows)).to(device) for rows in (clouds, proprio)))
