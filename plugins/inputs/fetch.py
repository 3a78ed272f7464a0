"""`fetch`: the weights of the networks that find what a picture shows, downloaded once; offline from then on."""

import json
from pathlib import Path

from pydantic import Field, TypeAdapter, ValidationError

from plugins.inputs.config import PhotoSection
from plugins.pretrained.weights import check_folder, weights_sha256
from stages.contracts import InputError, read_options, write_text
from stages.contracts.files import Contract, first_error

LOCK = Path("weights.lock.json")
SOURCES = {  # model ids on the hub
    "detector": "IDEA-Research/grounding-dino-base",
    "segmenter": "facebook/sam2.1-hiera-large",
    "depth_anything": "depth-anything/Depth-Anything-V2-Metric-Indoor-Large-hf",
}
RECORD = "fetched.json"  # beside the weights, when all of their files are there
WANTED = ["*.json", "*.txt", "model.safetensors"]
Record = dict[str, str]


def run(*, options: str = "", sources: str = "{}", out: Path | None = None, lock: Path = LOCK) -> None:
    """Download missing weights; an interrupted download is resumed.

    Args:
        options: JSON of the config section `photo`: which networks are used, and their folders.
        sources: JSON of other models on the hub, e.g. {"detector": "IDEA-Research/grounding-dino-tiny"}.
        out: JSON with source, commit and sha256 of all of them.
        lock: JSON with commit and sha256 of every source that was ever fetched; with it another machine gets the same
            bytes, or an error.
    """
    records, locked = {}, _read_lock(lock)
    known = SOURCES | json.loads(sources)
    for name, folder in read_options(PhotoSection, options).networks().items():
        key, asked = f"photo.{name}", known[name]
        records[name] = found = fetch_weights(folder, asked, key, locked.get(asked))
        print(f"{key}: {json.dumps(found)}", flush=True)
        if "commit" in found and asked not in locked:
            locked[asked] = Locked(commit=found["commit"], sha256=found["sha256"])
            write_text(lock, json.dumps({k: v.model_dump() for k, v in sorted(locked.items())}, indent=2) + "\n")
            print(f"{lock}: {asked} is {found['commit']} from now on; keep the file with your config")
    if out is not None:
        write_text(out, json.dumps(records, indent=2) + "\n")


class Locked(Contract):
    """What was fetched of a source."""

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


def fetch_weights(path: str, source: str, key: str, locked: Locked | None = None) -> Record:
    """What lies in a network's folder, after it was downloaded if need be.

    A folder with weights that we did not put there is the user's own and stays as it is.

    Args:
        path: the folder.
        source: where the weights come from: a model id of the hub.
        key: of the folder in the config.
        locked: what was fetched of this source before, here or elsewhere.

    Raises:
        InputError: the download failed, or the weights are not those of the lock.
    """
    folder = Path(path)
    record = folder / RECORD
    known = json.loads(record.read_text(encoding="utf-8")) if record.is_file() else {}
    own = (folder / "model.safetensors").is_file() and not known and not (folder / ".cache").exists()
    if own or known.get("source") == source:
        check_folder(path, key)
        if known:
            _check_lock(folder, known["sha256"], locked)
        return known or {"path": path, "sha256": weights_sha256(path)}
    record.unlink(missing_ok=True)
    commit = _download(folder, source, key, locked.commit if locked else "main")
    check_folder(path, key)
    found = {"source": source, "commit": commit, "path": path, "sha256": weights_sha256(path)}
    _check_lock(folder, found["sha256"], locked)
    write_text(record, json.dumps(found, indent=2) + "\n")
    return found


def _check_lock(folder: Path, sha256: str, locked: Locked | None) -> None:
    if locked is not None and sha256 != locked.sha256:
        what, fix = f"has sha256 {sha256}, locked is {locked.sha256}.", "remove the folder, or the lock file's entry"
        raise InputError(folder / "model.safetensors", what, fix, code="E-WEIGHTS-CHECKSUM")


def _download(folder: Path, source: str, key: str, revision: str) -> str:
    """The commit that was downloaded into a folder."""
    from huggingface_hub import HfApi, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, HFValidationError

    try:
        commit = str(HfApi().model_info(source, revision=revision).sha)
        print(f"{key}: {source} at {commit} -> {folder}", flush=True)
        snapshot_download(source, revision=commit, local_dir=folder, allow_patterns=WANTED)
    except (HfHubHTTPError, HFValidationError, OSError, ValueError) as error:
        reason = (str(error).strip() or error.__class__.__name__).splitlines()[0]
        what = f"'{source}' at '{revision}' cannot be fetched ({reason})."
        fix = f"run it again, what came stays; or put the folder into {folder} by hand"
        raise InputError(key, what, fix, code="E-WEIGHTS-DOWNLOAD") from None
    return commit
