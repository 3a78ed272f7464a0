"""Random translation and jitter of training sequences (paper B.3). The downsampling is in `dataset.py`."""

import torch
from torch import Tensor

from stages.config.training import TrainingRun


def augment(clouds: Tensor, proprio: Tensor, run: TrainingRun, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Augmented copies of clouds (B, T, P, 4) and proprioception (B, T, 9), both metres in the robot frame.

    `translation_mode: sequence` shifts cloud and end-effector position of a sequence together: the actions are
    deltas, so the shifted sequence is a true one. `cloud_only` is what the official code does: a new shift per step,
    end-effector position untouched.
    """
    batch, steps, points = clouds.shape[:3]
    together = run.translation_mode == "sequence"

    def uniform(*shape: int) -> Tensor:
        return torch.rand(shape, generator=random, device=clouds.device)

    drawn = 1 if together else steps
    shifted = uniform(batch, drawn, 1) < run.translation_probability
    shift = (2 * uniform(batch, drawn, 3) - 1) * run.translation * shifted
    xyz = clouds[..., :3] + shift[:, :, None]
    position = proprio[..., :3] + (shift if together else 0.0)

    shaken = (uniform(batch) < run.jitter_probability).nonzero().squeeze(1)
    if run.jitter > 0 and len(shaken):
        noise = torch.randn((len(shaken), steps, points, 3), generator=random, device=clouds.device) * run.jitter
        xyz[shaken] += noise.clamp(-run.jitter_clip, run.jitter_clip)
    return torch.cat([xyz, clouds[..., 3:]], dim=-1), torch.cat([position, proprio[..., 3:]], dim=-1)
