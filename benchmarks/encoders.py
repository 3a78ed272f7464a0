"""Row (b) of Table 2 by one patch encoder: which category and which model of the library it takes each object for.

    snakemake --cores 2 extraction results/assets/snapshots/shard_{0,1,2}.h5 \\
        --configfile config.yaml config/study/table2.yaml
    python -m benchmarks.encoders --encoder dinov2 --keep kept

Models are compared by their representative snapshots alone, by distance, as row (b) does; nothing is turned or placed.
Each picture is encoded when it is first asked for and kept in a folder, so that a run which was ended goes on.
"""

import argparse
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import table
from roomkin.stages.config.matching import EncoderOptions, MatchingConfig
from roomkin.stages.config.model import read_files
from roomkin.stages.contracts import Library, Truth, read_json
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.candidates import find_candidates
from roomkin.stages.matching.encoders import EXTRA_COLUMNS, PatchEncoder, column_weights, encode_rows, make_encoder
from roomkin.stages.matching.ranking import Query, apply_weights, compare, pool_patches
from roomkin.stages.matching.snapshots import SceneObjects, Snapshots
from roomkin.stages.matching.text_encoders import make_text_encoder

CONFIG = [Path("config.yaml"), Path("config/study/table2.yaml")]
Rows = NDArray[np.float16]


class Change(NamedTuple):
    """What differs from row (b).

    Attributes:
        grey: both sides are shown without color.
        unit: features are made unit vectors before they are compared.
        position: weight of a patch's place in the crop; None: the encoder's own.
    """

    grey: bool = False
    unit: bool = False
    position: float | None = None


def drain(view: ObjectView) -> ObjectView:
    """The view without color: each pixel's luminance (ITU-R BT.601) in all three channels."""
    luminance = np.rint(view.rgb @ np.array([0.299, 0.587, 0.114])).astype(np.uint8)
    return replace(view, rgb=np.repeat(luminance[..., None], 3, axis=2))


def to_unit(rows: Rows) -> NDArray[np.float32]:
    """Stored rows (P, D + 5) with features of length 1."""
    changed = rows.astype(np.float32)
    features = changed[:, :-EXTRA_COLUMNS]
    features /= np.maximum(np.linalg.norm(features, axis=1, keepdims=True), 1e-9)
    return changed


def read_representative(snapshots: Snapshots, asset: str) -> ObjectView:
    """The snapshot by which row (b) compares a model."""
    return snapshots.views(asset)[-1]


class KeptRows:
    """Rows of pictures, encoded once into a folder."""

    def __init__(self, encoder: PatchEncoder, folder: Path, change: Change) -> None:
        self.encoder, self.folder, self.change = encoder, folder, change
        self.encoded, self.seconds = 0, 0.0
        folder.mkdir(parents=True, exist_ok=True)

    def rows(self, name: str, read_view: Callable[[], ObjectView]) -> NDArray[np.floating]:
        """Rows (P, D + 5) of a picture that is known by its name, and read if it is not encoded yet."""
        path = self.folder / f"{name}.npy"
        if not path.is_file():
            since = time.process_time()
            view = read_view()
            [rows] = encode_rows(self.encoder, [drain(view) if self.change.grey else view])
            self.encoded, self.seconds = self.encoded + 1, self.seconds + time.process_time() - since
            with (part := path.with_suffix(".part")).open("wb") as file:
                np.save(file, rows)
            part.rename(path)
        rows = np.load(path)
        return to_unit(rows) if self.change.unit else rows

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """Factor (D + 5,) on each column."""
        factors = column_weights(self.encoder, depth)
        if self.change.position is not None:
            factors[-EXTRA_COLUMNS : 2 - EXTRA_COLUMNS] = self.change.position
        return factors


def read_rivals(path: Path) -> dict[tuple[str, str], str]:
    """The model that a run of this program, whose output a file holds, took each object for: by room and object."""
    cells = [[cell.strip() for cell in line.strip("|\n ").split("|")] for line in path.open(encoding="utf-8")]
    return {(row[0], row[1]): row[5] for row in cells if len(row) == 6 and row[0].startswith("room_")}


def find_models(
    results: Path, rooms: list[str], options: MatchingConfig, kept: KeptRows, rivals: dict[tuple[str, str], str]
) -> Iterator[list[str]]:
    """Room, object, true category and model, and those that were found, of every object.

    Args:
        rivals: if there are some, only objects whose rival is wrong are shown, between it and the true model.
    """
    library = read_json(Library, results / "assets/library/library.json")
    snapshots = Snapshots(sorted((results / "assets/snapshots").glob("shard_*.h5")))
    text = make_text_encoder(options)
    for room in rooms:
        inputs = results / "scenes" / room
        scene = SceneObjects(results / "extraction" / room / "objects.json", inputs / "input/rgb.png")
        truth = {item.mask: item for item in read_json(Truth, inputs / "truth.json").objects}
        for item in scene.objects.objects:
            true = truth[item.mask]
            if rivals and rivals.get((room, item.id)) in (true.asset, None):
                continue
            rows = kept.rows(f"{room}-{item.id}", partial(scene.view, item))
            weights = kept.weights(depth=True)
            query = Query(apply_weights(rows, weights), weights, pool_patches(rows.astype(np.float32)))
            assets = find_candidates(item, library, text, options).assets
            if rivals:
                assets = [entry for entry in assets if entry.id in (true.asset, rivals[room, item.id])]
            found = [kept.rows(entry.id, partial(read_representative, snapshots, entry.id)) for entry in assets]
            _, distances = compare(query, found.__getitem__, len(found), options)
            best = assets[int(np.argmin(distances))]
            yield [room, item.id, true.category, true.asset, best.category, best.id]


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--encoder", default="dinov2")
    parser.add_argument("--options", default="{}", help='JSON of the encoder, e.g. {"height": 588, "width": 784}')
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--keep", type=Path, required=True, help="folder of encoded pictures, one for each look")
    parser.add_argument("--rooms", nargs="+", default=[f"room_{number}" for number in range(1, 9)])
    parser.add_argument("--grey", action="store_true")
    parser.add_argument("--unit", action="store_true")
    parser.add_argument("--position", type=float)
    parser.add_argument("--rivals", type=Path, help="output of another run: its wrong models against the true ones")
    asked = parser.parse_args()
    change = Change(asked.grey, asked.unit, asked.position)
    config = read_files(CONFIG)
    changed = {"encoder": config.implementation("encoders", asked.encoder), asked.encoder: json.loads(asked.options)}
    given = EncoderOptions.model_validate({key: value for key, value in changed.items() if value})
    looks = {name: getattr(given, name) for name in ("encoder", "hog", "dinov2")}
    options = config.matching_of("b-hog").model_copy(update=looks)
    kept = KeptRows(make_encoder(options), asked.keep, change)
    found, rivals = [], read_rivals(asked.rivals) if asked.rivals else {}

    def rows() -> Iterator[list[str]]:
        for row in find_models(asked.results, asked.rooms, options, kept, rivals):
            found.append(row)
            yield row

    table(["room", "object", "true category", "true model", "found category", "found model"], rows())
    category, model = (sum(row[at] == row[at + 2] for row in found) for at in (2, 3))
    each = kept.seconds / max(kept.encoded, 1)
    print(f"\n{len(found)} objects: category {category}, model {model}")
    print(f"{kept.encoded} pictures encoded, {each:.3f} CPU s each")


if __name__ == "__main__":
    main()
