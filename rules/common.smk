# Helpers: the validated config, options and code digests of each job, commands, paths. Nothing here makes a file.
import json
import os
import shlex
import sys
from hashlib import sha256
from itertools import chain
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.settings.types import ExecMode

from stages.config.code import code_digest, cover, files_digest
from stages.config.model import load
from stages.config.names import modules
from stages.config.outside import outside
from stages.config.reads import options_of, stores
from stages.contracts.errors import InputError
from stages.plugins import qualified
from stages.scenes.rooms import series
from stages.guard import hold_folder, makes_files

# `.venv/bin/snakemake` works without activating the environment: jobs find its python first.
os.environ.update(PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]))

# As for `python -m`, packages of the user may lie in the working directory.
sys.path.append(os.getcwd())

try:
    CONFIG = load(config)
    cover(CONFIG.plugins)
    if workflow.exec_mode == ExecMode.DEFAULT and not workflow.output_settings.dryrun and makes_files(sys.argv):
        LOCKED = hold_folder()
except InputError as error:
    raise WorkflowError(str(error)) from None

os.environ.update(ACDC_OUTSIDE="\n".join(outside(CONFIG)))  # containers/podman-shell mounts them
EXPERIMENT = CONFIG.experiment
ROOMS = EXPERIMENT.rooms
SCORED_ROOMS = [room for room in ROOMS if room not in EXPERIMENT.inputs]
VARIANTS = list(EXPERIMENT.variants)
TASKS = list(EXPERIMENT.tasks)
SHARDS = list(range(CONFIG.assets.shards))
RANKS = list(range(1, CONFIG.generation.ranks + 1))
STORES = stores(CONFIG)


wildcard_constraints:
    scene=r"[A-Za-z0-9-]+(_[A-Za-z0-9-]+)*",
    variant=r"[A-Za-z0-9_-]+",
    store=r"[A-Za-z0-9_]+-[0-9a-f]{8}",
    task="|".join(TASKS) or "-",
    object=r"[^/]+",
    role=r"twin|cousin_\d+",
    training_set=r"twin|cousins_\d+|all",
    run=r"[A-Za-z0-9_-]+",
    seed=r"\d+",
    shard=r"\d+",


def options(stage, verb):
    """The --options of a verb, as JSON: what it reads of the config and no more, so that no other change runs it."""
    return lambda wildcards: json.dumps(options_of(CONFIG, stage, verb, dict(wildcards)), sort_keys=True)


def config_digest():
    """Digest of the whole validated config, for the report."""
    return sha256(CONFIG.model_dump_json().encode()).hexdigest()[:12]


def command(stage, verb):
    """The command line of a verb: ours, or the user's own if it is replaced."""
    own = CONFIG.stages.get(stage, {}).get(verb)
    return own.command if own else f"python -m stages.{stage} {verb}"


def code(stage, verb, *used):
    """Digest of the code behind a verb and of the implementations it uses: an edit re-runs what uses it."""
    own = CONFIG.stages.get(stage, {}).get(verb)
    return files_digest(own.code) if own else code_digest(f"stages.{stage}.{verb}", *used)


def check(**outputs):
    """The command that refuses what breaks its contract, keeping it aside; `outputs`: kind of file = its output."""

    def line(wildcards, output):
        files = {kind: getattr(output, name) for kind, name in outputs.items()}
        named = [[kind, *([file] if isinstance(file, str) else file)] for kind, file in files.items()]
        return shlex.join(["python", "-m", "stages.contracts", "--refuse", *chain(*named)])

    return line


def task_code(stage, verb):
    """The code of a verb that works on a task."""
    return lambda wildcards: code(stage, verb, qualified("tasks", CONFIG.implementation("tasks", wildcards.task)))


def rollout_code(wildcards):
    """The code of rollouts: of the task and of the policy."""
    task = qualified("tasks", CONFIG.implementation("tasks", wildcards.task))
    return code("evaluation", "rollout", task, *modules(CONFIG.training.runs[wildcards.run], "policy"))


def matching_code(verb, *keys):
    """The code of a verb of matching with the implementations that some keys name."""
    return lambda wildcards: code("matching", verb, *modules(CONFIG.matching_of(wildcards.variant), *keys))


def features_of(variant):
    """The feature store that a variant uses, shard by shard."""
    store = CONFIG.matching_of(variant).store()
    return [f"results/matching/features/{store}/shard_{shard}.npy" for shard in SHARDS]


def own_room(wildcards):
    """The flag that names the file of a room of the user's."""
    path = CONFIG.room_files().get(wildcards.scene)
    return "" if path is None or path in series() else f"--room {shlex.quote(str(path))}"


def recipes_digest(wildcards):
    """Digest of what a room is made by: its own recipe and, for ours, those before it."""
    path, ours = CONFIG.room_files().get(wildcards.scene), series()
    used = ours[: ours.index(path) + 1] if path in ours else [path] if path else []
    return sha256(b"\0".join(file.read_bytes() for file in used)).hexdigest()[:12]


def filmed(stage, verb, folder, **labels):
    """Films of episodes as outputs of our own verb; a command in its place need not make any."""
    if verb in CONFIG.stages.get(stage, {}):
        return {}
    caption, category = "../report/captions/demos.rst", {"collect": "Demonstrations", "rollout": "Rollouts"}[verb]
    return {
        "film": report(f"{folder}/film.png", caption=caption, category=category, labels=labels),
        "films": directory(f"{folder}/films"),
    }


def scene_inputs(wildcards):
    """The files of a scene's input folder: rendered for rooms, the user's own for `experiment.inputs`."""
    own = EXPERIMENT.inputs.get(wildcards.scene)
    folder = own or f"results/scenes/{wildcards.scene}/input"
    return {
        "rgb": f"{folder}/rgb.png",
        "camera": f"{folder}/camera.json",
        "depth": f"{folder}/depth.npz",
        "masks": f"{folder}/masks.png",
        "annotations": f"{folder}/annotations.json",
    }


def scene_image(wildcards):
    """The scene's picture."""
    return scene_inputs(wildcards)["rgb"]


def policy_folders(task, parent):
    """Folders of all policies of a task below `parent`, one per training set, run and seed."""
    return expand(
        f"{parent}/{task}/{{training_set}}/{{run}}/seed_{{seed}}",
        training_set=EXPERIMENT.training_sets,
        run=EXPERIMENT.runs,
        seed=EXPERIMENT.seeds,
    )


def of_target(wildcards, pattern):
    """The file of `pattern` for a task's object or for the scene that holds it."""
    target = EXPERIMENT.tasks[wildcards.task]
    return expand(pattern, variant=wildcards.variant, scene=target.scene, object=target.object)


def task_assets(task):
    """The file that names the assets of a task's policy experiment."""
    return f"results/experiment/{EXPERIMENT.policy_variant}/{task}/assets.json"
