"""Command `distances`: how far the library's articulated models look from those that may be a twin (paper B.4)."""

from pathlib import Path

import numpy as np

from roomkin.stages.config.matching import ComparisonOptions
from roomkin.stages.contracts import Cousins, Library, read_json, read_options, write_json
from roomkin.stages.contracts.cousins import Distances
from roomkin.stages.contracts.scenes import find_true_model
from roomkin.stages.matching.encoders import column_weights, make_encoder, settings_digest
from roomkin.stages.matching.ranking import Query, apply_weights, rank
from roomkin.stages.matching.store import FeatureStore, Snapshot


def run(
    *,
    cousins: Path,
    object: str,
    library: Path,
    features: list[Path],
    out: Path,
    truth: Path | None = None,
    objects: Path | None = None,
    options: str = "{}",
) -> None:
    """Write the embedding distances between representative snapshots that `experiment select` orders assets by.

    The true model of the object, or without a truth any of its cousins, becomes the twin of an experiment, so there is
    a row for each. An object that failed, or that is not there, has none; `experiment select` says what would do
    instead.

    Args:
        cousins: cousins.json of the scene that holds the object.
        object: id of the object, e.g. cabinet_1.
        library: library.json of the assets stage.
        features: feature stores of all shards (.npy).
        out: file to write.
        truth: truth.json of the room, if there is one; nothing is matched by it.
        objects: objects.json of extraction, which says which mask of the truth is which object.
        options: JSON of the config section `matching`.
    """
    settings = read_options(ComparisonOptions, options)
    encoder = make_encoder(settings)
    store = FeatureStore(features, settings_digest(settings, encoder))
    entries = read_json(Library, library).assets
    assets = [entry.id for entry in entries if entry.doors + entry.drawers + entry.buttons]
    store.check_holds(assets, "models that a task is about")
    matched = read_json(Cousins, cousins)
    item = next((entry for entry in matched.objects if entry.id == object), None)
    weights = column_weights(encoder, depth=True)
    cousin_models = [cousin.asset for cousin in (item.cousins if item else [])]
    twins = [one for one in dict.fromkeys([find_true_model(truth, objects, object), *cousin_models]) if one in assets]
    rows = {asset: measure_distances(asset, assets, store, weights, settings) for asset in twins}
    scene, made_by = matched.scene, matched.encoder
    write_json(out, Distances(scene=scene, object=object, encoder=made_by, assets=assets, distances=rows))


def measure_distances(
    asset: str, assets: list[str], store: FeatureStore, weights: np.ndarray, options: ComparisonOptions
) -> list[float]:
    """Embedding distance of one asset's representative snapshot to that of each of `assets`; 0 to itself."""
    view = store.representative
    patches = apply_weights(store.rows(Snapshot(asset, view)), weights)
    query = Query(patches, weights, store.read_wholes(asset, [view])[0])
    ranking = rank(query, [Snapshot(other, view) for other in assets], range(len(assets)), store, options, 1)
    return ranking.distances.tolist()
