"""How the search of one object grows with the library: exact, compressed, and with a shortlist.

    python -m benchmarks.scaling --run . [--models 150 600 1500 3000]

Takes the feature store and the objects of a finished run, and repeats the models of the library: a copy has the same
patches, each 0.1 % longer than those of the copy before, so that no two tie. Nothing is written: reading from disk is
not measured. CPU seconds of one thread per object, over the objects of some rooms.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import table
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Library, Objects, read_json
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.matching.candidates import find_candidates
from roomkin.stages.matching.encoders import EXTRA_COLUMNS, make_encoder, settings_digest
from roomkin.stages.matching.ranking import make_query, rank_models, rank_orientations
from roomkin.stages.matching.snapshots import SceneObjects
from roomkin.stages.matching.store import Codec, FeatureStore, Snapshot, learn
from roomkin.stages.matching.text_encoders import make_text_encoder


class Repeated:
    """A store of more models: `name-copy3` is a copy of `name`. With a codec it holds codes and decodes them."""

    def __init__(self, store: FeatureStore, names: Sequence[str], compressed: bool) -> None:
        self.store, self.yaws = store, store.yaws
        self.codec: Codec | None = None
        self.codes: dict[Snapshot, NDArray[Any]] = {}
        if compressed:
            views = [Snapshot(name, view) for name in names for view in range(len(store.yaws))]
            self.codec = learn(np.concatenate([store.rows(view) for view in views[::20]]), 72, EXTRA_COLUMNS)
            self.codes = {view: self.codec.encode(store.rows(view)) for view in views}

    def rows(self, snapshot: Snapshot) -> NDArray[np.float32]:
        """Patches of a view of a copy."""
        name, _, copy = snapshot.asset.partition("-copy")
        original = Snapshot(name, snapshot.view)
        rows = self.codec.decode(self.codes[original]) if self.codec else self.store.rows(original)
        return rows * np.float32(1 + 0.001 * int(copy or 0))

    def read_wholes(self, asset: str, views: Sequence[int]) -> NDArray[np.float32]:
        """Views of a copy as wholes."""
        name, _, copy = asset.partition("-copy")
        return self.store.read_wholes(name, views) * np.float32(1 + 0.001 * int(copy or 0))


def grow_library(library: Library, models: int) -> Library:
    """The library with copies of its models, or cut, to so many."""
    count = len(library.assets)
    entries: list[LibraryEntry] = []
    for number in np.linspace(0, max(models, count) - 1, models).round().astype(int).tolist():
        copy, place = divmod(number, count)
        entry = library.assets[place]
        entries.append(entry.model_copy(update={"id": f"{entry.id}-copy{copy}"}))
    return Library(assets=entries)


def rows(run: Path, rooms: list[str], sizes: list[int]) -> Iterator[list[Any]]:
    """One row per size of the library."""
    options = MatchingConfig()
    encoder, text = make_encoder(options), make_text_encoder(options)
    shards = sorted((run / "results/matching/features").glob("hog-*/shard_*.npy"))
    store = FeatureStore(shards, settings_digest(options, encoder))
    library = read_json(Library, run / "results/assets/library/library.json")
    stores = [Repeated(store, [entry.id for entry in library.assets], compressed) for compressed in (False, True)]
    queries = []
    for room in rooms:
        objects = run / "results/extraction" / room / "objects.json"
        scene = SceneObjects(objects, run / "results/scenes" / room / "input/rgb.png")
        found = [item for item in read_json(Objects, objects).objects if item.status != "failed"]
        queries += [(item, make_query(scene.view(item), encoder)) for item in found]
    for models in sizes:
        larger = grow_library(library, models)
        seconds: dict[str, list[float]] = {}
        compared = []
        for item, query in queries:
            if query is None:
                continue
            everything = find_candidates(item, larger, text, options)
            compared.append(len(everything.assets))
            for number, stored in enumerate(stores):
                for shortlist in (0, 30):
                    setting: Any = options.model_copy(update={"shortlist": shortlist})
                    since = time.process_time()
                    candidates = shortlist(query, everything, item, stored, setting)  # type: ignore[arg-type]
                    rank_models(query, candidates, item, stored, setting)  # type: ignore[arg-type]
                    seconds.setdefault(f"{number}{shortlist}", []).append(time.process_time() - since)
            since = time.process_time()
            rank_orientations(query, everything.assets[0].id, stores[0], options)  # type: ignore[arg-type]
            seconds.setdefault("orientation", []).append(time.process_time() - since)
        yield [models, f"{np.mean(compared):.0f}", *(f"{np.mean(spent):.2f}" for _, spent in sorted(seconds.items()))]


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=Path, default=Path(), help="folder that holds results/")
    parser.add_argument("--rooms", nargs="+", default=["room_1"])
    parser.add_argument("--models", type=int, nargs="+", default=[150, 600, 1500, 3000])
    asked = parser.parse_args()
    heading = ["models", "candidates of an object", "exact (CPU s)", "exact, shortlist 30", "72 components"]
    table([*heading, "72, shortlist 30", "yaws of one cousin"], rows(asked.run, asked.rooms, asked.models))


if __name__ == "__main__":
    main()
