"""All patch encoders on one task: find the category, the model and the turn of models in pictures they never saw.

    python -m plugins.patchnet.benchmark [--models 4] [--queries 2] [--encoders hog patchnet] [--dinov2 FOLDER]

Makes a small library of its own (other models than any library and any training), photographs it as `snapshots` does,
and asks for every model twice: in other light, colours and proportions, from other heights and distances, partly
hidden, with rendered depth that was made worse, and without depth. Prints the tables of docs/results/matching.md. One
thread.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.furniture.catalogue import CATEGORIES
from plugins.patchnet.encoders.patchnet import Weights
from plugins.patchnet.network import seen_categories
from plugins.patchnet.training.pairs import blemish_picture, hide_part
from plugins.patchnet.training.render import MODELS, PAINTED, make
from plugins.patchnet.training.studio import ChanceStudio
from stages.assets.snapshots import Turntable
from stages.config.assets import SnapshotOptions
from stages.config.matching import Dinov2Config, EncoderOptions, HogConfig, MatchingConfig
from stages.contracts.section import Section
from stages.geometry.frames import angle_difference
from stages.matching.crop import View
from stages.matching.encoders import PatchEncoder, Patches, make_encoder
from stages.matching.snapshots import up_of_camera
from stages.matching.voting import embedding_distance

YAWS = SnapshotOptions().n_snap
STEP = 4  # every fourth of them is compared to find the model
WORST = MatchingConfig().exclude_worst
FRONT = 1.75  # radians: furniture is not seen from behind
HEADING = "| encoder | category | in 3 | model | in 3 | yaw median | within 15 | ms |\n" + "|---" * 8 + "|"
Rng = np.random.Generator


@dataclass(frozen=True)
class Model:
    """One model: its snapshots at YAWS turns, and pictures of it at other turns."""

    category: str
    symmetry: str
    snapshots: list[View]
    pictures: list[View]
    yaws: list[float]


@dataclass(frozen=True)
class Answer:
    """What one picture was taken for; `turn` (radians) is None for what looks the same from everywhere."""

    category: str
    category_1: bool
    category_3: bool
    model_1: bool
    model_3: bool
    turn: float | None


def models(categories: Sequence[str], count: int, queries: int, seed: int) -> Iterator[Model]:
    """The library, one model after the other."""
    turntable, studio, options = Turntable(SnapshotOptions()), ChanceStudio(), SnapshotOptions()
    up = up_of_camera(float(np.arctan2(options.camera_height, options.camera_distance)))
    yaws = [2 * np.pi * k / YAWS for k in range(YAWS)]
    for category in categories:
        for index in range(count):
            rng = np.random.default_rng(np.random.SeedSequence((seed, *category.encode(), index)))
            with tempfile.TemporaryDirectory() as scratch:
                folder = Path(scratch) / "model"
                asset = make(category, index, seed + MODELS, folder)
                make(category, index, seed + MODELS, Path(scratch) / "again", rng)
                rgbs, depths = turntable.photograph(folder, yaws)
                turns = rng.uniform(-FRONT, FRONT, queries).tolist()
                shots = studio.photograph(Path(scratch) / "again", turns, rng, PAINTED)
            snapshots = [
                View(rgb, depth > 0, depth.astype(np.float32) / 1000, turntable.intrinsics, up)
                for rgb, depth in zip(rgbs, depths, strict=True)
            ]
            pictures = [
                degrade_picture(hide_part(shot.view, rng) if rng.random() < 0.5 else shot.view, rng) for shot in shots
            ]
            yield Model(category, asset.symmetry, snapshots, pictures, turns)


def degrade_picture(view: View, rng: Rng) -> View:
    """A picture as a camera takes it; depth as a network might tell it: another scale, smooth errors, soft edges."""
    assert view.depth is not None
    coarse = cv2.resize(rng.normal(0, 0.01, (6, 6)).astype(np.float32), view.mask.shape[::-1])
    depth = cv2.blur(view.depth, (3, 3)) * rng.uniform(0.7, 1.4) * (1 + coarse)
    return replace(view, rgb=blemish_picture(view.rgb, rng), depth=np.where(view.mask, depth, 0).astype(np.float32))


def weigh_rows(patches: Patches, weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Rows (P, D) to compare."""
    rows = np.concatenate([patches.features, patches.positions], axis=1)
    return rows[:, weights > 0] * weights[weights > 0]


def table(query: NDArray[np.float32], views: list[NDArray[np.float32]]) -> NDArray[np.float64]:
    """(Q, C) distance of each patch of the query to the nearest patch of each view."""
    rows = np.concatenate(views)
    starts = np.cumsum([0] + [len(view) for view in views[:-1]])
    squared = (query**2).sum(1)[:, None] - 2 * query @ rows.T + (rows**2).sum(1)
    return np.sqrt(np.maximum(np.minimum.reduceat(squared, starts, axis=1), 0.0))


@dataclass(frozen=True)
class Encoded:
    """The patches of all snapshots and pictures of a library, and the CPU milliseconds that a snapshot took."""

    snapshots: list[list[Patches]]
    pictures: list[list[Patches]]
    cost: float


def encode_all(library: list[Model], encoder: PatchEncoder) -> Encoded:
    """Everything, once: weights are laid on later."""
    start = time.process_time()
    snapshots = [encoder.encode(model.snapshots) for model in library]
    cost = (time.process_time() - start) / (len(library) * YAWS) * 1e3
    return Encoded(snapshots, [encoder.encode(model.pictures) for model in library], cost)


def classify_pictures(library: list[Model], patches: Encoded, weights: NDArray[np.float32]) -> list[Answer]:
    """What every picture is taken for by patches with these weights."""
    views = [[weigh_rows(each, weights) for each in model] for model in patches.snapshots]
    compared = [view for each in views for view in each[::STEP]]
    owner = np.repeat(np.arange(len(library)), len(range(0, YAWS, STEP)))
    found = []
    for number, model in enumerate(library):
        for picture, yaw in zip(patches.pictures[number], model.yaws, strict=True):
            query = weigh_rows(picture, weights)
            distances = np.full(len(library), np.inf)
            np.minimum.at(distances, owner, embedding_distance(table(query, compared), WORST))
            order = np.argsort(distances, kind="stable")
            categories = list(dict.fromkeys(library[k].category for k in order))[:3]
            first = [k for k in order if library[k].category in categories][:3]
            turn = int(embedding_distance(table(query, views[number]), WORST).argmin()) * 2 * np.pi / YAWS
            gap = None if model.symmetry == "full" else angle_difference(turn, yaw, model.symmetry)
            right = model.category == categories[0], model.category in categories
            found.append(Answer(model.category, *right, number == first[0], number in first, gap))
    return found


def row(found: list[Answer]) -> str:
    """The shares in percent, the median error of the turn in degrees, and how many are within 15."""
    turns = np.degrees([each.turn for each in found if each.turn is not None])
    shares = [
        100 * np.mean([getattr(each, name) for each in found])
        for name in ("category_1", "category_3", "model_1", "model_3")
    ]
    yaw = f"{np.median(turns):.1f} | {100 * (turns <= 15).mean():.0f}" if len(turns) else "- | -"
    return " | ".join([f"{share:.1f}" for share in shares]) + f" | {yaw}"


def variants(name: str, dinov2: str) -> dict[str, EncoderOptions]:
    """Rows of an encoder and its options, which differ in weights alone."""
    alone = Weights(hog=0, normals=0, position=0, position_alone=0)
    lighter = Weights(hog=0.5, normals=1, position=1, position_alone=0.6)
    known: dict[str, dict[str, Section]] = {
        "hog": {"hog: gradients alone": HogConfig(normals=0, position_alone=0), "hog": HogConfig()},
        "dinov2": {"dinov2": Dinov2Config(path=dinov2)} if dinov2 else {},
    }
    if name == "patchnet":
        module = "plugins.patchnet.encoders.patchnet"
        rows = {"patchnet: the network alone": alone, "patchnet: lighter hog": lighter, "patchnet": Weights()}
        return {title: EncoderOptions(encoder=module, own={name: each.model_dump()}) for title, each in rows.items()}
    return {
        title: EncoderOptions.model_validate({"encoder": name, name: options}) for title, options in known[name].items()
    }


def compare_rows(library: list[Model], names: Sequence[str], dinov2: str) -> dict[str, tuple[list[Answer], float]]:
    """Answers and cost by row."""
    results = {}
    for name in names:
        rows = variants(name, dinov2)
        patches = encode_all(library, make_encoder(next(iter(rows.values())))) if rows else None
        for title, options in rows.items():
            encoder = make_encoder(options)
            with_depth, without = encoder.weights(True), encoder.weights(False)
            assert patches is not None
            results[title] = classify_pictures(library, patches, without), patches.cost
            if not np.array_equal(with_depth, without):
                results[f"{title}, depth"] = classify_pictures(library, patches, with_depth), patches.cost
    return results


def main() -> None:
    """Print a table per set of categories."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=int, default=4, help="models per category")
    parser.add_argument("--queries", type=int, default=2, help="pictures per model")
    parser.add_argument("--categories", nargs="*", default=list(CATEGORIES))
    parser.add_argument("--encoders", nargs="*", default=["hog", "patchnet", "dinov2"])
    parser.add_argument("--dinov2", default="", help="folder with a DINOv2; without it it is left out")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    library = list(models(given.categories, given.models, given.queries, given.seed))
    print(f"{len(library)} models in {len(given.categories)} categories, {len(library) * given.queries} pictures\n")
    results = compare_rows(library, given.encoders, given.dinov2)
    seen = set(seen_categories())
    chosen = {
        "All": given.categories,
        "Categories that patchnet saw": [each for each in given.categories if each in seen],
        "Categories that it never saw": [each for each in given.categories if each not in seen],
    }
    for title, categories in chosen.items():
        print(f"{title} ({len(categories)}):\n\n{HEADING}")
        for name, (found, cost) in results.items():
            kept = [each for each in found if each.category in categories]
            if kept:
                print(f"| {name} | {row(kept)} | {cost:.1f} |")
        print()


if __name__ == "__main__":
    main()
