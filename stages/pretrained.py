"""Finding and checking the weights of pretrained networks; nothing is fetched unless the user allows it."""

import hashlib
from pathlib import Path
from typing import Any

from stages.config.matching import PretrainedConfig
from stages.contracts import InputError


def load_pretrained(model_class: Any, options: PretrainedConfig, key: str) -> Any:
    """`model_class.from_pretrained` on a local folder, or on a model id if `options.download` is on.

    Raises:
        InputError: no weights there, or others than `options.sha256`; `key`: config section, e.g. matching.dinov2.
    """
    from safetensors import SafetensorError

    arguments: dict[str, Any] = {"use_safetensors": True, "output_loading_info": True}
    if not options.download:
        arguments["local_files_only"] = True
        check_folder(options, key)
    elif not Path(options.path).is_dir():
        arguments["revision"] = options.revision
    try:
        model, loaded = model_class.from_pretrained(options.path, **arguments)
    except (OSError, ValueError, KeyError, RuntimeError, SafetensorError) as error:
        reason = str(error).splitlines()[0] if str(error) else error.__class__.__name__
        what = f"'{options.path}' does not load: {reason}"
        raise InputError(
            f"{key}.path", what, f"it should hold a {model_class.__name__}", code="E-WEIGHTS-BROKEN"
        ) from None
    if loaded["missing_keys"]:  # transformers would fill them with random numbers
        what = f"'{options.path}' lacks {len(loaded['missing_keys'])} weights, e.g. {min(loaded['missing_keys'])}."
        raise InputError(f"{key}.path", what, f"it should hold a {model_class.__name__}", code="E-WEIGHTS-BROKEN")
    return model.eval()


def check_folder(options: PretrainedConfig, key: str) -> None:
    """Check that the folder is there with its files, and the weights' sha256 if one is given."""
    folder = Path(options.path)
    fix = f"put config.json and model.safetensors into a folder and name it in {key}.path"
    if not options.path:
        what = "is empty, and nothing works here without pretrained weights."
        raise InputError(f"{key}.path", what, fix, code="E-WEIGHTS-MISSING")
    for name in ("config.json", "model.safetensors"):
        if not (folder / name).is_file():
            fix = f"{fix}; for a model id set download: true"
            raise InputError(folder / name, "no such file.", fix, code="E-WEIGHTS-MISSING")
    if options.sha256 and (found := weights_sha256(options)) != options.sha256:
        fix = f"{key}.sha256 asks for {options.sha256}"
        raise InputError(folder / "model.safetensors", f"has sha256 {found}.", fix, code="E-WEIGHTS-CHECKSUM")


def weights_sha256(options: PretrainedConfig) -> str:
    """sha256 of the weights in a local folder; for a model id the id and revision name them."""
    file = Path(options.path) / "model.safetensors"
    if not file.is_file():
        return f"{options.path}@{options.revision}"
    digest = hashlib.sha256()
    with file.open("rb") as stream:
        while chunk := stream.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()
