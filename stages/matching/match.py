"""Command `match`: rank the digital cousins of every object of one scene (paper 2.1, A.6, A.7, B.1)."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from roomkin.stages.cli import progress
from roomkin.stages.config.code import record_provenance
from roomkin.stages.config.matching import MatchingConfig, matching_model
from roomkin.stages.config.packages import find_packages
from roomkin.stages.contracts import Cousins, LeftOut, Library, read_json, read_options, write_json
from roomkin.stages.contracts.cousins import ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import MEND
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.candidates import find_candidates
from roomkin.stages.matching.deciding import agree_on_order, decide_cousins, note_differences
from roomkin.stages.matching.encoders import PatchEncoder, make_encoder, settings_digest
from roomkin.stages.matching.judges import Judges
from roomkin.stages.matching.ranking import make_query, rank_by_priors, rank_models, rank_orientations, shortlist
from roomkin.stages.matching.snapshots import SceneObjects, Snapshots
from roomkin.stages.matching.store import FeatureStore
from roomkin.stages.matching.text_encoders import TextEncoder, make_text_encoder

# What an object's picture is compared with: the encoder, and the features that it made of the library.
Pictures = tuple[PatchEncoder, FeatureStore]


def run(
    *,
    objects: Path,
    image: Path,
    library: Path,
    out: Path,
    features: tuple[Path, ...] = (),
    snapshots: tuple[Path, ...] = (),
    without: tuple[Path, ...] = (),
    options: str = "{}",
) -> None:
    """Write cousins.json.

    Args:
        objects: objects.json of extraction, with masks.png and depth.npz beside it.
        image: the scene's picture.
        library: library.json of the assets stage.
        out: cousins.json to write.
        features: feature stores (.npy) of all shards, or of those that hold the objects' candidates; none if the
            judges look at no picture.
        snapshots: shards of snapshots (.h5), for judges that look at pictures.
        without: files that name models not to be used.
        options: JSON of the config section `matching`.
    """
    settings = read_options(matching_model(find_packages()), options)
    stored = open_pictures(features, settings) if settings.compares_pictures else None
    assets = leave_out(read_json(Library, library), without)
    scene = SceneObjects(objects, image)
    text = make_text_encoder(settings)
    judges = Judges(settings, library, Snapshots(snapshots))
    entries = [
        match_object(item, scene, assets, stored, text, judges, settings)
        for item in progress(scene.objects.objects, "objects matched", len(scene.objects.objects))
    ]
    encoder = settings.encoder if stored else "none"
    items = scene.objects.objects
    pairs = zip(agree_on_order(entries, items), items, strict=True)
    entries = [note_differences(entry, item, assets) for entry, item in pairs]
    wholes = [path.with_suffix(".npz") for path in features]  # of every view as a whole: a store has a gigabyte
    seen = [image, *wholes] if settings.compares_pictures else []
    asked = settings.keep_deciding()
    seed = scene.objects.made.seed if scene.objects.made else None
    origin = record_provenance("roomkin.stages.matching.match", asked, [objects, *seen, library, *without], seed)
    write_json(out, Cousins(scene=scene.objects.scene, encoder=encoder, objects=entries, made=origin))
    for line in (*judges.summaries(), *describe_doubts(entries)):
        print(line)


def describe_doubts(entries: list[ObjectCousins]) -> Iterator[str]:
    """A line for every object whose nearest cousin opens otherwise than was stated, or whose name is not known."""
    for entry in entries:
        if entry.cousins and entry.cousins[0].differs:
            yield f"{entry.id} {entry.cousins[0].differs}: {MEND['affordance']}"
        yield from (f"{entry.id}: {doubt}" for doubt in entry.doubts)


def open_pictures(features: tuple[Path, ...], options: MatchingConfig) -> Pictures:
    """The encoder, and the features that it made of the library."""
    encoder = make_encoder(options)
    return encoder, FeatureStore(features, settings_digest(options, encoder))


def leave_out(library: Library, files: tuple[Path, ...]) -> Library:
    """The library without the models that the files name."""
    gone = {name for file in files for name in read_json(LeftOut, file).assets}
    return library.model_copy(update={"assets": [entry for entry in library.assets if entry.id not in gone]})


def match_object(
    item: SceneObject,
    scene: SceneObjects,
    library: Library,
    stored: Pictures | None,
    text: TextEncoder,
    judges: Judges,
    options: MatchingConfig,
) -> ObjectCousins:
    """The cousins of one object, or the reason why there are none: one bad object does not stop the scene.

    `stored`: what its picture is compared with; None: no picture is looked at.
    """
    if item.status == "failed":
        return _fail_object(item, f"extraction: {item.reason}")
    candidates, view = find_candidates(item, library, text, options), scene.view(item)
    if not candidates.assets:
        return _fail_object(item, "no candidate: the library has no asset with doors or drawers")
    question = judges.question(view, item, scene.objects)
    if stored is None:
        models = rank_by_priors(candidates, item, options)
        facing = Orientation(yaw=0.0, distance=0.0)  # stands for the views, none of which is compared
        return decide_cousins(models, lambda asset: ([], [facing]), candidates, item, question, judges, options)
    encoder, store = stored
    store.check_holds([entry.id for entry in candidates.assets], f"candidates of '{item.label}'")
    query = make_query(view if store.upright else replace(view, up=None), encoder, options.colour)
    if query is None:
        return _fail_object(item, f"no foreground patch: mask {item.mask} has no pixel in masks.png")
    candidates = shortlist(query, candidates, item, store, options)
    models = rank_models(query, candidates, item, store, options)
    orientations_of = partial(rank_orientations, query, store=store, options=options)
    return decide_cousins(models, orientations_of, candidates, item, question, judges, options)


def _fail_object(item: SceneObject, reason: str) -> ObjectCousins:
    return ObjectCousins(id=item.id, label=item.label, status="failed", reason=reason)
