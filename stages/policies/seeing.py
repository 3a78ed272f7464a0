"""The base of our policies: clouds are encoded by the paper's PointNet (B.3)."""

import numpy as np
import torch
from torch import Tensor

from stages.contracts.episode_store import PROPRIO
from stages.contracts.training_run import TrainingRun
from stages.policies import Float, TrainablePolicy
from stages.policies.marking import load_marker
from stages.policies.pointnet import PointNet


class SeeingPolicy(TrainablePolicy):
    """Encodes clouds and proprioception, with their normaliser. A subclass makes actions of that.

    Clouds and proprioception come in the robot base frame, metres.

    Attributes:
        features: length of an observation from `encode` and `add_handle_offset`.
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

    def move_to_frame(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """Coordinates (..., P, 3) of clouds (..., P, 4) about the origin that `cloud_frame` names."""
        xyz = clouds[..., :3]
        return xyz - proprio[..., None, :3] if self.network.cloud_frame == "gripper" else xyz

    def normalise(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """What the PointNet reads: (..., P, 4), or 5 with the handle marked."""
        xyz = (self.move_to_frame(clouds, proprio) - self.cloud_mean) / self.cloud_std
        if self.flags == 2:
            return torch.cat([xyz, clouds[..., 3:]], dim=-1)
        return torch.cat([xyz, clouds[..., 3:] == 1, clouds[..., 3:] == -1], dim=-1)

    def encode(self, clouds: Tensor, proprio: Tensor) -> Tensor:
        """Observations (..., F): features of clouds (..., P, 4), if the network has them, and proprioception (..., 9).

        With `handle` the hand and the middle of the handle (`Marker.find_middles`) come last.
        """
        own = (proprio - self.proprio_mean) / self.proprio_std
        if not self.network.cloud:
            return own
        features = self.pointnet(self.normalise(clouds, proprio).flatten(0, -3)).unflatten(0, clouds.shape[:-2])
        seen = [proprio[..., :3], load_marker().find_middles(clouds)] if self.run.handle else []
        return torch.cat([features, own, *seen], dim=-1)

    def add_handle_offset(self, encoded: Tensor) -> Tensor:
        """Encoded sequences (B, T, F); with `handle`, its offset from the hand takes the place of hand and middle."""
        if not self.run.handle:
            return encoded
        encoded, hand, seen = encoded.split([encoded.shape[-1] - 7, 3, 4], dim=-1)
        return torch.cat([encoded, load_marker().offsets(seen, hand)], dim=-1)

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Mean and spread of proprioception, and of the clouds where `standardise` asks for it."""
        used = proprio[frames]
        self.proprio_mean.copy_(used.mean(0))
        self.proprio_std.copy_(used.std(0).clamp_min(1e-3))
        if self.network.standardise:
            some = frames[:: max(1, len(frames) // 1000)]  # a thousand clouds say enough
            xyz = self.move_to_frame(clouds[some].float(), proprio[some]).flatten(0, -2)
            self.cloud_mean.copy_(xyz.mean(0))
            self.cloud_std.copy_((xyz - xyz.mean(0)).square().mean().sqrt())
            shown = self.normalise(clouds[some].float(), proprio[some])
            self.pointnet.standardise(shown, self.network.standardise_floor)

    def thin_cloud(self, cloud: Float, random: np.random.Generator) -> Float:
        """A cloud (P, 4) of as many points as in training, drawn anew at every step (as official)."""
        if len(cloud) <= self.network.points:
            return cloud
        order = random.permutation(len(cloud))
        if self.run.handle:
            order = order[np.argsort(cloud[order, 3] != -1, kind="stable")]
        return cloud[order[: self.network.points]]

    def encode_observations(self, clouds: list[Float], proprio: list[Float]) -> Tensor:
        """Encoded observations (n, F) of n clouds (P, 4) and proprioceptions (9,)."""
        device = self.proprio_mean.device
        return self.encode(*(torch.from_numpy(np.stack(rows)).to(device) for rows in (clouds, proprio)))
