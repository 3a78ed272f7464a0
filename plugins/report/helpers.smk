# Helpers of the pages. No rules.
import atexit
import subprocess
import sys
import time

from snakemake.settings.types import ExecMode

from roomkin.plugins.report.made import list_causes, name_pages

STARTED = time.time()

# What stands before `results/` and `benchmarks/` in a module with a prefix, and in a storage.
ROOT = str(rules.library.output.library).removesuffix("results/assets/library/library.json")


def own_pages(scenes):
    """The scenes' own pages that are there, or are asked for: other pages link to them."""
    asked, pages = "pages" in workflow.dag_settings.targets, expand("results/report/scenes/{scene}.html", scene=scenes)
    return [page for page in pages if asked or Path(ROOT + page).is_file()]


def tell_of_pages():
    """After a run, as its last line: where to look."""
    if workflow.exec_mode == ExecMode.DEFAULT and (line := name_pages(Path.cwd() / ROOT, STARTED)):
        atexit.register(print, line, file=sys.stderr)


def tell_of_failures(log):
    """After a failed run: why, below all that Snakemake says; of many scenes the same pages of what there is, too."""
    if workflow.exec_mode == ExecMode.DEFAULT and (causes := list_causes(log)[-8:]):
        atexit.register(print, *causes, sep="\n", file=sys.stderr)
    for variant in VARIANTS if FURTHER_ROOMS and workflow.exec_mode == ExecMode.DEFAULT else []:
        page = f"{ROOT}results/report/overview/{variant}.failed.html"
        line = shlex.split(command_line(CONFIG, "report", "overview"))
        subprocess.run([*line, "--variant", variant, "--out", page, "--scenes", *ROOMS])


def films_of(stage, name, found):
    """Films, which the user's command in the place of ours need not make."""
    return unless_replaced(stage, name, films=found).get("films", [])


SCENE_TARGETS = TARGETS if EXPERIMENT.in_scene and CONFIG.packages.get("in_scene") else []
DEMO_FILMS = films_of(
    "demonstrations",
    "collect",
    expand("results/demonstrations/{target}/{role}/films.zip", zip, **DEMONSTRATED),
)
SCENE_FILMS = films_of(
    "in_scene", "demonstrate", expand("results/demonstrations/{target}/in_scene/films.zip", target=SCENE_TARGETS)
)
ROLLOUT_FILMS = films_of(
    "evaluation",
    "rollout",
    policies("results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/films.zip", count=1),
)
# Benchmark files cannot be inputs: those of this run are named to the page, so that it counts no others.
POSSIBLE = columns(
    "target",
    "policy",
    "training_set",
    "run",
    "seed",
    rows=[
        (*cell, run, seed)
        for cell in EXPERIMENT.cells
        for plan in [EXPERIMENT.plan(cell.policy)]
        for run in plan.configs
        for seed in plan.seeds
    ],
)
MATCHED = columns(
    "room",
    "object",
    rows=[(target.room, target.object) for name, target in EXPERIMENT.targets.items() if name not in PINNED],
)
BENCHMARKS = [
    *expand("benchmarks/assets/procedural_{shard}.tsv", shard=PROCEDURAL_SHARDS),
    *expand("benchmarks/assets/{shard}.tsv", shard=OWN_SHARDS),
    *expand("benchmarks/assets/snapshots_{shard}.tsv", shard=SHARDS),
    *expand("benchmarks/scenes/{room}.tsv", room=SCORED_ROOMS),
    *expand("benchmarks/extraction/{scene}.tsv", scene=REPORT_ROOMS),
    *expand("benchmarks/matching/features_{store}_{shard}.tsv", store=STORES, shard=SHARDS),
    *expand("benchmarks/matching/{variant}_{scene}.tsv", variant=VARIANTS, scene=REPORT_ROOMS),
    *expand("benchmarks/generation/{variant}_{scene}.tsv", variant=VARIANTS, scene=REPORT_ROOMS),
    *expand("benchmarks/generation/draw_{variant}_{scene}.tsv", variant=VARIANTS, scene=REPORT_ROOMS),
    *expand("benchmarks/evaluation/{variant}_{room}.tsv", variant=VARIANTS, room=SCORED_ROOMS),
    *expand("benchmarks/experiment/{variant}_{target}.tsv", variant=POLICY_VARIANT, target=TARGETS),
    *expand(f"benchmarks/matching/distances_{POLICY_VARIANT}_{{room}}_{{object}}.tsv", zip, **MATCHED),
    *expand("benchmarks/demonstrations/{target}_{role}.tsv", zip, **DEMONSTRATED),
    *expand("benchmarks/demonstrations/{target}_in_scene.tsv", target=SCENE_TARGETS),
    *expand("benchmarks/evaluation/skill_{target}.tsv", target=TRAINED_TARGETS),
    *expand("benchmarks/training/{target}_{policy}_{training_set}_{run}_{seed}.tsv", zip, **POSSIBLE),
    *expand("benchmarks/evaluation/trial_{target}_{policy}_{training_set}_{run}_{seed}.tsv", zip, **POSSIBLE),
    *expand("benchmarks/evaluation/{target}_{policy}_{training_set}_{run}_{seed}.tsv", zip, **POSSIBLE),
    *expand("benchmarks/{stage}/{scene}.tsv", stage=["scenes", "extraction"], scene=PERTURBED_SCENES["scene"]),
    *expand("benchmarks/matching/{variant}_{scene}.tsv", zip, **PERTURBED_SCENES),
    *expand("benchmarks/generation/{variant}_{scene}.tsv", zip, **PERTURBED_SCENES),
    *expand("benchmarks/evaluation/{variant}_{scene}.tsv", zip, **PERTURBED_SCENES),
    *expand("benchmarks/tables/{table}.tsv", table=["table2", "table3"]),
]
