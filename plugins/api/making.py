"""A library, a room and the scenes of a picture, by the commands that the rules call.

With the options that the rules pass, too: the same config gives the same bytes. `config` is what differs from
config.yaml, e.g. {"assets": {"counts": {"fridge": 12}}}. A command is imported when it is called.
"""

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from roomkin.stages.config.commands import fill_counts
from roomkin.stages.config.inputs import HOLDS, describe_missing, scene_of_folder
from roomkin.stages.config.model import Config, load, with_defaults
from roomkin.stages.config.other_pictures import read_digest
from roomkin.stages.config.packages import load_command, shards_of
from roomkin.stages.config.reads import options_of
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.hand import CORRECTIONS, digest_of_picture, find_hand_file, read_corrections
from roomkin.stages.contracts.library_folder import AssetFolders


def make_library(out: str | Path, config: Mapping[str, Any] | None = None) -> Path:
    """Make the models, import those of `assets.folders`, and photograph all of them, into the folder `out`.

    A library that was there is replaced.

    Returns:
        library.json.
    """
    folder, settings = Path(out), _settings(config)
    counts, theirs = settings.assets.counts, shards_of(settings)
    settings = fill_counts(settings, sum(counts.values()) + sum(len(shard.models) for shard in theirs.values()))
    for old in (path for place in (".", "snapshots", "features/*") for path in folder.glob(f"{place}/shard_*")):
        old.unlink()
    shards = (settings.assets.shards or 1) if any(counts.values()) else 0
    ours = [folder / f"shard_{number}.json" for number in range(shards)]
    for number, part in enumerate(ours):
        _run(settings, "furniture", "library", out=part, shard=number, shards=shards, seed=settings.seed)
    for name, shard in theirs.items():
        models = tuple(f"{model}={path}" for model, path in shard.models.items())
        _run(settings, "importing", "own", folder=shard.folder, models=models, out=folder / f"shard_{name}.json")
    parts = [*ours, *(folder / f"shard_{name}.json" for name in theirs)]
    for part in parts:
        _run(settings, "assets", "snapshots", library=part, out=folder / "snapshots" / f"{part.stem}.h5")
    load_command("assets", "join")(library=tuple(ours), own=tuple(parts[shards:]), out=folder / "library.json")
    return folder / "library.json"


def make_room(name: str, library: str | Path, out: str | Path, config: Mapping[str, Any] | None = None) -> Path:
    """Furnish one of the rooms that come with the package with procedural models and photograph it.

    Args:
        name: e.g. room_1.
        library: library.json of `make_library`.
        out: folder; gets <name>/input and <name>/truth.json.

    Returns:
        the input folder: rgb.png, camera.json, depth.npz, masks.png, annotations.json.
    """
    settings, folder = _settings(config), Path(out) / name
    ours = [part for part in _parts(Path(library)) if not part.stem.startswith("shard_own")]
    parts = tuple(ours) or (Path(library),)
    _run(settings, "scenes", "render", library=parts, scene=name, out=folder, seed=settings.seed)
    return folder / "input"


def make_scenes(
    picture: str | Path, library: str | Path, out: str | Path, config: Mapping[str, Any] | None = None
) -> list[Path]:
    """Find the objects of a picture, their cousins, and make the scene of every rank, into the folder `out`.

    Beside scene_<rank>.json lie pictures (.png) and models to turn (.glb) of them, objects.json and cousins.json. What
    stands there wears the picture's colors; of a room of `make_room` the library's.

    Args:
        picture: an input folder (docs/scenes.md); the scene is named after it, or after the folder that holds `input`.
        library: library.json of `make_library`; its features are kept beside it.

    Returns:
        scene_1.json, scene_2.json, ...

    Raises:
        InputError: the picture's folder is not there or lacks a file; `out` holds what was made of another picture.
    """
    source, index, folder = Path(picture), Path(library), Path(out)
    settings = fill_counts(_settings(config), len(AssetFolders(index)))
    if lacking := describe_missing(source):
        others = [path.parent.name for path in source.parent.glob("*/camera.json")]
        mend = suggest_nearest(source.name, others) if others and not source.is_dir() else HOLDS
        raise InputError("picture", f"{lacking[0]}.", mend, code="E-FILE-MISSING")
    scene, variant = scene_of_folder(source), settings.experiment.policy_variant
    image, objects, cousins = source / "rgb.png", folder / "objects.json", folder / "cousins.json"
    if read_digest(objects) not in ("", digest_of_picture(source)):
        fix = "choose another folder, or delete this one"
        raise InputError(objects, "is of another picture.", fix, code="E-PICTURE-OTHER")
    kept = find_hand_file(source, CORRECTIONS, partial(digest_of_picture, source))
    said = read_corrections(files := tuple(path for path in [kept] if path.is_file()))
    corrections = {stage: files if said.read_by(stage).is_any else () for stage in ("extraction", "generation")}
    _run(
        settings, "extraction", "extract", {"scene": ""}, input=source, scene=scene, out=objects,
        own=tuple(path for path in [source / "config.yaml"] if path.is_file()),
        corrections=corrections["extraction"], seed=settings.seed,
    )  # fmt: skip
    parts = _parts(index) if settings.matching_of(variant).compares_pictures else []
    shards = tuple(index.parent / "snapshots" / f"{part.stem}.h5" for part in parts)
    _run(
        settings, "matching", "match", {"variant": variant}, objects=objects, image=image, library=index, out=cousins,
        snapshots=shards, features=tuple(_features(settings, variant, path) for path in shards),
    )  # fmt: skip
    placed = settings.generation_of(variant)
    rendered = (source.parent / "truth.json").is_file()  # by `make_room`: it keeps the library's colors
    _run(
        settings, "generation", "generate", {"variant": variant}, cousins=cousins, objects=objects, library=index,
        variant=variant, out=folder, corrections=corrections["generation"], input=source,
        image=() if rendered and placed.finish is None else (image,),
    )  # fmt: skip
    scenes = tuple(folder / f"scene_{rank}.json" for rank in range(1, placed.ranks + 1))
    if settings.packages.get("pictures"):
        load_command("pictures", "scenes")(scenes=scenes, objects=objects, image=image, library=index, out=folder)
    return list(scenes)


def models_of(library: str | Path) -> AssetFolders:
    """The folders of a library's models by id, for `gym.make(..., asset_folder=)`."""
    return AssetFolders(Path(library))


def _settings(config: Mapping[str, Any] | None) -> Config:
    given = with_defaults(dict(config or {}))
    own = "experiment" in (config or {})
    if not own:  # the usual rooms and targets would want models that a library need not have
        given["experiment"] |= {"rooms": ["*"], "targets": {}}
    return load(given, rooms_named=own)


def _run(settings: Config, stage: str, command: str, wildcards: dict[str, str] | None = None, /, **flags: Any) -> None:
    """A command with the --options that the workflow passes to it."""
    options = json.dumps(options_of(settings, stage, command, wildcards or {}), sort_keys=True)
    load_command(stage, command)(options=options, **flags)


def _parts(library: Path) -> list[Path]:
    """The indices of a library's shards, procedural ones first, in the workflow's order."""
    return sorted(library.parent.glob("shard_*.json"), key=lambda path: (len(path.stem), path.stem))


def _features(settings: Config, variant: str, snapshots: Path) -> Path:
    """The features of a shard, made if they are not there yet."""
    store = settings.matching_of(variant).store()
    path = snapshots.parents[1] / "features" / store / f"{snapshots.stem}.npy"
    if not path.exists():
        _run(settings, "matching", "features", {"store": store}, snapshots=snapshots, out=path)
    return path
