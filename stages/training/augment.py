"""Random translation and jitter (paper B.3) and reflection of training sequences; downsampling is in `dataset.py`.

Reflection, y -> -y in the robot base frame, with M = diag(1, -1, 1): a point p becomes M p, a hand with rotation R
becomes M R M, for the hand is its own mirror image with the fingers swapped; the quaternion (w, x, y, z) becomes
(-w, x, -y, z), which is the sign nearer to the rest pose (0, .91, 0, .42), as in the observations; a rotation vector is
a pseudo-vector: r becomes -M r.

Random numbers are drawn on the host and carried to where the sequences are: the same ones on every device.
"""

from dataclasses import replace

import torch
from torch import Tensor

from stages.contracts.training_run import TrainingRun
from stages.training.dataset import Batch

CLOUD_SIGNS = (1.0, -1.0, 1.0, 1.0)
PROPRIO_SIGNS = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0)  # of the order in SWAPPED
SWAPPED = (0, 1, 2, 3, 4, 5, 6, 8, 7)  # the finger joints
ACTION_SIGNS = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0)


def mirrored(batch: Batch) -> Batch:
    """The sequences as a mirror in the plane y = 0 of the robot base shows them; what is mirrored twice is itself."""
    return replace(
        batch,
        clouds=batch.clouds * batch.clouds.new_tensor(CLOUD_SIGNS),
        proprio=batch.proprio[..., SWAPPED] * batch.proprio.new_tensor(PROPRIO_SIGNS),
        actions=batch.actions * batch.actions.new_tensor(ACTION_SIGNS),
    )


def mirror_some(batch: Batch, probability: float, random: torch.Generator) -> Batch:
    """Each sequence mirrored with some probability."""
    if not probability:
        return batch
    turned = (torch.rand(len(batch.clouds), generator=random) < probability).to(batch.clouds.device)
    other = mirrored(batch)

    def either(mirror: Tensor, plain: Tensor) -> Tensor:
        return torch.where(turned.view(-1, *[1] * (plain.dim() - 1)), mirror, plain)

    return replace(
        batch,
        clouds=either(other.clouds, batch.clouds),
        proprio=either(other.proprio, batch.proprio),
        actions=either(other.actions, batch.actions),
    )


def augment(clouds: Tensor, proprio: Tensor, run: TrainingRun, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Augmented copies of clouds (B, T, P, 4) and proprioception (B, T, 9), both metres in the robot frame.

    `translation_mode: sequence` shifts cloud and end-effector position of a sequence together: the actions are
    deltas, so the shifted sequence is a true one. `cloud_only` is what the official code does: a new shift per step,
    end-effector position untouched.
    """
    batch, steps, points = clouds.shape[:3]
    together = run.translation_mode == "sequence"
    drawn = 1 if together else steps
    shifted = torch.rand((batch, drawn, 1), generator=random) < run.translation_probability
    shift = ((2 * torch.rand((batch, drawn, 3), generator=random) - 1) * run.translation * shifted).to(clouds.device)
    xyz = clouds[..., :3] + shift[:, :, None]
    position = proprio[..., :3] + (shift if together else 0.0)

    shaken = (torch.rand(batch, generator=random) < run.jitter_probability).nonzero().squeeze(1)
    if run.jitter > 0 and len(shaken):
        noise = torch.randn((len(shaken), steps, points, 3), generator=random) * run.jitter
        xyz[shaken.to(clouds.device)] += noise.clamp(-run.jitter_clip, run.jitter_clip).to(clouds.device)
    return torch.cat([xyz, clouds[..., 3:]], dim=-1), torch.cat([position, proprio[..., 3:]], dim=-1)
