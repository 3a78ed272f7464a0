"""Load pretrained networks from local folders."""

from typing import Any

from roomkin.stages.config.weights import check_folder
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.errors import explain


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
        reason = str(error).splitlines()[0] if str(error) else explain(error)
        raise InputError(key, f"'{folder}' does not load: {reason}", fix, code="E-WEIGHTS-BROKEN") from None
    if loaded["missing_keys"]:  # transformers would fill them with random numbers
        what = f"'{folder}' lacks {len(loaded['missing_keys'])} weights, e.g. {min(loaded['missing_keys'])}."
        raise InputError(key, what, fix, code="E-WEIGHTS-BROKEN")
    return model.eval()
