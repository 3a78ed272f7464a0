"""Policies on disk: safetensors weights (with the normaliser) and `config.json`."""

from pathlib import Path

from safetensors.torch import load_file, save
from torch import Tensor

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.trained import check_weights, read_config, weights_of
from roomkin.stages.policies.base import TrainablePolicy, make_policy

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
