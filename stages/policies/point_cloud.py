"""The base of our policies: clouds are encoded by the paper's PointNet (B.3)."""

import numpy as np
import torch
from torch import Tensor

from roomkin.stages.contracts.episode_store import PROPRIO
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import Float, TrainablePolicy
from roomkin.stages.policies.handle_points import find_handle_middles, offsets_to_handle
from roomkin.stages.policies.point_cloud_options import FLAG_EMBEDDING, PointCloudOptions
from roomkin.stages.policies.pointnet import PointNet


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
