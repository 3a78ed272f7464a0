# Helpers: what stands in the paths that a job reads, where the config says it. Functions of a job's wildcards. No rules.
from snakemake.io import IOFile
from snakemake.persistence import RECORD_FORMAT_VERSION
from snakemake.settings.types import RerunTrigger
from roomkin.stages.config.targets import Cell
from roomkin.stages.config.code import code_digest
from roomkin.stages.config.other_pictures import are_taken_back, describe_corrections, drawing_of, hand_file
from roomkin.stages.contracts.hand import CORRECTIONS
from roomkin.stages.plugins import find, qualify_module


def input_file(name):
    """A file of a scene's input folder: rendered for rooms, the user's own for `experiment.inputs`."""
    return lambda wildcards: f"{EXPERIMENT.input_folder(wildcards.scene)}/{name}"


def picture_config(wildcards):
    """The config.yaml beside a picture of the user's, with options of extraction for that picture."""
    own = EXPERIMENT.inputs.get(wildcards.scene)
    path = Path(own.place(wildcards.scene), "config.yaml") if own and not own.alone else None
    return [str(path)] if path and (not own.folder or path.is_file()) else []


def corrections(stage):
    """A person's corrections of a scene, as far as a stage reads them, as text."""
    return lambda wildcards: describe_corrections(EXPERIMENT, wildcards.scene, stage)


def corrections_file(stage, made):
    """That file, if the stage reads anything there; its age counts where Snakemake does not compare what it says."""

    def file(wildcards):
        version = workflow.persistence.record_format_version(IOFile(made.format(**wildcards)))
        compared = RerunTrigger.PARAMS in workflow.rerun_triggers and version == RECORD_FORMAT_VERSION
        path = str(hand_file(EXPERIMENT, wildcards.scene, CORRECTIONS))
        read = corrections(stage)(wildcards) or (not compared and are_taken_back(path))
        return [ancient(path) if compared else path] if read else []

    return file


def noise_seed(wildcards):
    """The seed of a scene's depth noise."""
    seed = EXPERIMENT.scene(wildcards.scene).seed
    return CONFIG.seed if seed is None else seed


def store_of_variant(wildcards):
    """The feature store that a variant uses."""
    return MATCHING[wildcards.variant].store()


def scene_shards(wildcards):
    """The shards of a scene's models: all; of a picture alone in its run those that hold its objects' candidates.

    For these Snakemake waits for the checkpoint.
    """
    if wildcards.scene != PICTURE:
        return SHARDS
    named = []
    for variant in [wildcards.variant] if "variant" in wildcards.keys() else VARIANTS:
        with checkpoints.shards.get(variant=variant, scene=PICTURE).output.shards.open() as file:
            named += json.load(file)["shards"]
    return list(dict.fromkeys(named))


def compared_shards(wildcards):
    """Those whose pictures a variant compares with an object's: none if it compares no pictures."""
    return scene_shards(wildcards) if MATCHING[wildcards.variant].compares_pictures else []


def known_scene(wildcards):
    """The scene in whose picture the scene, or the room of the target, is seen; none if its truth is not known."""
    scene = target_room(wildcards) if "target" in wildcards.keys() else wildcards.scene
    return [] if scene in EXPERIMENT.inputs else EXPERIMENT.picture_of(scene)


def truth_flags(wildcards, input):
    """The truth of that scene, and the objects that were found in it."""
    return shlex.join(["--truth", str(input.truth), "--objects", str(input.objects)]) if input.truth else ""


def target_room(wildcards):
    """The room that holds a target's object."""
    return EXPERIMENT.targets[wildcards.target].room


def target_object(wildcards):
    """That object."""
    return EXPERIMENT.targets[wildcards.target].object


def task(wildcards):
    """The implementation of a target's task."""
    return CONFIG.implementation("tasks", EXPERIMENT.task(wildcards.target))


def task_options(wildcards):
    """Its options, as JSON."""
    return CONFIG.task_of(wildcards.target).model_dump_json()


def trained_roles(wildcards):
    """The assets whose demonstrations a policy learns from."""
    return EXPERIMENT.roles(wildcards.training_set, int(wildcards.seed))


def policies_of(cell, pattern, **values):
    """The files of `pattern` for the policies of a cell, one per run and seed; `values`: of other wildcards.

    If its runs must be chosen first, Snakemake waits for the checkpoint.
    """
    plan = EXPERIMENT.plan(cell.policy)
    runs = plan.configs
    if EXPERIMENT.needs_choice(cell.policy):
        with checkpoints.choose.get(**cell._asdict()).output.chosen.open() as file:
            runs = json.load(file)["runs"]
    return expand(pattern, **cell._asdict(), run=runs, seed=plan.seeds, **values)


def policies(pattern, count=None):
    """The files of `pattern` for all policies of this run; `count`: of each cell, the first seed and best run first."""
    return lambda wildcards: [file for cell in EXPERIMENT.cells for file in policies_of(cell, pattern)[:count]]
