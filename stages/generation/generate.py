"""Verb `generate`: cousins + objects -> one scene per rank, with its physics check."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from stages.cli import progress
from stages.config.generation import GenerationConfig
from stages.config.made import made
from stages.contracts import InputError, read_options, write_json
from stages.generation.choosing import choose
from stages.generation.collisions import resolve
from stages.generation.doubts import doubts
from stages.generation.inputs import Inputs, read_inputs
from stages.generation.models import resize, write_models
from stages.generation.placed import Placed
from stages.generation.placing import place
from stages.generation.scene_file import scene_of, summary
from stages.generation.settling import physics_check
from stages.generation.stacking import stacked


def run(
    *,
    cousins: Path,
    objects: Path,
    library: Path,
    variant: str,
    out: Path,
    options: str = "{}",
    corrections: tuple[Path, ...] = (),
) -> None:
    """Make the scenes of one picture.

    Args:
        cousins: cousins.json of matching.
        objects: objects.json of extraction; clouds.npz lies beside it.
        library: library.json.
        variant: name of the matching variant, written into the scenes.
        out: folder; gets scene_<rank>.json of every rank.
        options: JSON of the config section `generation`.
        corrections: corrections.json beside the picture: which models a person chose, and what they moved.
    """
    config = read_options(GenerationConfig, options)
    inputs = read_inputs(cousins, objects, library, corrections)
    scenes = []
    for rank in progress(range(1, config.ranks + 1), "scenes", config.ranks):
        built = build(inputs, rank, config)
        if not built.items:
            what = "has no object that could be placed."
            raise InputError(objects, what, "see the reasons in it and in cousins.json", code="E-SCENE-EMPTY")
        with TemporaryDirectory(prefix="acdc-sized-") as folder:
            items = write_models(built.items, Path(folder))
            settled = physics_check(items, inputs.objects, len(built.left), config)
        scenes.append(scene_of(built.items, built.failed, settled, inputs.objects, variant, rank))
        print(summary(scenes[-1], built.left))
    seed = inputs.objects.made.seed if inputs.objects.made else None
    origin = made("stages.generation.generate", config, [cousins, objects, library, *corrections], seed)
    for scene in scenes:
        write_json(out / f"scene_{scene.rank}.json", scene.model_copy(update={"made": origin}))


@dataclass(frozen=True)
class Built:
    """Placed objects; `failed`: id -> reason of the others; `left`: pairs that still overlap."""

    items: list[Placed]
    failed: dict[str, str]
    left: list[tuple[str, str]]


def build(inputs: Inputs, rank: int, options: GenerationConfig) -> Built:
    """The cousins of one rank in their places: chosen, placed, resized, stacked and freed from collisions.

    An object that fails is left out, with its reason.
    """
    room, items, failed = inputs.objects, list[Placed](), dict[str, str]()
    models: dict[int, str] = {}
    for one in inputs.matched:
        try:
            item = choose(one, rank, models, partial(place, one, inputs=inputs, options=options), options.max_stretch)
            models[one.object.mask] = item.asset.id
            items.append(resize(item))
        except InputError as error:
            failed[one.object.id] = error.what
    supports = {item.id: item.support for item in room.objects if item.support}
    items = stacked(items, supports, {one.object.id: one.correction.nudge for one in inputs.matched}, options)
    freed = resolve(items, room.walls, options)
    seen = {item.id: item for item in room.objects}
    items = [
        replace(item, doubts=(*item.doubts, *doubts(item, room.walls, seen[item.id], inputs.categories)))
        for item in freed.items
    ]
    return Built(items, failed, freed.left)
