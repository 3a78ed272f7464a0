"""The weights of pretrained networks, from a local folder; `python -m plugins.inputs fetch` fills those of `photo`."""

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
