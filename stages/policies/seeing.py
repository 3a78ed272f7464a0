"""The base of our policies: one that sees clouds by the paper's PointNet (B.3)."""

import numpy as np
import torch
from torch import Tensor

from stages.contracts.episode_store import PROPRIO
from stages.contracts.training_run import TrainingRun
from stages.policies import Float, TrainablePolicy
from stages.policies.pointnet import PointNet
from stages.policies.proud import middles, to_handle


class SeeingPolicy(TrainablePolicy):
    """Encodes what is seen and felt, with its normaliser. A subclass makes actions of it.

    Clouds and proprioception come in the robot base frame, metres.

    Attributes:
        features: length of an observation from `encode` and `with_handle`.
    """

    proprio_mean: Tensor
    proprio_std: Tensor
    cloud_mean: Tensor
    cloud_std: Tensor

    def __init__(self, run: TrainingRun) -> None:
        super().__init__(run)
        self.network = network = run.network
        self.flags = 3 if run.handle else 2
        width, bf16 = network.pointnet_width, run.precision == "bf16"
        self.pointnet = PointNet(width, network.pointnet_layers, network.flag_embedding, bf16, self.flags)
        self.features = width * network.cloud + PROPRIO + 4 * run.handle
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

        With `handle` the hand and the middle of the handle (`policies.proud.middles`) stand last.
        """
        own = (proprio - self.proprio_mean) / self.proprio_std
        if not self.network.cloud:
            return own
        features = self.pointnet(self.normalised(clouds, proprio).flatten(0, -3)).unflatten(0, clouds.shape[:-2])
        seen = [proprio[..., :3], middles(clouds)] if self.run.handle else []
        return torch.cat([features, own, *seen], dim=-1)

    def with_handle(self, encoded: Tensor) -> Tensor:
        """Encoded sequences (B, T, F): hand and middle replaced by the way from one to the other, if they are there."""
        if not self.run.handle:
            return encoded
        encoded, hand, seen = encoded.split([encoded.shape[-1] - 7, 3, 4], dim=-1)
        return torch.cat([encoded, to_handle(seen, hand)], dim=-1)

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
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

    def thinned(self, cloud: Float, random: np.random.Generator) -> Float:
        """A cloud (P, 4) of as many points as in training, drawn anew at every step (as official)."""
        if len(cloud) <= self.network.points:
            return cloud
        order = random.permutation(len(cloud))
        if self.run.handle:
            order = order[np.argsort(cloud[order, 3] != -1, kind="stable")]
        return cloud[order[: self.network.points]]

    def observed(self, clouds: list[Float], proprio: list[Float]) -> Tensor:
        """Encoded observations (n, F) of n clouds (P, 4) and proprioceptions (9,)."""
        device = self.proprio_mean.device
        return self.encode(*(torch.from_numpy(np.stack(rows)).to(device) for rows in (clouds, proprio)))
