"""Random translation and jitter of training sequences (paper B.3); downsampling is in `batches.py`.

Random numbers are drawn on the host and carried to where the sequences are: the same ones on every device.
"""

import torch
from torch import Tensor

from roomkin.stages.contracts.policy_config import PolicyConfig

TRANSLATION_PROBABILITY = 0.4  # per sequence (official: 0.4)
JITTER_PROBABILITY, JITTER_CLIP = 0.1, 0.015  # per sequence (official: 0.1, switched off); largest, metres (official)


def augment(clouds: Tensor, proprio: Tensor, config: PolicyConfig, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Augmented copies of clouds (B, T, P, 4) and proprioception (B, T, 9), both metres in the robot frame.

    `translation_mode: sequence` shifts cloud and end-effector position of a sequence together: the actions are
    deltas, so the shifted sequence is a true one. `cloud_only` is what the official code does: a new shift per step,
    end-effector position untouched.
    """
    batch, steps, points = clouds.shape[:3]
    together = config.translation_mode == "sequence"
    drawn = 1 if together else steps
    shifted = torch.rand((batch, drawn, 1), generator=random) < TRANSLATION_PROBABILITY
    shift = ((2 * torch.rand((batch, drawn, 3), generator=random) - 1) * config.translation * shifted).to(clouds.device)
    xyz = clouds[..., :3] + shift[:, :, None]
    position = proprio[..., :3] + (shift if together else 0.0)

    shaken = (torch.rand(batch, generator=random) < JITTER_PROBABILITY).nonzero().squeeze(1)
    if config.jitter > 0 and len(shaken):
        noise = torch.randn((len(shaken), steps, points, 3), generator=random) * config.jitter
        xyz[shaken.to(clouds.device)] += noise.clamp(-JITTER_CLIP, JITTER_CLIP).to(clouds.device)
    return torch.cat([xyz, clouds[..., 3:]], dim=-1), torch.cat([position, proprio[..., 3:]], dim=-1)
