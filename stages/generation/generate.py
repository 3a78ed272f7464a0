"""Command `generate`: cousins + objects -> one scene per rank, with its physics check."""

from pathlib import Path

from roomkin.stages.cli import progress
from roomkin.stages.config.code import record_provenance
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import InputError, read_options, write_json
from roomkin.stages.generation.collisions import resolve_collisions
from roomkin.stages.generation.inputs import read_inputs
from roomkin.stages.generation.placing import Places, choose_models
from roomkin.stages.generation.scene_file import doubt_placements, summarise, to_contract
from roomkin.stages.generation.settling import simulate
from roomkin.stages.generation.stacking import assign_supports


def run(
    *,
    cousins: Path,
    objects: Path,
    library: Path,
    variant: str,
    out: Path,
    options: str = "{}",
    corrections: tuple[Path, ...] = (),
    input: Path | None = None,
    image: tuple[Path, ...] = (),
) -> None:
    """Make the scenes of one picture.

    Args:
        cousins: cousins.json of matching.
        objects: objects.json of extraction; clouds.npz lies beside it.
        library: library.json.
        variant: name of the matching variant, written into the scenes.
        out: folder; gets scene_<rank>.json of every rank.
        options: JSON of the config section `generation`.
        corrections: corrections.json of the picture: which models a person chose, and what they moved.
        input: the picture's folder, with whose masks corrections are matched.
        image: the picture, which `finish: picture` needs; without any `finish` its colors are those of the cousins.
    """
    config = read_options(GenerationConfig, options)
    image = () if config.finish == "library" else image
    if config.finish == "picture" and not image:
        raise InputError("--image", "is needed by `finish: picture`.", "give the picture", code="E-OPTION-MISSING")
    inputs = read_inputs(cousins, objects, library, corrections, input, *image)
    scenes, places = [], Places(inputs, config)
    for rank in progress(range(1, config.ranks + 1), "scenes", config.ranks):
        items, failed = choose_models(inputs, rank, places)
        if not items:
            what = "has no object that could be placed."
            raise InputError(objects, what, "see the reasons in it and in cousins.json", code="E-SCENE-EMPTY")
        stacked = assign_supports(items, inputs.supports, inputs.nudges, config, inputs.categories)
        freed = resolve_collisions(stacked, inputs.objects.walls, config)
        doubted = doubt_placements(freed.items, inputs)
        settled = simulate(doubted, inputs.objects, len(freed.left), config)
        scenes.append(to_contract(doubted, failed, settled, inputs.objects, variant, rank))
        print("\n".join(summarise(scenes[-1], freed.left)))
    seed = inputs.objects.made.seed if inputs.objects.made else None
    origin = record_provenance(
        "roomkin.stages.generation.generate", config, [cousins, objects, library, *corrections, *image], seed
    )
    for scene in scenes:
        write_json(out / f"scene_{scene.rank}.json", scene.model_copy(update={"made": origin}))
