"""Clouds of simple things for tests of policies."""

import numpy as np
import torch
from torch import Tensor


def cabinet(angle: float = 0.0, distance: float = 0.7, out: float = 0.04, knob: bool = False) -> Tensor:
    """A cloud (1, P, 4): a front of 40 x 50 cm, turned about z, with a bar or knob before it, and two fingers."""
    y, z = torch.meshgrid(torch.linspace(-0.2, 0.2, 17), torch.linspace(0.2, 0.7, 20), indexing="ij")
    front = torch.stack([torch.zeros_like(y), y, z], dim=-1).reshape(-1, 3)
    length = 0.02 if knob else 0.12
    bar = torch.stack([torch.full((12,), -out), torch.linspace(0.13, 0.15, 12), torch.linspace(0, length, 12) + 0.4], 1)
    points = torch.cat([front, bar])
    turn = torch.tensor([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]).float()
    points = points @ turn.T + torch.tensor([distance, 0, 0])
    fingers = torch.tensor([[0.3, -0.02, 0.4], [0.3, 0.02, 0.4]])
    flags = torch.cat([torch.zeros(len(points)), torch.ones(2)])
    return torch.cat([torch.cat([points, fingers]), flags[:, None]], dim=1)[None]
