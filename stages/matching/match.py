"""Verb `match`: rank the digital cousins of every object of one scene (paper 2.1, A.6, A.7, B.1)."""

from dataclasses import replace
from pathlib import Path

from stages.cli import progress
from stages.config.matching import MatchingConfig
from stages.contracts import Cousins, InputError, LeftOut, Library, read_json, read_options, write_json
from stages.contracts.cousins import ObjectCousins
from stages.contracts.objects import SceneObject
from stages.matching.candidates import find_candidates
from stages.matching.encoders import PatchEncoder, make_encoder, settings_digest
from stages.matching.judges import Judges
from stages.matching.ranking import make_query, rank_cousins, shortlisted
from stages.matching.scene import Scene
from stages.matching.snapshots import Snapshots
from stages.matching.store import FeatureStore
from stages.matching.text_encoders import TextEncoder, make_text_encoder


def run(
    *,
    objects: Path,
    image: Path,
    library: Path,
    features: list[Path],
    out: Path,
    snapshots: tuple[Path, ...] = (),
    without: tuple[Path, ...] = (),
    options: str = "{}",
) -> None:
    """Write cousins.json.

    Args:
        objects: objects.json of extraction, with masks.png and depth.npz beside it.
        image: the scene's picture.
        library: library.json of the assets stage.
        features: feature stores of all shards (.npy).
        out: cousins.json to write.
        snapshots: shards of snapshots (.h5), for judges that look at pictures.
        without: files that name models not to be used.
        options: JSON of the config section `matching`.
    """
    settings = read_options(MatchingConfig, options)
    encoder = make_encoder(settings)
    store = FeatureStore(features, settings_digest(settings, encoder))
    assets = without_models(read_library(library, store), without)
    scene = Scene(objects, image)
    text = make_text_encoder(settings)
    with Snapshots(snapshots) as pictures:
        judges = Judges(settings, library, pictures)
        entries = [
            match_object(item, scene, assets, store, encoder, text, judges, settings)
            for item in progress(scene.objects.objects, "objects matched", len(scene.objects.objects))
        ]
    result = Cousins(scene=scene.objects.scene, encoder=settings.encoder, objects=entries)
    write_json(out, result)
    for line in judges.summaries():
        print(line)


def read_library(path: Path, store: FeatureStore) -> Library:
    """The library, checked to be the one whose features are stored."""
    library = read_json(Library, path)
    missing = [entry.id for entry in library.assets if entry.id not in store]
    if missing:
        what = f"{len(missing)} of {len(library.assets)} assets have no features, e.g. {missing[0]}."
        raise InputError(path, what, "give the feature stores of all shards of this library")
    return library


def without_models(library: Library, files: tuple[Path, ...]) -> Library:
    """The library without the models that the files name."""
    gone = {name for file in files for name in read_json(LeftOut, file).assets}
    return library.model_copy(update={"assets": [entry for entry in library.assets if entry.id not in gone]})


def match_object(
    item: SceneObject,
    scene: Scene,
    library: Library,
    store: FeatureStore,
    encoder: PatchEncoder,
    text: TextEncoder,
    judges: Judges,
    options: MatchingConfig,
) -> ObjectCousins:
    """The cousins of one object, or the reason why there are none: one bad object does not stop the scene."""
    if item.status == "failed":
        return _failed(item, f"extraction: {item.reason}")
    view = scene.view(item)
    query = make_query(view if store.upright else replace(view, up=None), encoder, options.colour)
    if query is None:
        return _failed(item, f"no foreground patch: mask {item.mask} has no pixel in masks.png")
    candidates = find_candidates(item, library, text, options)
    if not candidates.assets:
        return _failed(item, "no candidate: the library has no asset with doors or drawers")
    question = judges.question(view, item, scene.objects)
    candidates = shortlisted(query, candidates, store, options)
    return rank_cousins(query, candidates, item, question, store, judges, options)


def _failed(item: SceneObject, reason: str) -> ObjectCousins:
    return ObjectCousins(id=item.id, label=item.label, status="failed", reason=reason)
