"""The rooms as a data set for others: plain files by set and room, a page a set, licences, a manifest of digests."""

import hashlib
import json
import shutil
import zipfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from benchmarks.open_rooms import packs, pictures, sensor
from benchmarks.open_rooms.handles import find_handles
from roomkin.plugins.scorecard.truth import HANDLES, PictureTruth, as_plain, with_opening
from roomkin.stages.contracts import InputError, write_atomically, write_json, write_text
from roomkin.stages.evaluation.scoring import DENSE, fill_cells

DATA = "rooms"
KNOWN = Path("docs/results/scorecard/manifest.json")  # of the machine that the page was made on
FILES = {
    "rgb.png": "rgb.png", "intrinsics.json": "camera.json", "exact.png": "masks_exact.png",
    "exact.json": "masks_exact.json", "drawn.png": "masks_drawn.png", "drawn.json": "masks_drawn.json",
    **{f"depth_{device.name}.png": f"depth_{device.name}.png" for device in sensor.DEVICES},
}  # fmt: skip
# What may differ in single pixels between processors, so that nothing is scored by it.
MAY_DIFFER = ("rgb.png", "depth_", "masks_", "shapes.npz")
DIGITS = 6  # of metres and radians in the truth: what is beyond differs from processor to processor
LEGAL = ("licen", "copyright", "copying")


def publish(root: Path, halves: list[str]) -> None:
    """Write `rooms/` of a folder, from what `fetch` and `render` made there.

    Raises:
        InputError: a picture was rendered before there was the depth of three sensors.
    """
    data = root / DATA
    for half in halves:
        models = {one.id: one for one in packs.models(root / "packs", half)}
        truths = [publish_room(folder, data / half, models) for folder in pictures.folders(root, half)]
        used = sorted({thing.model for truth in truths for thing in truth.things})
        write_shapes(data / half / "shapes.npz", [models[name] for name in used])
        write_handles(data / half / HANDLES, list(models.values()))
        write_text(data / half / "README.md", describe_set(half, truths))
    copy_licences(root / "packs/archives", data / "licences")
    write_json(data / "manifest.json", list_digests(data))


def publish_room(folder: Path, out: Path, models: dict[str, packs.PackModel]) -> PictureTruth:
    """Copy the files of a picture, and write its truth with how things open."""
    for ours, theirs in FILES.items():
        if not (folder / ours).is_file():
            raise InputError(folder, f"has no {ours}.", "delete it and render it again", code="E-FILE-MISSING")
        with write_atomically(out / folder.name / theirs) as path:
            shutil.copyfile(folder / ours, path)
    opens = {name: (model.opens, model.handle) for name, model in models.items()}
    truth = with_opening(pictures.read(folder), opens)
    write_json(out / folder.name / "truth.json", round_numbers(as_plain(truth)))
    return truth


def round_numbers(value: Any) -> Any:
    """The same plain data, its numbers with `DIGITS` digits."""
    if isinstance(value, dict):
        return {key: round_numbers(one) for key, one in value.items()}
    if isinstance(value, list):
        return [round_numbers(one) for one in value]
    return round(value, DIGITS) + 0.0 if isinstance(value, float) else value


def write_shapes(path: Path, models: list[packs.PackModel]) -> None:
    """What is filled of the models' boxes, by id, as packed bits of 24 cells a side; undated."""
    cells = {}
    for model in models:
        mesh = trimesh.util.concatenate([trimesh.Trimesh(p.vertices, p.faces, process=False) for p in model.parts])
        points = np.asarray(trimesh.sample.sample_surface(mesh, DENSE, seed=0)[0])
        low, high = mesh.bounds
        cells[model.id] = np.packbits(fill_cells((points - low) / np.maximum(high - low, 1e-9)))
    with write_atomically(path) as file:
        np.savez_compressed(file, **cells)


def write_handles(path: Path, models: list[packs.PackModel]) -> None:
    """Where the handles of the models are, by id, as far as their sources name them."""
    found = {model.id: find_handles(model) for model in models}
    write_json(path, {name: [asdict(one) for one in handles] for name, handles in found.items() if handles})


def describe_set(half: str, truths: list[PictureTruth]) -> str:
    """README.md of a set: its rooms, and where its models are from."""
    from_packs = sorted({thing.pack for truth in truths for thing in truth.things})
    lines = [f"# Rooms of the set {half}", "", "| room | sensor of docs/results/open.md | things | asked for |",
             "| --- | --- | --- | --- |"]  # fmt: skip
    lines += [
        f"| [{truth.name}]({truth.name}/rgb.png) | {truth.device} | {len(truth.things)} | "
        f"{len(truth.list_asked(drawn=False))} |"
        for truth in truths
    ]
    lines += ["", f"Models of {', '.join(from_packs)}; their licences lie in ../licences.", ""]
    return "\n".join(lines)


def copy_licences(archives: Path, out: Path) -> None:
    """The licence files of all packages, as they are in them."""
    for name, content in find_licences(archives):
        with write_atomically(out / name) as path:
            path.write_bytes(content)


def find_licences(archives: Path) -> Iterator[tuple[str, bytes]]:
    """Names and contents of licence files: of wheels, of unpacked Debian packages and of npm's."""
    for wheel in sorted(archives.glob("*.whl")):
        with zipfile.ZipFile(wheel) as file:
            about = [name for name in sorted(file.namelist()) if ".dist-info/" in name]
            legal = [name for name in about if any(word in name.casefold().split(".dist-info/")[1] for word in LEGAL)]
            for name in legal or [name for name in about if name.endswith("/METADATA")]:  # which names one at least
                yield f"{wheel.name.split('-')[0]}-{Path(name).name}", file.read(name)
    for path in sorted([*archives.glob("*/usr/share/doc/*/copyright"), *archives.glob("*/package/LICENSE*")]):
        yield f"{path.relative_to(archives).parts[0]}-{path.name}", path.read_bytes()


def list_digests(data: Path) -> dict[str, Any]:
    """The manifest: SHA-256 by file, in two parts: what two machines agree on, and what may differ in single pixels."""
    agreed, pixels = dict[str, str](), dict[str, str]()
    for path in sorted(data.rglob("*")):
        name = path.relative_to(data).as_posix()
        if path.is_file() and path.name not in ("manifest.json", "README.md"):
            part = pixels if any(path.name.startswith(word) for word in MAY_DIFFER) else agreed
            part[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return {"agreed": agreed, "may_differ": pixels}


def compare_manifests(ours: Path, theirs: Path) -> list[str]:
    """Lines about files that differ from those of another manifest; what both have alone counts."""
    one, other = (json.loads(path.read_text(encoding="utf-8")) for path in (ours, theirs))
    lines = []
    for part, word in (("agreed", "differs"), ("may_differ", "differs in pixels, by which nothing is scored")):
        same = one[part].keys() & other[part].keys()
        lines += [f"{name}: {word}" for name in sorted(same) if one[part][name] != other[part][name]]
    return lines


def check_manifest(root: Path) -> list[str]:
    """Lines that say whether the data set is that of `KNOWN`."""
    ours = root / DATA / "manifest.json"
    if not KNOWN.is_file():
        return [f"{ours}: nothing to compare with, as there is no {KNOWN}"]
    return compare_manifests(ours, KNOWN) or [f"{ours}: every file is as in {KNOWN}"]
