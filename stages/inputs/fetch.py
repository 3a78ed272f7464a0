"""Verb `fetch`: the weights of the networks that find what a picture shows, downloaded once; offline from then on."""

import json
from pathlib import Path

from pydantic import Field, TypeAdapter, ValidationError

from stages.config.photo import FetchOptions, WeightsConfig
from stages.contracts import InputError, read_options, write_text
from stages.contracts.files import Contract, first_error
from stages.pretrained import check_folder, weights_sha256

LOCK = Path("weights.lock.json")
RECORD = "fetched.json"  # beside the weights, when all of their files are there
WANTED = ["*.json", "*.txt", "model.safetensors"]
Record = dict[str, str]


def run(*, options: str = "", out: Path | None = None, lock: Path = LOCK) -> None:
    """Download what is not there; what was interrupted goes on where it stopped.

    Args:
        options: JSON of the config section `photo`, as far as it names networks.
        out: JSON with source, commit and sha256 of all of them.
        lock: JSON with commit and sha256 of every source and revision that was ever fetched; with it another machine
            gets the same bytes, or an error.
    """
    records, locked = {}, _read_lock(lock)
    for name, network in read_options(FetchOptions, options).networks().items():
        key, asked = f"photo.{name}", f"{network.source}@{network.revision}"
        records[name] = found = fetched(network, key, locked.get(asked))
        print(f"{key}: {json.dumps(found)}", flush=True)
        if "commit" in found and asked not in locked:
            locked[asked] = Locked(commit=found["commit"], sha256=found["sha256"])
            write_text(lock, json.dumps({k: v.model_dump() for k, v in sorted(locked.items())}, indent=2) + "\n")
            print(f"{lock}: {asked} is {found['commit']} from now on; keep the file with your config")
    if out is not None:
        write_text(out, json.dumps(records, indent=2) + "\n")


class Locked(Contract):
    """What was fetched of a source at a revision."""

    commit: str = Field(pattern="^[0-9a-f]{7,64}$")
    sha256: str = Field(pattern="^[0-9a-f]{64}$")


def _read_lock(path: Path) -> dict[str, Locked]:
    if not path.is_file():
        return {}
    try:
        return TypeAdapter(dict[str, Locked]).validate_json(path.read_bytes())
    except ValidationError as error:
        raise InputError(
            path, f"is broken at {first_error(error)}.", "remove it to lock what comes next", code="E-WEIGHTS-LOCK"
        ) from None


def fetched(network: WeightsConfig, key: str, locked: Locked | None = None) -> Record:
    """What lies in a network's folder, after it was downloaded if need be.

    A folder with weights that we did not put there is the user's own and stays as it is.

    Args:
        network: where they are, and where they come from.
        key: its key in the config.
        locked: what was fetched of this source and revision before, here or elsewhere.

    Raises:
        InputError: nothing to download from, the download failed, or the weights are not those of `sha256` or the lock.
    """
    folder = Path(network.path)
    asked = {"source": network.source, "revision": network.revision}
    record = folder / RECORD
    known = json.loads(record.read_text(encoding="utf-8")) if record.is_file() else {}
    own = (folder / "model.safetensors").is_file() and not known and not (folder / ".cache").exists()
    if own or (known and asked.items() <= known.items()):
        check_folder(network, key)
        if known:
            _check_lock(folder, known["sha256"], locked)
        return known or {"path": network.path, "sha256": weights_sha256(network)}
    if not network.source:
        raise InputError(
            f"{key}.source",
            "is empty, and its path holds no weights.",
            "a model id of the hub",
            code="E-WEIGHTS-MISSING",
        )
    record.unlink(missing_ok=True)
    commit = _download(network, key, locked.commit if locked else network.revision)
    check_folder(network, key)
    found = {**asked, "commit": commit, "path": network.path, "sha256": weights_sha256(network)}
    _check_lock(folder, found["sha256"], locked)
    write_text(record, json.dumps(found, indent=2) + "\n")
    return found


def _check_lock(folder: Path, sha256: str, locked: Locked | None) -> None:
    if locked is not None and sha256 != locked.sha256:
        what, fix = (
            f"has sha256 {sha256}, locked is {locked.sha256}.",
            "remove the folder, or the entry of the lock file",
        )
        raise InputError(folder / "model.safetensors", what, fix, code="E-WEIGHTS-CHECKSUM")


def _download(network: WeightsConfig, key: str, revision: str) -> str:
    """The commit that was downloaded into the network's folder."""
    from huggingface_hub import HfApi, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, HFValidationError

    try:
        commit = str(HfApi().model_info(network.source, revision=revision).sha)
        print(f"{key}: {network.source} at {commit} -> {network.path}", flush=True)
        snapshot_download(network.source, revision=commit, local_dir=network.path, allow_patterns=WANTED)
    except (HfHubHTTPError, HFValidationError, OSError, ValueError) as error:
        reason = (str(error).strip() or error.__class__.__name__).splitlines()[0]
        what = f"'{network.source}' at '{revision}' cannot be fetched ({reason})."
        fix = f"run it again, what came stays; or put the folder into {network.path} by hand"
        raise InputError(f"{key}.source", what, fix, code="E-WEIGHTS-DOWNLOAD") from None
    return commit
