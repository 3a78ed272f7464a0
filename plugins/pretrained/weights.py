"""The weights of networks: pretrained ones, which `python -m plugins.inputs fetch` fetches for `photo`, and our own."""

import hashlib
from pathlib import Path
from typing import Any

from stages.contracts import InputError


def load_pretrained(model_class: Any, folder: str, key: str) -> Any:
    """`model_class.from_pretrained` on a local folder.

    Raises:
        InputError: no weights there, or others; `key`: of the config, e.g. matching.dinov2.path.
    """
    from safetensors import SafetensorError

    check_folder(folder, key)
    fix = f"it should hold a {model_class.__name__}"
    try:
        model, loaded = model_class.from_pretrained(
            folder, use_safetensors=True, output_loading_info=True, local_files_only=True
        )
    except (OSError, ValueError, KeyError, RuntimeError, SafetensorError) as error:
        reason = str(error).splitlines()[0] if str(error) else error.__class__.__name__
        raise InputError(key, f"'{folder}' does not load: {reason}", fix, code="E-WEIGHTS-BROKEN") from None
    if loaded["missing_keys"]:  # transformers would fill them with random numbers
        what = f"'{folder}' lacks {len(loaded['missing_keys'])} weights, e.g. {min(loaded['missing_keys'])}."
        raise InputError(key, what, fix, code="E-WEIGHTS-BROKEN")
    return model.eval()


def check_folder(folder: str, key: str) -> None:
    """Check that the folder is there with its files.

    Raises:
        InputError: it is not; `key`: of the config.
    """
    fix = f"put config.json and model.safetensors into a folder and name it in {key}"
    if not folder:
        what = "is empty, and nothing works here without pretrained weights."
        raise InputError(key, what, fix, code="E-WEIGHTS-MISSING")
    for name in ("config.json", "model.safetensors"):
        if not Path(folder, name).is_file():
            raise InputError(Path(folder, name), "no such file.", fix, code="E-WEIGHTS-MISSING")


def weights_sha256(folder: str) -> str:
    """sha256 of the weights in a folder."""
    with Path(folder, "model.safetensors").open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def load_weights(network: Any, path: Path, fix: str) -> Any:
    """A network of ours with the weights of a safetensors file, ready to be used.

    Raises:
        InputError: the file is not there or holds other weights.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    try:
        weights = {name: value.float() for name, value in load_file(path).items()}
    except (OSError, SafetensorError) as error:
        raise InputError(path, f"cannot be read: {error}.", fix, code="E-WEIGHTS-UNREADABLE") from None
    try:
        missing, unexpected = network.load_state_dict(weights, strict=False)
    except RuntimeError:
        raise InputError(path, "holds weights of other sizes.", fix, code="E-WEIGHTS-OTHER") from None
    lacking = [name for name in missing if not name.endswith("num_batches_tracked")]
    if lacking or unexpected:
        raise InputError(path, f"holds other weights, e.g. {[*lacking, *unexpected][0]}.", fix, code="E-WEIGHTS-OTHER")
    return network.eval()
