# Helpers: the config, the names that rules expand over, the parameters of a rule that runs a command. No rules.
import json
import os
import shlex
import sys
from collections import defaultdict
from functools import cache
from hashlib import sha256
from itertools import product
from pathlib import Path

from roomkin.stages.config.code import cover, files_digest, path_of_jobs
from roomkin.stages.config.commands import check_line, command_digest, command_line, replacement
from roomkin.stages.config.files import read_file
from roomkin.stages.config.model import load, with_defaults
from roomkin.stages.config.packages import check_rules, check_targets, list_drawers, rule_files, shards_of
from roomkin.stages.config.reads import READS, WILDCARDS as OPTION_WILDCARDS, describe_picture, options_of, stores
from roomkin.stages.config.commands import fill_counts
from roomkin.stages.config.weights import tell_left_out
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.system import check_writable
from roomkin.stages.contracts.policy_config import ROLE_NAME, SET_NAME

# `.venv/bin/snakemake` works without activating the environment: jobs find its python first.
os.environ.update(PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]))

# As for `python -m`, packages of the user may lie in the working directory.
sys.path.append(os.getcwd())

try:
    check_writable(Path.cwd(), *map(Path, ("results", "logs", "benchmarks", ".snakemake")))
    list(map(read_file, map(Path, workflow.configfiles)))
    CONFIG = load(with_defaults(config))
    if workflow.is_main_process and (line := tell_left_out(with_defaults(config), CONFIG)):
        print(line, file=sys.stderr)
    check_targets(sys.argv, CONFIG.packages, CONFIG.image)
    check_rules(sys.argv if workflow.is_main_process else [], workflow.main_snakefile)
    cover(CONFIG.plugins)
    if CONFIG.plugins:
        os.environ.update(PYTHONPATH=path_of_jobs(CONFIG.plugins, Path.cwd()))
    OWN_SHARDS = shards_of(CONFIG)
    LIBRARY_SIZE = sum(CONFIG.assets.counts.values()) + sum(len(shard.models) for shard in OWN_SHARDS.values())
    CONFIG = fill_counts(CONFIG, LIBRARY_SIZE)
    if workflow.is_main_process and len(CONFIG.experiment.rooms) == 1 and "perception" not in CONFIG.stages:
        from roomkin.stages.perception.read.early import check_pictures

        check_pictures(CONFIG.experiment)
except InputError as error:
    print(f"error: {error} [{error.code}]", file=sys.stderr)  # one line: Snakemake would add this file and its line
    sys.exit(1)

# Snakemake keeps copies of what `workflow.source_path` names, in a folder of its own.
PUBLISHED = str(Path([workflow.source_path(f"../report/published/table{n}.csv") for n in (2, 3)][0]).resolve().parent)
os.environ.update(ACDC_PAPER=PUBLISHED)


def columns(*names, rows):
    """Rows as lists by name, for `expand(pattern, zip, **columns)`."""
    return {name: [row[index] for row in rows] for index, name in enumerate(names)}


EXPERIMENT = CONFIG.experiment
# Rooms and pictures of the user's; those whose truth is known; those that the report shows: of many pictures eight.
ROOMS = EXPERIMENT.rooms
SCORED_ROOMS = [room for room in ROOMS if room not in EXPERIMENT.inputs]
FURTHER_ROOMS = set([room for room in ROOMS if room in EXPERIMENT.inputs][8:])
REPORT_ROOMS = [room for room in ROOMS if room not in FURTHER_ROOMS]
# Variants, and that of the policy experiment; perturbed rooms, each with its variants.
VARIANTS = list(EXPERIMENT.variants)
MATCHING = {variant: CONFIG.matching_of(variant) for variant in VARIANTS}
POLICY_VARIANT = EXPERIMENT.policy_variant
PERTURBED_SCENES = [(scene, variant) for scene, named in EXPERIMENT.perturbed_scenes().items() for variant in named]
PERTURBED_SCENES = columns("scene", "variant", rows=PERTURBED_SCENES)
RANKS = list(range(1, CONFIG.generation.ranks + 1))
# Shards of the procedural models, or of what a command of the user's makes in their place; then of the user's models.
PROCEDURAL = any(CONFIG.assets.counts.values()) or any("library" in own for own in CONFIG.stages.values())
PROCEDURAL_SHARDS = list(range(CONFIG.assets.shards)) if PROCEDURAL else []
SHARDS = [*PROCEDURAL_SHARDS, *OWN_SHARDS]
# The picture of a run of one: parts of the library are drawn for it, as far as our own `match` looks.
PICTURE = ROOMS[0] if len(ROOMS) == 1 and ROOMS[0] in EXPERIMENT.inputs else None
PICTURE = None if replacement(CONFIG, "matching", "match") else PICTURE
STORES = stores(CONFIG)
# What policies open; on which assets it is demonstrated; who opens it after what training.
TARGETS = list(EXPERIMENT.targets)
TRAINED_TARGETS = [name for name in TARGETS if EXPERIMENT.sets_of(name)]
DEMONSTRATED = [(name, role) for name in TARGETS for role in EXPERIMENT.list_trained_roles(name)]
DEMONSTRATED = columns("target", "role", rows=DEMONSTRATED)
CELLS = columns("target", "policy", "training_set", rows=EXPERIMENT.cells)
# Modules that film demonstrations and rollouts, by stage. What packages add to Table 3: modules, the table of trainings that they read.
FILMS = {stage: list_drawers(CONFIG.packages, stage) for stage in ("demonstrations", "evaluation")}
MORE_TABLES = list_drawers(CONFIG.packages, "tables")
TRAININGS = ["results/tables/trainings.csv"] if MORE_TABLES else []
# Files of assets that the user has committed, by target.
PINNED = {name: target.assets for name, target in EXPERIMENT.targets.items() if target.assets}
# Files that packages beside the core add to a target, by its name: `ADDED["extraction"] += ...` in their rules.smk.
ADDED = defaultdict(list)


def added(target):
    """Files that packages add, once all their rules are read."""
    return lambda wildcards: ADDED[target]


wildcard_constraints:
    room=r"[A-Za-z0-9-]+(_[A-Za-z0-9-]+)*",
    protocol="|".join(EXPERIMENT.protocols) or "-",
    seed=r"\d+",
    scene=r"[^/._]+(_[^/._]+)*(\.(" + "|".join(EXPERIMENT.protocols) + r")\.\d+)?",
    variant=r"[A-Za-z0-9_-]+",
    shard=r"\d+|own_\w+|part_[0-9a-f]+",
    store=r"[A-Za-z0-9_]+-[0-9a-f]{8}",
    object=r"[^/]+",
    target="|".join(TARGETS) or "-",
    role=ROLE_NAME,
    policy="|".join(EXPERIMENT.policies) or "-",
    training_set=SET_NAME,
    run=r"[A-Za-z0-9_-]+",
    condition="|".join(CONFIG.evaluation.conditions) or "-",


def command(stage, name, uses=(), options=None, **outputs):
    """What runs a command, as parameters: `command`, a digest of its `code`, its `options`, a `check` of its outputs.

    uses: modules of implementations whose code counts as well, or a function of wildcards that gives them.
    options: a function of wildcards, in the place of what the command reads of the config.
    outputs: contract = output, of those that are checked.
    """

    def code(wildcards):
        return command_digest(CONFIG, stage, name, *uses(wildcards))

    def check(wildcards, output):
        return check_line({contract: getattr(output, key) for contract, key in outputs.items()})

    found = {"command": command_line(CONFIG, stage, name)}
    found["code"] = code if callable(uses) else command_digest(CONFIG, stage, name, *uses)
    if options or (stage, name) in READS:
        found["options"] = options or read_options(stage, name)
    return found | ({"check": check} if outputs else {})


def read_options(stage, name):
    """The --options of a command, as JSON: what it reads of the config and no more, so that no other change runs it."""

    @cache
    def read(**wildcards):
        return json.dumps(options_of(CONFIG, stage, name, wildcards), sort_keys=True)

    def options(wildcards):
        given = {key: value for key, value in wildcards.items() if key in OPTION_WILDCARDS}
        if "scene" in given:  # only its protocol counts
            given["scene"] = "".join(given["scene"].partition(".")[1:])
        return read(**given)

    return options


def unless_replaced(stage, name, **outputs):
    """Outputs for people, of our own command: the user's in its place need not make them, nor a run without films."""
    return outputs if FILMS.get(stage, True) and not replacement(CONFIG, stage, name) else {}


def paper(table):
    """Digest of a table of the paper's values, for the rules that read its copy in PUBLISHED."""
    return sha256(Path(PUBLISHED, f"{table}.csv").read_bytes()).hexdigest()[:12]
