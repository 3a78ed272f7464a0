"""What a policy is to training and to evaluation, and policies on disk."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import load_file, save
from torch import Tensor, nn

from roomkin.stages.contracts.episode_store import ACTION
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.trained import check_weights, read_config, weights_of
from roomkin.stages.plugins import load
from roomkin.stages.policies.handle_points import segment_handles

Float = NDArray[np.float32]
FARTHEST = 10.0  # of an action: what is drawn at random from a policy's distribution is nearer to [-1, 1]; chosen
ActionMode = Literal["sample", "sharpened", "most_likely"]


class RolloutPolicy(Protocol):
    """A policy in closed loop on several environments, each with its own memory."""

    def start_episode(self, env_id: int, seed: int) -> None:
        """Forget the last episode of an environment; `seed` decides every random choice of the next."""
        ...

    def get_action(self, env_ids: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """Actions (n, 7) in [-1, 1] of these environments, from clouds (P, 4) and proprioception (9,)."""
        ...


class TrainablePolicy(nn.Module, ABC):
    """What an implementation's `Policy` is: made from a policy config, with its normaliser as buffers.

    Clouds (..., P, 4) are x, y, z and a flag: 1 finger, 0 scene and, with `config.handle`, -1 the handle, segmented
    before a policy sees the clouds, in training and in closed loop. Proprioception (..., 9) is end-effector position,
    quaternion wxyz and fingers, actions (..., 7) are in [-1, 1]; metres, robot base frame.
    """

    def __init__(self, config: PolicyConfig) -> None:
        super().__init__()
        self.config = config

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Fit normaliser and start before training; `frames` are the rows of the three that are to be trained on.

        What is kept goes into buffers that `__init__` registered at their size. A policy without parameters is fitted
        alone: `steps: 1`.
        """

    @abstractmethod
    def loss(self, clouds: Tensor, proprio: Tensor, actions: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Loss of sequences (B, T, ...), and the RMS error of the actions; steps with weight 0 do not count.

        `self.training` is false when validation episodes are looked at.
        """

    @abstractmethod
    def make_rollout_policy(self, num_envs: int, mode: ActionMode) -> RolloutPolicy:
        """The policy in closed loop, with as many memories as there are environments."""


def make_policy(config: PolicyConfig) -> TrainablePolicy:
    """The policy that a config names, not yet trained."""
    policy: TrainablePolicy = load("policies", config.policy)(config)
    return policy


class CheckedPolicy:
    """A policy in closed loop whose actions are looked at before a simulator gets them.

    handle: its clouds have the handle flagged before it sees them.
    """

    def __init__(self, policy: RolloutPolicy, name: str, handle: bool = False) -> None:
        self.policy, self.name, self.handle = policy, name, handle

    def start_episode(self, env_id: int, seed: int) -> None:
        """As of `RolloutPolicy`."""
        self.policy.start_episode(env_id, seed)

    def get_action(self, env_ids: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """As of `RolloutPolicy`.

        Raises:
            InputError: actions of another shape, that are no numbers, or far out of [-1, 1].
        """
        if self.handle:
            clouds = list(segment_handles(torch.from_numpy(np.stack(clouds)))[0].numpy())
        actions = np.asarray(self.policy.get_action(env_ids, clouds, proprio))
        if actions.shape != (len(env_ids), ACTION):
            what = f"gives actions of shape {actions.shape} for {len(env_ids)} environments."
        elif actions.dtype.kind not in "fiu" or not np.isfinite(actions).all():
            what = f"gives actions that are no finite numbers: {str(actions[0])[:100]}."
        elif np.abs(actions).max(initial=0) > FARTHEST:
            what = f"gives the action {actions.flat[np.abs(actions).argmax()]:g}, and actions are in [-1, 1]."
        else:
            return actions
        mend = f"get_action returns ({len(env_ids)}, {ACTION}) numbers in [-1, 1]"
        raise InputError(f"policy '{self.name}'", what, mend, code="E-POLICY-ACTIONS")


def make_rollout_policy(policy: TrainablePolicy, num_envs: int, mode: ActionMode) -> RolloutPolicy:
    """The policy acting on so many environments; its clouds are what they were in training."""
    acting = policy.make_rollout_policy(num_envs, mode)
    return CheckedPolicy(acting, policy.config.policy, policy.config.handle)


FILES = {"best": "policy.safetensors", "last": "last.safetensors"}


def save_weights(path: Path, weights: dict[str, Tensor]) -> None:
    """Write a state dict atomically; the same tensors give the same bytes."""
    with write_atomically(path) as temporary:
        temporary.write_bytes(save({name: tensor.detach().cpu().contiguous() for name, tensor in weights.items()}))


def load_network(folder: Path, checkpoint: str, device: str = "cpu") -> TrainablePolicy:
    """The policy of a training folder, ready for inference.

    Args:
        folder: output of `training train`.
        checkpoint: 'best', 'last', or the name of one of `checkpoints` in config.json.

    Raises:
        InputError: a file is missing, or the weights do not fit the sizes in config.json.
    """
    trained = read_config(folder)
    policy = make_policy(trained.config)
    path = weights_of(folder, FILES.get(checkpoint, checkpoint))
    check_weights(path, trained)
    try:
        policy.load_state_dict(load_file(path))
    except RuntimeError as error:
        reason = str(error).splitlines()[-1].strip()
        what = f"does not hold the weights that config.json describes ({reason})."
        raise InputError(path, what, code="E-POLICY-WEIGHTS") from None
    return policy.to(device).eval()
