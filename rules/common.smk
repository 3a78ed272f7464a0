# Helpers: the validated config, options and code digests of each job, commands. Nothing here makes a file.
import atexit
import gc
import json
import os
import shlex
import sys
from functools import cache
from hashlib import sha256
from itertools import chain, product
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.settings.types import ExecMode

import stages
from stages.config.code import code_digest, cover, files_digest
from stages.config.demonstrations import MotionOptions
from stages.config.mistakes import check_keys
from stages.config.model import load, with_defaults
from stages.config.names import modules
from stages.config.packages import drawn_by, home_of, rule_files, shards_of
from stages.config.outside import online, outside
from stages.config.reads import options_of, stores
from stages.config.sizes import sized
from stages.contracts.corrections import CORRECTIONS, corrections_of
from stages.contracts.errors import InputError
from stages.contracts.training_sets import ROLE_NAME, SET_NAME
from stages.plugins import find, qualify_module
from stages.config.room_files import series

# The graph of jobs only grows: looking through it for garbage, the last time at the end, is a third of a plan's time.
gc.freeze()
gc.set_threshold(100_000, 100, 100)
atexit.register(gc.freeze)

# `.venv/bin/snakemake` works without activating the environment: jobs find its python first.
os.environ.update(PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]))

# As for `python -m`, packages of the user may lie in the working directory.
sys.path.append(os.getcwd())

try:
    for file in workflow.configfiles:
        check_keys(file)
    CONFIG = load(with_defaults(config))
    cover(CONFIG.plugins)
    OWN = shards_of(CONFIG)
    LIBRARY_SIZE = sum(CONFIG.assets.counts.values()) + sum(len(shard.models) for shard in OWN.values())
    CONFIG = sized(CONFIG, LIBRARY_SIZE)
except InputError as error:
    print(f"error: {error} [{error.code}]", file=sys.stderr)  # one line: Snakemake would add this file and its line
    sys.exit(1)

# Snakemake keeps copies of what `workflow.source_path` names, in a folder of its own.
PUBLISHED = str(Path([workflow.source_path(f"../report/published/table{n}.csv") for n in (2, 3)][0]).resolve().parent)
# What containers/podman-shell asks for: images, folders to mount, the network and keys, a GPU.
os.environ.update(
    ACDC_IMAGE=CONFIG.containers.template,
    ACDC_OUTSIDE="\n".join([*outside(CONFIG), PUBLISHED]),
    ACDC_PAPER=PUBLISHED,  # where the tables of the paper's values lie
    ACDC_CODE=str(Path(stages.__file__).resolve().parents[1]),
    ACDC_GPU=CONFIG.device.replace("cpu", ""),
)
os.environ.pop("ACDC_ONLINE", None)
if online(CONFIG) is not None:
    os.environ.update(ACDC_ONLINE=" ".join(online(CONFIG)))
EXPERIMENT = CONFIG.experiment
ROOMS = EXPERIMENT.rooms
SCORED_ROOMS = [room for room in ROOMS if room not in EXPERIMENT.inputs]
# The report shows a handful of the user's pictures; where there are more, the overview has them all.
MORE = [room for room in ROOMS if room in EXPERIMENT.inputs][8:]
SHOWN = [room for room in ROOMS if room not in set(MORE)]
MET = EXPERIMENT.met()
VARIANTS = list(EXPERIMENT.variants)
matching_of = cache(CONFIG.matching_of)  # asked for by every job of matching
TARGETS = list(EXPERIMENT.targets)
PINNED = {name: target.assets for name, target in EXPERIMENT.targets.items() if target.assets}
# Shards of the procedural models, or of what a command of the user's makes in their place.
PROCEDURAL = (
    CONFIG.assets.shards if any(CONFIG.assets.counts.values()) or "library" in CONFIG.stages.get("furniture", {}) else 0
)
SHARDS = [*map(str, range(PROCEDURAL)), *OWN]
# What packages beside the core add to the target `all`.
EVERYTHING = []
RANKS = list(range(1, CONFIG.generation.ranks + 1))
STORES = stores(CONFIG)


wildcard_constraints:
    scene=r"[A-Za-z0-9-]+(_[A-Za-z0-9-]+)*(\.(" + "|".join(EXPERIMENT.protocols) + r")\.\d+)?",
    variant=r"[A-Za-z0-9_-]+",
    store=r"[A-Za-z0-9_]+-[0-9a-f]{8}",
    target="|".join(TARGETS) or "-",
    policy="|".join(EXPERIMENT.policies) or "-",
    condition="|".join(CONFIG.evaluation.conditions) or "-",
    object=r"[^/]+",
    role=ROLE_NAME,
    training_set=SET_NAME,
    run=r"[A-Za-z0-9_-]+",
    seed=r"\d+",
    shard=r"\d+|own_\w+",


def files(patterns, **values):
    """Snakemake's `expand` for outputs of rules, also where a storage provider holds them; other wildcards stay."""
    found = []
    for pattern in [patterns] if isinstance(patterns, str) else patterns:
        names = pattern.get_wildcard_names()
        lists = {name: [value] if isinstance(value, (str, int)) else value for name, value in values.items()}
        for chosen in product(*(lists[name] for name in lists if name in names)):
            given = dict(zip((name for name in lists if name in names), chosen))
            found.append(pattern.apply_wildcards({name: f"{{{name}}}" for name in names} | given))
    return found


def options(stage, verb):
    """The --options of a verb, as JSON: what it reads of the config and no more, so that no other change runs it."""

    @cache
    def told(**wildcards):
        return json.dumps(options_of(CONFIG, stage, verb, wildcards), sort_keys=True)

    def found(wildcards):
        met = {"scene": "".join(wildcards.scene.partition(".")[1:])} if "scene" in wildcards.keys() else {}
        return told(**dict(wildcards) | met)  # of a scene only its protocol counts

    return found


def command(stage, verb):
    """The command line of a verb: ours, or the user's own if it is replaced, which ends with the workflow as ours do."""
    own = CONFIG.stages.get(stage, {}).get(verb)
    if own is None:
        return f"python -m {home_of(stage)} {verb}"
    guard = ["python", "-m", "plugins.ops.guard"] if CONFIG.packages.get("ops") else []
    return shlex.join([*guard, "bash", "-c", own.command + ' "$@"', verb])


def code(stage, verb, *used):
    """Digest of the code behind a verb and of the implementations it uses: an edit re-runs what uses it."""
    own = CONFIG.stages.get(stage, {}).get(verb)
    return files_digest(own.code) if own else code_digest(f"{home_of(stage)}.{verb}", *used)


def check(**outputs):
    """The command that refuses what breaks its contract, keeping it aside; `outputs`: kind of file = its output."""

    def line(wildcards, output):
        files = {kind: getattr(output, name) for kind, name in outputs.items()}
        named = [[kind, *([file] if isinstance(file, str) else file)] for kind, file in files.items()]
        return shlex.join(["python", "-m", "stages.contracts", "--refuse", *chain(*named)])

    return line


def paper(table):
    """Digest of a table of the paper's values, for the rules that read its copy in PUBLISHED."""
    return sha256(Path(PUBLISHED, f"{table}.csv").read_bytes()).hexdigest()[:12]
