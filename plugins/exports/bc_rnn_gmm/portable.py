"""The policy as plain layers for `loader.py`: flag embedding and normaliser are folded into the first one."""

from typing import Any

import torch
from torch import Tensor, nn

from roomkin.stages.contracts.episode_store import ACTION
from roomkin.stages.policies.base import ActionMode
from roomkin.stages.policies.bc_rnn_gmm import POWERS, Policy


def portable(policy: Policy, mode: ActionMode) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Weights by name, and the sizes and conventions that the loader reads.

    The loader draws a mode by its weight and takes its mean: standard deviations are left out, and the power to which
    weights are raised is folded into the last layer, as a factor of their logits.
    """
    options, points = policy.options, policy.pointnet
    head = [stage[0] for stage in policy.mlp.children() if isinstance(stage, nn.Sequential)] + [policy.head]
    weights = {f"lstm.{name}": tensor for name, tensor in policy.lstm.state_dict().items()}
    weights |= {name: getattr(policy, name) for name in ("proprio_mean", "proprio_std")}
    with torch.no_grad():
        weight, bias = points.fold_first_layer()  # on x, y, z as the policy normalises them, and the flags
        scale = torch.cat([1 / policy.cloud_std.expand(3), torch.ones(policy.flags - 1)])
        shift = torch.cat([policy.cloud_mean, torch.zeros(policy.flags - 1)])
        weights |= {"point.0.weight": weight * scale, "point.0.bias": bias - weight @ (shift * scale)}
    for name, layers, first in (("point", points.rest, 1), ("head", head, 0)):
        for i, layer in enumerate(layers, first):
            assert isinstance(layer, nn.Linear)
            weights |= {f"{name}.{i}.weight": layer.weight, f"{name}.{i}.bias": layer.bias}
    kept = options.gmm_modes * (1 + ACTION)
    for kind in ("weight", "bias"):
        last = weights[f"head.{len(head) - 1}.{kind}"][:kept].detach().clone()
        last[: options.gmm_modes] *= POWERS[mode]
        weights[f"head.{len(head) - 1}.{kind}"] = last
    return {name: tensor.detach().clone() for name, tensor in weights.items()}, {
        "points": policy.config.points, "flags": policy.flags, "keep_flagged": policy.config.handle,
        "middle": policy.config.handle, "gripper_frame": float(options.cloud_frame == "gripper"),
        "point_layers": options.pointnet_layers, "features": policy.lstm.input_size, "memory": options.rnn_hidden,
        "horizon": policy.config.horizon, "head_layers": len(head), "modes": options.gmm_modes,
    }  # fmt: skip
