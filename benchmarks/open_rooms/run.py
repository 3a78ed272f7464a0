"""Pictures through the project's own stages, one after the other in one process, as the workflow calls them."""

import contextlib
import json
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.open_rooms import pictures
from benchmarks.open_rooms.by_clicks import plan_corrections
from benchmarks.open_rooms.pictures import ALONE, BY_HAND
from roomkin.stages.config.model import Config
from roomkin.stages.config.reads import options_of, stores
from roomkin.stages.contracts import Annotations, InputError, read_json, write_json
from roomkin.stages.contracts.hand import CORRECTIONS, Corrections
from roomkin.stages.extraction import extract
from roomkin.stages.generation import generate
from roomkin.stages.matching import match
from roomkin.stages.perception import draw, from_rgbd, see

# Who chooses: the default judge, the default encoder alone, and nobody who looks (docs/matching.md).
ROWS: dict[str, dict[str, Any]] = {
    "geometry": {},
    "hog": {"model_selection": "distance", "orientation_selection": "distance"},
    "no-image": {"model_selection": "priors", "orientation_selection": "priors"},
}
ONE_RANK = {"ranks": 1}


@dataclass(frozen=True)
class Shelves:
    """The library of a results folder: its list, and by shard the encoded patches and the snapshots."""

    library: Path
    features: tuple[Path, ...]
    snapshots: tuple[Path, ...]


def shelves(results: Path, config: Config) -> Shelves:
    """Library and features that `snakemake library` and the like have made.

    Raises:
        InputError: they are not there.
    """
    store = next(iter(stores(config)))
    features = sorted((results / "matching/features" / store).glob("shard_*.npy"))
    snapshots = sorted((results / "assets/snapshots").glob("shard_*.h5"))
    models = list((results / "assets/library").glob("shard_*.zip"))
    if not models or {len(features), len(snapshots)} != {len(models)}:
        wanted = " ".join(f"{results}/matching/features/{store}/shard_{shard}.npy" for shard in range(len(models)))
        what = "has no library with features of all its models."
        raise InputError(results, what, f"snakemake --cores 2 {wanted}", code="E-FEATURES-MISSING")
    return Shelves(results / "assets/library/library.json", tuple(features), tuple(snapshots))


def make_config() -> Config:
    """The default config with a variant per row."""
    document = Config().model_dump(mode="json")
    document["experiment"]["variants"] = ROWS
    document["experiment"]["policy_variant"] = "geometry"
    return Config.model_validate(document)


def run(root: Path, results: Path, half: str, only: str, masks: tuple[str, ...], rows: tuple[str, ...]) -> None:
    """Reconstruct the pictures of `root` that are not reconstructed yet.

    Args:
        root: folder of `render`.
        results: folder with the default library and its features.
        half: of the pictures; all if empty.
        only: in the names of pictures.
        masks: of `pictures.MASKS`; `corrected` corrects what `unaided` has made.
        rows: of `ROWS`.
    """
    config = make_config()
    shelf = shelves(results, config)
    for kind in masks:
        for folder in sorted(pictures.folders(root, half), key=lambda path: path.name.split("_")[::-1]):
            if only in folder.name:
                try:
                    _reconstruct(root, folder, kind, rows, config, shelf)
                except StoppedError as stopped:
                    print(f"{folder.name}, {kind}: {stopped}", file=sys.stderr)


class StoppedError(Exception):
    """Why a stage refused a picture, and its log."""


def _reconstruct(root: Path, folder: Path, kind: str, rows: tuple[str, ...], config: Config, shelf: Shelves) -> None:
    out = root / "results" / kind / folder.name
    out.mkdir(parents=True, exist_ok=True)
    entry = input_folder(root, folder, kind)
    objects = out / "extraction" / "objects.json"
    scene = folder.name.replace("-", "_")
    if not objects.is_file():
        with log_stage(out / "extraction.log"):
            extract_objects(entry, scene, objects, config, _make_input(root, folder, kind, entry))
    for row in rows:
        ranks = {} if row == "geometry" and kind in BY_HAND else ONE_RANK  # the others are there to be compared with
        place_cousins(entry, objects, out, row, config, shelf, ranks)


def extract_objects(entry: Path, scene: str, objects: Path, config: Config, corrections: tuple[Path, ...] = ()) -> None:
    """Write the objects.json of an input folder."""
    objects.parent.mkdir(exist_ok=True)
    options = options_of(config, "extraction", "extract", {"scene": scene})
    extract.run(
        input=entry,
        scene=scene,
        out=objects,
        options=json.dumps(options),
        own=(entry / "config.yaml",),
        corrections=corrections,
    )


def place_cousins(
    entry: Path, objects: Path, out: Path, row: str, config: Config, shelf: Shelves, ranks: dict[str, int]
) -> None:
    """Write cousins.json and scenes of a row into a folder of `out`, if they are not there; `ranks`: options."""
    cousins, scenes = out / row / "cousins.json", out / row
    if not cousins.is_file():
        options = options_of(config, "matching", "match", {"variant": row})
        compares = config.matching_of(row).compares_pictures
        with log_stage(out / f"{row}.log"):
            cousins.parent.mkdir(exist_ok=True)
            match.run(
                objects=objects,
                image=entry / "rgb.png",
                library=shelf.library,
                out=cousins,
                features=shelf.features if compares else (),
                snapshots=shelf.snapshots if compares else (),
                options=json.dumps(options),
            )
    if not (scenes / "scene_1.json").is_file():
        options = options_of(config, "generation", "generate", {"variant": row})
        with log_stage(out / f"{row}_generation.log"):
            generate.run(
                cousins=cousins,
                objects=objects,
                library=shelf.library,
                variant=row.replace("-", "_"),
                out=scenes,
                options=json.dumps(options | ranks),
            )


def input_folder(root: Path, folder: Path, kind: str) -> Path:
    """The input folder of a picture with masks of this kind; corrections are of the unaided one."""
    return root / "results" / ("unaided" if kind == "corrected" else kind) / folder.name / "input"


def _make_input(root: Path, folder: Path, kind: str, entry: Path) -> tuple[Path, ...]:
    """Write the input folder, or corrections of the one that is there."""
    truth = pictures.read(folder)
    if kind == "corrected":
        path = root / "results" / kind / folder.name / CORRECTIONS
        told = [step.correction for step in plan_corrections(root, folder) if step.correction is not None]
        write_json(path, Corrections(objects=told))
        return (path,)
    if kind == ALONE:
        draw.run(image=folder / "rgb.png", out=entry)
        return ()
    by_hand = {} if kind not in BY_HAND else {"masks": folder / f"{kind}.png", "labels": folder / f"{kind}.json"}
    files = {"rgb": folder / "rgb.png", "depth": folder / "depth.png"}
    camera, out = (str(folder / "intrinsics.json"),), entry if by_hand else entry.parent / "view"
    from_rgbd.run(out=out, unit="mm", camera=camera, **files, **by_hand)
    if by_hand:
        _count_panels(entry, truth)
    else:
        see.run(picture=entry.parent / "view", out=entry)
    return ()


def _count_panels(entry: Path, truth: pictures.PictureTruth) -> None:
    """What is left to people: how many doors and drawers things have."""
    path = entry / "annotations.json"
    document = read_json(Annotations, path)
    known = {thing.number: thing for thing in truth.things}  # not a piece that from_rgbd took for a thing of its own
    counted = [
        item.model_copy(update={"doors": thing.doors, "drawers": thing.drawers, "articulated": True})
        if (thing := known.get(item.mask)) and thing.doors + thing.drawers
        else item
        for item in document.objects
    ]
    write_json(path, document.model_copy(update={"objects": counted}))


@contextlib.contextmanager
def log_stage(log: Path) -> Any:
    """What a stage prints goes into a file; where one stops, the picture is left and the reason stays there."""
    since = time.process_time()
    with log.open("w") as file, contextlib.redirect_stdout(file), contextlib.redirect_stderr(file):
        try:
            yield
        except Exception as error:
            traceback.print_exc()
            raise StoppedError(f"{error} (see {log})") from error
        finally:
            print(f"{time.process_time() - since:.1f} CPU s")
