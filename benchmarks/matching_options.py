"""What every option of matching gives: category, model and yaw of all objects of some rooms whose truth is known.

    snakemake --cores 2 matching --configfile config.yaml config/study/table2.yaml     (elsewhere with --config seed=1)
    python -m benchmarks.matching_options --results results ../other/results

Prints the table of docs/results/matching.md: one line per set of options, columns for every folder of results. Patches
are compared once per weight of colour, the rest is added up from that. Another coverage makes features anew. One
thread.
"""

import argparse
import json
import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from stages.config.matching import MatchingConfig
from stages.contracts import Library, Truth, read_json
from stages.contracts.objects import SceneObject
from stages.contracts.scenes import TrueObject
from stages.geometry.frames import angle_difference
from stages.matching.candidates import find_candidates
from stages.matching.encoders import make_encoder, settings_digest
from stages.matching.features import run as features
from stages.matching.priors import list_addends
from stages.matching.question import DIGITS
from stages.matching.ranking import Query, apply_weights, choose_views, make_query
from stages.matching.scene import Scene
from stages.matching.search import distance_table
from stages.matching.store import FeatureStore, Snapshot
from stages.matching.text_encoders import make_text_encoder
from stages.matching.voting import embedding_distance

NEAR_YAW = np.radians(15)
SHOWN = 4  # ranks of which the workflow makes scenes
Options = dict[str, Any]
OFF: Options = {
    "symmetric": 0, "colour": 0, "label_weight": 0, "size_weight": 0, "place_weight": 0,
    "count_weight": 0, "count_threshold": None, "least_candidates": 1, "nearest_views": 1,
}  # fmt: skip
DEFAULT = MatchingConfig()
TEXT = make_text_encoder(DEFAULT)


class Row(NamedTuple):
    """What became of one object; `others`: share of ranks 2 to 4 that are of the true category."""

    category: bool
    model: bool
    yaw: bool
    others: float
    candidates: int


def variants() -> dict[str, Options]:
    """Lines of the table: the paper's, every option alone, all of the default, all but one, and some more."""
    default = {name: getattr(DEFAULT, name) for name in OFF}
    used = {name: value for name, value in default.items() if value != OFF[name]}
    return {
        "representative view, nothing else (paper)": OFF | {"views": 0},
        "12 views": OFF,
        **{f"12 views, `{name}: {value}`": OFF | {name: value} for name, value in used.items()},
        "**default**": {},
        **{f"default, `{name}: {json.dumps(OFF[name])}`": {name: OFF[name]} for name in used},
        **{f"default, `{name}: {value}`": {name: value} for name, value in more().items()},
    }


def more() -> Options:
    """Options that the default leaves out, tried on top of it."""
    tried = {"colour": 1.0, "size_weight": 0.3, "place_weight": 0.3, "count_weight": 0.02}
    return {name: value for name, value in tried.items() if getattr(DEFAULT, name) == OFF[name]}


class Thing:
    """One object with what it truly is, compared with models as they are asked for."""

    def __init__(self, item: SceneObject, true: TrueObject, yaw: float, query: Query, store: FeatureStore) -> None:
        self.item, self.true, self.yaw, self.query, self.store = item, true, yaw, query, store
        self._looks: dict[Snapshot, tuple[float, float]] = {}

    def measure_distances(self, assets: list[str], views: Sequence[int], symmetric: float) -> NDArray[np.float64]:
        """Distances (assets, views); both ways are computed once."""
        asked = [Snapshot(asset, view) for asset in assets for view in views]
        new = [snapshot for snapshot in asked if snapshot not in self._looks]
        if new:
            found = distance_table(
                self.query.patches,
                lambda number: apply_weights(self.store.rows(new[number]), self.query.weights),
                len(new),
                DEFAULT.search,
                1,
                both=True,
            )
            there = embedding_distance(found.table, DEFAULT.exclude_worst)
            back = [embedding_distance(way[:, None], DEFAULT.exclude_worst)[0] for way in found.backward]
            self._looks |= dict(zip(new, zip(there.tolist(), back, strict=True), strict=True))
        ways = np.array([self._looks[snapshot] for snapshot in asked]).reshape(len(assets), len(views), 2)
        mixed: NDArray[np.float64] = ways @ np.array([1 - symmetric, symmetric])
        return mixed

    def match(self, library: Library, options: MatchingConfig) -> Row:
        """As `decide_cousins` by distance."""
        candidates = find_candidates(self.item, library, TEXT, options)
        assets = [entry.id for entry in candidates.assets]
        seen = np.sort(self.measure_distances(assets, choose_views(self.store, options), options.symmetric), axis=1)
        extra = [sum(more.values()) for more in list_addends(self.item, candidates, options)]
        distances = seen[:, : options.nearest_views].mean(axis=1).round(DIGITS) + extra
        ranked = [candidates.assets[number] for number in np.argsort(distances.round(DIGITS), kind="stable")]
        turned = self.measure_distances([ranked[0].id], range(len(self.store.yaws)), options.symmetric)[0]
        turn = self.store.yaws[int(turned.argmin())]
        return Row(
            ranked[0].category == self.true.category,
            ranked[0].id == self.true.asset,
            angle_difference(turn, self.yaw, self.true.symmetry) <= NEAR_YAW,
            float(np.mean([entry.category == self.true.category for entry in ranked[1:SHOWN]] or [0.0])),
            len(ranked),
        )


class Rooms:
    """All rooms in a folder of results."""

    def __init__(self, results: Path, folder: Path) -> None:
        self.results, self.folder = results, folder
        self.library = read_json(Library, results / "assets/library/library.json")
        self.options = MatchingConfig()
        self._things: dict[float, list[Thing]] = {}

    @cached_property
    def store(self) -> FeatureStore:
        """Features of the library: those of the results, or made anew."""
        folder = self.results / "matching/features" / self.options.store()
        if folder.is_dir():
            return FeatureStore(sorted(folder.glob("*.npy")), settings_digest(self.options, make_encoder(self.options)))
        paths = []
        for shard in sorted((self.results / "assets/snapshots").glob("*.h5")):
            paths.append(self.folder / shard.with_suffix(".npy").name)
            features(snapshots=shard, out=paths[-1], options=json.dumps(self.options.keep_stored()))
        return FeatureStore(paths, settings_digest(self.options, make_encoder(self.options)))

    def things(self, colour: float) -> list[Thing]:
        """The objects, with a weight of colour."""
        if colour not in self._things:
            self._things[colour] = list(self._make(colour))
        return self._things[colour]

    def _make(self, colour: float) -> Iterator[Thing]:
        encoder = make_encoder(self.options)
        for room in sorted((self.results / "scenes").glob("*/truth.json")):
            truth = read_json(Truth, room)
            eye = np.array(truth.world_from_camera)[:2, 3]
            by_mask = {true.mask: true for true in truth.objects}
            folder = self.results / "extraction" / truth.scene
            scene = Scene(folder / "objects.json", room.parent / "input/rgb.png")
            for item in scene.objects.objects:
                query = make_query(scene.view(item), encoder, colour) if item.status == "ok" else None
                if query is not None and item.mask in by_mask:
                    true = by_mask[item.mask]
                    towards = eye - np.array(true.position)[:2]
                    yaw = true.yaw - float(np.arctan2(towards[1], towards[0]))
                    yield Thing(item, true, yaw, query, self.store)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, nargs="+", required=True)
    folders: list[Path] = parser.parse_args().results
    names = [f"{folder}: {what}" for folder in folders for what in ("category", "model", "yaw 15°", "ranks 2-4")]
    print(f"| options | {' | '.join(names)} | fewest candidates |\n|{'---|' * (len(names) + 2)}")
    with TemporaryDirectory() as temporary:
        rooms: dict[Path, Rooms] = {}
        for name, changed in variants().items():
            options = MatchingConfig.model_validate(changed)
            cells, fewest = [], []
            for number, folder in enumerate(folders):
                place = Path(temporary) / str(number)
                place.mkdir(exist_ok=True)
                each = rooms.setdefault(folder, Rooms(folder, place))
                rows = [thing.match(each.library, options) for thing in each.things(options.colour)]
                cells += [
                    sum(row.category for row in rows),
                    sum(row.model for row in rows),
                    sum(row.yaw for row in rows),
                ]
                cells.append(f"{100 * np.mean([row.others for row in rows]):.0f} %")
                fewest.append(min(row.candidates for row in rows))
            print(f"| {name} | {' | '.join(map(str, cells))} | {min(fewest)} |", flush=True)


if __name__ == "__main__":
    main()
