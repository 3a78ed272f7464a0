"""A policy folder for tests that load policies."""

from pathlib import Path

import torch

from roomkin.stages.contracts import write_json
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from roomkin.stages.contracts.trained import TrainedPolicy, TrainingStore
from roomkin.stages.policies.base import save_weights
from roomkin.stages.policies.bc_rnn_gmm import Policy


def trained(folder: Path, config: PolicyConfig) -> Path:
    """A policy folder with random weights and a normaliser that does something."""
    torch.manual_seed(0)
    policy = Policy(config)
    random = torch.Generator().manual_seed(1)
    policy.proprio_mean.normal_(generator=random)
    policy.proprio_std.uniform_(0.5, 2, generator=random)
    policy.cloud_mean.normal_(generator=random)
    policy.cloud_std.fill_(0.3)
    with torch.no_grad():
        policy.head.bias[0] += 0.8  # a mode that is heavier than the others
    for name in ("policy", "last"):
        save_weights(folder / f"{name}.safetensors", policy.state_dict())
    parameters = sum(parameter.numel() for parameter in policy.parameters())
    policy_folder = TrainedPolicy(
        task="door", task_options=TaskConfig(), config=config, seed=0, data_digest="0", parameters=parameters,
        best_step=1, stores=[TrainingStore(file="episodes.h5", asset="cab", episodes=2, frames=9)], training_episodes=2,
        validation_episodes=0, best_loss=None,
    )  # fmt: skip
    write_json(folder / "config.json", policy_folder)
    return folder
