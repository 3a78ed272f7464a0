"""Verb `fetch`: the weights of the networks that find what a picture shows, downloaded once; offline from then on."""

import json
from pathlib import Path

from stages.config.photo import FetchOptions, WeightsConfig
from stages.contracts import InputError, read_options, write_text
from stages.matching.pretrained import check_folder, weights_sha256

RECORD = "fetched.json"  # beside the weights, when all of their files are there
WANTED = ["*.json", "*.txt", "model.safetensors"]
Record = dict[str, str]


def run(*, options: str = "", out: Path | None = None) -> None:
    """Download what is not there; what was interrupted goes on where it stopped.

    Args:
        options: JSON of the config section `photo`, as far as it names networks.
        out: JSON with source, commit and sha256 of all of them.
    """
    records = {}
    for name, network in read_options(FetchOptions, options).networks().items():
        key = f"photo.{name}"
        records[name] = fetched(network, key)
        print(f"{key}: {json.dumps(records[name])}", flush=True)
    if out is not None:
        write_text(out, json.dumps(records, indent=2) + "\n")


def fetched(network: WeightsConfig, key: str) -> Record:
    """What lies in a network's folder, after it was downloaded if need be.

    A folder with weights that we did not put there is the user's own and stays as it is.

    Raises:
        InputError: nothing to download from, the download failed, or the weights are not those of `sha256`.
    """
    folder = Path(network.path)
    asked = {"source": network.source, "revision": network.revision}
    record = folder / RECORD
    known = json.loads(record.read_text(encoding="utf-8")) if record.is_file() else {}
    own = (folder / "model.safetensors").is_file() and not known and not (folder / ".cache").exists()
    if own or (known and asked.items() <= known.items()):
        check_folder(network, key)
        return known or {"path": network.path, "sha256": weights_sha256(network)}
    if not network.source:
        raise InputError(f"{key}.source", "is empty, and its path holds no weights.", "a model id of the hub")
    record.unlink(missing_ok=True)
    commit = _download(network, key)
    check_folder(network, key)
    found = {**asked, "commit": commit, "path": network.path, "sha256": weights_sha256(network)}
    write_text(record, json.dumps(found, indent=2) + "\n")
    return found


def _download(network: WeightsConfig, key: str) -> str:
    """The commit that was downloaded into the network's folder."""
    from huggingface_hub import HfApi, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, HFValidationError

    try:
        commit = str(HfApi().model_info(network.source, revision=network.revision).sha)
        print(f"{key}: {network.source} at {commit} -> {network.path}", flush=True)
        snapshot_download(network.source, revision=commit, local_dir=network.path, allow_patterns=WANTED)
    except (HfHubHTTPError, HFValidationError, OSError, ValueError) as error:
        reason = (str(error).strip() or error.__class__.__name__).splitlines()[0]
        what = f"'{network.source}' at '{network.revision}' cannot be fetched ({reason})."
        fix = f"run it again, what came stays; or put the folder into {network.path} by hand"
        raise InputError(f"{key}.source", what, fix) from None
    return commit
